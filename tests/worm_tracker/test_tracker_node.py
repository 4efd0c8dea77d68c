"""The tracker's node: every picture that comes is one state that goes, numbered, and the end."""

from dataclasses import replace

import numpy as np
import pytest
from crawling_worm import FRAME_NS, SMALL_RIG, crawl, film, wavy_path
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import UInt64, UInt64MultiArray
from std_srvs.srv import Trigger

from worm_model.simulator.film import encode
from worm_msgs_py import Status, convert, topics
from worm_msgs_py.errors import BadInput, NoChamberFound
from worm_msgs_py.files.corrections import corrections_to_json, requested
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, IMAGE_REPLAY
from worm_msgs_py.ros.qos import RESULT as RESULT_QOS
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.source_node import drain
from worm_tracker.tracker import Tracker
from worm_tracker.tracker_node import TrackerNode


class Bench:
    """A tracker node, a source and ears on everything that it says."""

    def __init__(self, context, **parameters):
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.tracker = TrackerNode(context=context, parameter_overrides=overrides)
        self.node = Node("bench", context=context, start_parameter_services=False)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.tracker)
        self.executor.add_node(self.node)
        self.heard = {}
        for topic, (kind, qos) in RESULTS.items():
            self.listen(kind, topic, qos)
        self.listen(UInt64MultiArray, topics.FLOW_TRACKED, FLOW)
        self.listen(DiagnosticArray, topics.DIAGNOSTICS, RESULT_QOS)
        self.raw = self.node.create_publisher(Image, topics.IMAGE, IMAGE_REPLAY)
        self.compressed = self.node.create_publisher(
            CompressedImage, topics.IMAGE_COMPRESSED, IMAGE_REPLAY
        )
        self.ends = self.node.create_publisher(UInt64, topics.FLOW_END, FLOW)

    def listen(self, kind, topic, qos):
        said = self.heard.setdefault(topic, [])
        self.node.create_subscription(kind, topic, said.append, qos)

    def send(self, publisher, message):
        publisher.publish(message)
        drain(self.executor)

    def end(self, frames):
        self.send(self.ends, convert.count_to_msg(frames))

    def states(self):
        return [convert.body_state_from_msg(msg) for msg in self.heard[topics.WORM_STATE]]

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.tracker.destroy_node()


@pytest.fixture
def bench(ros_context):
    made = []

    def make(**parameters):
        made.append(Bench(ros_context, **parameters))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture(scope="module")
def pictures():
    bodies = crawl(wavy_path(SMALL_RIG), 110.0, 12.0, 110.0 + 3.0 * np.arange(25))
    return film(SMALL_RIG, bodies)


def message(picture, frame):
    return convert.picture_to_msg(picture, frame * FRAME_NS, "camera_optical_frame")


def test_the_node_says_what_the_core_says(bench, pictures):
    core = Tracker(TrackerParameters())
    told = []
    for frame, picture in enumerate(pictures):
        told += core.push(picture, frame * FRAME_NS)
    told += core.finish()
    stand = bench()
    for frame, picture in enumerate(pictures):
        stand.send(stand.raw, message(picture, frame))
    stand.end(len(pictures))
    assert stand.tracker.done
    assert stand.tracker.missing == ""
    assert repr(stand.states()) == repr([tracked.state for tracked in told])
    for topic in (topics.WORM_HEAD, topics.WORM_CENTROID, topics.WORM_TAIL, topics.WORM_MIDLINE):
        assert len(stand.heard[topic]) == len(pictures)
    (geometry,) = stand.heard[topics.CHAMBER_GEOMETRY]
    assert convert.geometry_from_msg(geometry) == core.geometry
    assert len(stand.heard[topics.CHAMBER]) == 1
    taken_given = [convert.counts_from_msg(msg) for msg in stand.heard[topics.FLOW_TRACKED]]
    assert [taken for taken, _ in taken_given[: len(pictures)]] == list(range(1, 26))
    assert tuple(taken_given[-1]) == (25, 25)


def test_the_end_may_come_before_the_last_pictures(bench, pictures):
    stand = bench()
    stand.end(10)
    for frame, picture in enumerate(pictures[:10]):
        assert not stand.tracker.done
        stand.send(stand.raw, message(picture, frame))
    assert stand.tracker.done
    assert len(stand.states()) == 10


def swap_head(stand):
    """Call the service as an operator would; return its answer."""
    client = stand.node.create_client(Trigger, "/tracker/swap_head")
    assert client.wait_for_service(timeout_sec=60.0)
    future = client.call_async(Trigger.Request())
    stand.executor.spin_until_future_complete(future, timeout_sec=60.0)
    drain(stand.executor)
    return future.result()


