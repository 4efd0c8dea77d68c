"""When pictures are due, and what the replay node does when it is told to wait."""

import math
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from picture_bags import START_NS, number_of, stamps, write_bag
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image
from std_msgs.msg import UInt64, UInt64MultiArray
from std_srvs.srv import Trigger

from worm_msgs_py import SourceEvent, SourceEventKind, convert, topics
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, IMAGE_REPLAY
from worm_tracker.sources.bags.bag_reader import BagPicture
from worm_tracker.sources.bags.serialized_images import stamp_of
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.sources.playback import Playback, in_a_loop
from worm_tracker.sources.replay_node import ReplayNode
from worm_tracker.sources.source_node import drain

SECOND = 10**9


@given(st.floats(0.1, 10.0), st.lists(st.integers(1, 5 * SECOND), min_size=1, max_size=20))
def test_a_recording_takes_its_duration_over_the_rate(rate, intervals):
    playback, now_s = Playback(rate), 100.0
    times = START_NS + np.cumsum([0, *intervals])
    for stamp_ns in times:
        now_s += playback.wait_s(int(stamp_ns), now_s)
        playback.played(int(stamp_ns), now_s)
    assert now_s - 100.0 == pytest.approx((times[-1] - times[0]) / 1e9 / rate, rel=1e-6)


def test_at_rate_zero_nothing_waits():
    playback = Playback(0.0)
    playback.played(0, 0.0)
    assert playback.wait_s(10**15, 0.0) == 0.0


def test_a_player_that_falls_behind_catches_up():
    playback = Playback(1.0)
    playback.played(0, 0.0)
    assert playback.wait_s(1 * SECOND, 5.0) == 0.0
    assert playback.wait_s(6 * SECOND, 5.0) == pytest.approx(1.0)


@given(st.sampled_from([0.0, 0.5, 1.0, 4.0]), st.sampled_from([0.0, 0.25, 2.0]))
def test_another_rate_holds_from_the_last_picture_on(before, after):
    playback = Playback(before)
    for second in range(4):
        playback.played(second * SECOND, 50.0)  # as fast as can be, or long behind
    playback.set_rate(after, 50.0)
    assert playback.wait_s(5 * SECOND, 50.0) == (2.0 / after if after else 0.0)
    assert playback.wait_s(5 * SECOND, 51.0) == (max(0.0, 2.0 / after - 1.0) if after else 0.0)


def test_a_rate_may_be_set_before_the_first_picture_and_while_paused():
    playback = Playback(0.0, paused=True)
    playback.set_rate(2.0, 1.0)
    assert playback.wait_s(0, 1.0) == math.inf
    playback.resume(3.0)
    playback.played(0, 3.0)
    assert playback.wait_s(SECOND, 3.0) == pytest.approx(0.5)


def test_a_pause_delays_what_comes_after_it_by_its_length():
    playback = Playback(1.0)
    playback.played(0, 10.0)
    playback.pause(10.4)
    assert playback.wait_s(1 * SECOND, 12.0) == math.inf
    playback.resume(20.4)
    assert playback.wait_s(1 * SECOND, 20.4) == pytest.approx(0.6)


def test_a_step_lets_one_picture_through_and_the_clock_goes_on_from_it():
    playback = Playback(1.0, paused=True)
    assert playback.wait_s(0, 0.0) == math.inf
    for k in range(3):
        assert playback.play_next()
        assert playback.wait_s(k * SECOND, 7.0) == 0.0
        playback.played(k * SECOND, 7.0)
        assert playback.wait_s((k + 1) * SECOND, 7.0) == math.inf
    playback.resume(50.0)
    assert playback.wait_s(3 * SECOND, 50.0) == pytest.approx(1.0)
    assert not playback.play_next()