def test_an_operator_exchanges_head_and_tail_for_the_rest_of_the_trial(bench, pictures):
    stand = bench(hold_back_frames=2)
    answer = swap_head(stand)
    assert not answer.success
    assert answer.message == "no worm has been seen yet"
    for frame, picture in enumerate(pictures[:20]):
        stand.send(stand.raw, message(picture, frame))
    before = stand.states()[-1]
    first = before.frame + 1
    answer = swap_head(stand)
    assert answer.success
    assert answer.message == f"head and tail are exchanged from frame {first} on"
    for frame, picture in enumerate(pictures[20:], 20):
        stand.send(stand.raw, message(picture, frame))
    stand.end(len(pictures))
    after = stand.states()[-1]
    assert after.head.u_px == pytest.approx(before.tail.u_px, abs=25)
    assert after.head.v_px == pytest.approx(before.tail.v_px, abs=25)
    told = [
        {item.key: item.value for item in status.values}
        for report in stand.heard[topics.DIAGNOSTICS]
        for status in report.status
        if status.name == "tracker: head and tail"
    ]
    assert [(values["kind"], values["frame"]) for values in told] == [("correction", str(first))]
    assert swap_head(stand).message == "the trial has ended"
    (event,) = [
        event
        for msg in stand.heard[topics.SOURCE_EVENTS]
        for event in convert.source_events_from_msg(msg)
    ]
    asked = requested(event)
    assert (asked.first_frame, asked.first_stamp_ns) == (19, 19 * FRAME_NS)
    assert asked.note == answer.message
    again = bench(hold_back_frames=2, corrections=corrections_to_json([asked]))
    for frame, picture in enumerate(pictures):
        again.send(again.raw, message(picture, frame))
    again.end(len(pictures))
    assert repr(again.states()) == repr(stand.states())
    assert again.heard[topics.SOURCE_EVENTS] == []


def test_a_damaged_picture_is_a_frame_with_its_status(bench, pictures):
    stand = bench()
    for frame, picture in enumerate(pictures[:8]):
        data = encode(picture, 90)
        msg = CompressedImage(format="jpeg")
        msg.header = message(picture, frame).header
        msg.data = data[: len(data) // 20] if frame == 5 else data
        stand.send(stand.compressed, msg)
    stand.end(8)
    states = stand.states()
    assert [state.frame for state in states] == list(range(8))
    bad = [state.frame for state in states if state.status is Status.BAD_IMAGE]
    assert bad == [5]
    (status,) = stand.heard[topics.DIAGNOSTICS][-1].status
    values = {item.key: item.value for item in status.values}
    assert values["frames in"] == values["frames out"] == "8"
    assert values["status bad_image"] == "1"
    assert status.message == "ended"


def test_no_chamber_ends_the_node(bench):
    stand = bench(calibration_frames=2)
    rng = np.random.default_rng(0)
    plain = rng.integers(190, 200, (128, 128), np.uint8)
    stand.send(stand.raw, message(plain, 0))
    with pytest.raises(NoChamberFound, match="--no-chamber"):
        stand.send(stand.raw, message(plain, 1))


def test_a_parameter_out_of_range_is_refused(ros_context):
    with pytest.raises(BadInput, match="polarity"):
        TrackerNode(
            context=ros_context, parameter_overrides=[Parameter("polarity", value="purple")]
        )


def test_a_bump_is_said_before_the_first_state_that_rests_on_it(bench):
    aside = replace(SMALL_RIG, centre_px=(SMALL_RIG.centre_px[0] + 5.0, SMALL_RIG.centre_px[1]))
    heads = 320.0 + 2.0 * np.arange(9)
    before, after = (crawl(wavy_path(rig), 110.0, 12.0, heads) for rig in (SMALL_RIG, aside))
    shown = film(SMALL_RIG, before[:5]) + film(aside, after[5:])
    stand = bench()
    for frame, picture in enumerate(shown):
        stand.send(stand.raw, message(picture, frame))
    stand.end(len(shown))
    first, second = map(convert.geometry_from_msg, stand.heard[topics.CHAMBER_GEOMETRY])
    assert (first.version, second.version) == (1, 2)
    assert second.stamp_ns == 5 * FRAME_NS
    assert [state.geometry for state in stand.states()] == [1] * 5 + [2] * 4
    said = {v.key: v.value for v in stand.heard[topics.DIAGNOSTICS][-1].status[0].values}
    assert said["geometry version"] == "2"
    assert "moved by 5.0 px" in said["geometry changed because"]