@given(st.sampled_from([0.0, 0.5, 1.0]), st.booleans(), st.integers(1, 19))
def test_what_is_sought_is_played_to_at_once_and_the_player_pauses_there(rate, paused, second):
    playback = Playback(rate, paused=paused)
    playback.seek(second - 0.5)
    for k in range(second):
        assert playback.seeks
        assert playback.wait_s(k * SECOND, 3.0) == 0.0
        playback.played(k * SECOND, 3.0)
    playback.played(second * SECOND, 3.0)
    assert playback.paused
    assert not playback.seeks
    assert playback.wait_s((second + 1) * SECOND, 99.0) == math.inf
    playback.resume(100.0)
    later_s = playback.wait_s((second + 1) * SECOND, 100.0)
    assert later_s == pytest.approx(1 / rate if rate else 0.0)


@pytest.mark.parametrize("ends", [Playback.pause, Playback.stop_seeking, Playback.resume])
def test_a_seek_that_is_broken_off_goes_on_from_the_last_picture(ends):
    playback = Playback(1.0)
    playback.played(0, 0.0)
    playback.seek(50.0)
    playback.played(3 * SECOND, 0.1)
    ends(playback, 10.0)
    assert not playback.seeks
    assert playback.paused == (ends is not Playback.resume)
    playback.resume(20.0)
    assert playback.wait_s(14 * SECOND, 20.0) == pytest.approx(
        1.0 if ends is Playback.resume else 11.0
    )


@pytest.mark.parametrize("rate", [-1.0, math.inf, math.nan])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(ValueError, match="rate"):
        Playback(rate)


@given(st.lists(st.integers(1, SECOND), max_size=6), st.integers(1, 25))
def test_stamps_go_on_growing_in_a_loop(intervals, count):
    times = np.cumsum([START_NS, *intervals])
    recording = [BagPicture(int(t), i, b"\0\1\0\0" + bytes(60)) for i, t in enumerate(times)]
    played = list(islice(in_a_loop(recording), count))
    assert len(played) == count
    assert (np.diff([picture.stamp_ns for picture in played]) > 0).all()
    assert [stamp_of(picture.raw) for picture in played] == [p.stamp_ns for p in played]
    assert [picture.index for picture in played] == [k % len(times) for k in range(count)]


def test_the_round_is_one_interval_longer_than_the_recording():
    recording = [BagPicture(t, i, b"\0\1\0\0" + bytes(60)) for i, t in enumerate(stamps(4))]
    assert [p.stamp_ns for p in islice(in_a_loop(recording), 12)] == stamps(12)


def test_an_empty_recording_ends_a_loop():
    assert list(in_a_loop([])) == []


@pytest.fixture
def stage(tmp_path, ros_context):
    """A replay node, and a node that looks at it and calls its services."""

    class Stage:
        def __init__(self, **parameters):
            overrides = [
                Parameter(name, value=value)
                for name, value in {
                    "bag": str(write_bag(tmp_path / "bag", 6)),
                    **parameters,
                }.items()
            ]
            self.replay = ReplayNode(context=ros_context, parameter_overrides=overrides)
            self.viewer = Node("viewer", context=ros_context, start_parameter_services=False)
            self.numbers, self.stamps = [], []
            self.viewer.create_subscription(Image, topics.IMAGE, self.on_image, IMAGE_REPLAY)
            self.executor = SingleThreadedExecutor(context=ros_context)
            for node in (self.replay, self.viewer):
                self.executor.add_node(node)

        def on_image(self, msg):
            self.numbers.append(number_of(PictureDecoder().decode(msg)))
            self.stamps.append(convert.stamp_to_ns(msg.header.stamp))

        def call(self, name):
            client = self.viewer.create_client(Trigger, f"image_source/{name}")
            future = client.call_async(Trigger.Request())
            drain(self.executor)
            assert future.done()
            return future.result().success

        def run(self):
            """Publish what is due."""
            while self.replay.wait_s() == 0.0 and self.replay.publish_next():
                drain(self.executor)

        def close(self):
            self.executor.shutdown()
            self.replay.destroy_node()
            self.viewer.destroy_node()

    stages = []

    def make(**parameters):
        stages.append(Stage(**parameters))
        return stages[-1]

    yield make
    for made in stages:
        made.close()


def test_a_paused_player_plays_picture_by_picture(stage):
    player = stage(start_paused=True)
    assert player.call("is_paused")
    player.run()
    assert player.numbers == []
    for _ in range(2):
        assert player.call("play_next")
        player.run()
    assert player.numbers == [0, 1]
    assert player.call("resume")
    assert not player.call("is_paused")
    assert not player.call("play_next")
    player.run()
    assert player.numbers == [0, 1, 2, 3, 4, 5]
    assert player.stamps == stamps(6)
    assert player.replay.done


def test_pause_and_toggle(stage):
    player = stage()
    assert player.call("pause")
    player.run()
    assert player.numbers == []
    assert player.call("toggle_paused")
    assert not player.call("is_paused")
    player.run()
    assert player.numbers == [0, 1, 2, 3, 4, 5]
    assert player.call("toggle_paused")
    assert player.call("is_paused")
    assert not player.call("play_next")  # there is nothing left


def test_a_seek_leaves_no_picture_out_and_goes_forward_alone(stage):
    player = stage(rate=1e-3)  # by itself a picture would not come in a test's time
    times = [(stamp - stamps(6)[0]) / 1e9 for stamp in stamps(6)]

    def seek(second):
        return player.replay.set_parameters([Parameter("seek_to", value=second)])[0]

    assert seek(times[3]).successful
    player.run()
    assert player.numbers == [0, 1, 2, 3]
    assert player.call("is_paused")
    back = seek(times[2])
    assert not back.successful
    assert "forward" in back.reason
    assert seek(times[5] + 100.0).successful
    player.run()
    assert player.numbers == [0, 1, 2, 3, 4, 5]
    assert not player.replay.done  # the end waits for whoever looks at it
    assert player.call("resume")
    player.run()
    assert player.replay.done


def test_the_window_closes_until_frames_are_taken_and_recorded(stage):
    player = stage(window=2)
    replay = player.replay
    tracked = player.viewer.create_publisher(UInt64MultiArray, topics.FLOW_TRACKED, FLOW)
    recorded = player.viewer.create_publisher(UInt64, topics.FLOW_RECORDED, FLOW)

    def report(taken, given, stored):
        tracked.publish(convert.counts_to_msg((taken, given)))
        recorded.publish(convert.count_to_msg(stored))
        drain(player.executor)
        return replay.in_flight, replay.window_is_open

    assert report(0, 0, 0) == (0, True)
    replay.publish_next()
    assert replay.window_is_open
    replay.publish_next()
    assert not replay.window_is_open
    assert report(1, 1, 0) == (2, False)  # taken and given, and not yet recorded
    assert report(1, 1, 1) == (1, True)
    assert report(2, 1, 1) == (0, True)  # the tracker holds the second one back
    replay.publish_next()
    replay.publish_next()
    assert report(2, 1, 40) == (2, False)  # the recorder's report overtook the tracker's


def test_a_rate_that_is_set_while_it_plays_is_told_and_after_the_end_refused(stage):
    player = stage()
    told = []
    kind, qos = RESULTS[topics.SOURCE_EVENTS]
    take = lambda msg: told.extend(convert.source_events_from_msg(msg))  # noqa: E731
    player.viewer.create_subscription(kind, topics.SOURCE_EVENTS, take, qos)

    def set_rate(value):
        client = player.viewer.create_client(SetParameters, "image_source/set_parameters")
        asked = Parameter("rate", value=value).to_parameter_msg()
        future = client.call_async(SetParameters.Request(parameters=[asked]))
        drain(player.executor)
        return future.result().results[0]

    for _ in range(2):
        player.replay.publish_next()
    assert set_rate(500).successful  # a whole number is a number
    assert set_rate(500.0).successful  # no change: nothing to tell
    assert "give 0, or 0.001 to 1000" in set_rate(2000.0).reason
    while player.replay.publish_next():
        drain(player.executor)
    assert player.numbers == [0, 1, 2, 3, 4, 5]
    (event,) = told
    assert event == SourceEvent(
        SourceEventKind.PARAMETER_CHANGED,
        2,
        stamps(6)[1],
        "image_source: rate changed from 0.0 to 500.0",
    )
    assert set_rate(1.0).reason == "the trial has ended"
    assert player.replay.get_parameter("rate").value == 500.0
