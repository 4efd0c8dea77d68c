"""The recorder: one row a frame, whatever the order of arrival, and never a whole-looking part."""

import json

import pyarrow.parquet as pq
import pytest
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.parameter import Parameter
from rosbags.rosbag2 import Reader
from std_msgs.msg import Float64MultiArray, UInt64

from worm_analysis.results.tracks import SCHEMA as TRACKS
from worm_bringup.freed_memory import give_back_freed_memory
from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC
from worm_bringup.recorder import recorder_node
from worm_bringup.recorder.recorder_node import RecorderNode
from worm_bringup.recorder.recording import Recording
from worm_msgs_py import (
    Attempt,
    BodyState,
    Episode,
    EpisodeKind,
    Midline,
    Observables,
    Quantity,
    Status,
    Visit,
    convert,
    topics,
)
from worm_msgs_py.ros.counting_publisher import Ledger
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, LATCHED_SET_DEPTH
from worm_msgs_py.ros.worm_node import WormNode

EVENTS = (
    Episode("chamber_a", EpisodeKind.CONTACT, 1, 2, 1.95e-3),
    Visit("chamber_a", 1, 2, None, 0.1, 12.5, 3),
    Attempt("chamber_a", 1, 2, 2e-3, False, None),
)


def frame_parts(frame):
    stamp_ns = 10**9 + frame * 40_000_000
    status = Status.TRACKED if frame % 3 else Status.NO_WORM
    return (
        BodyState(frame=frame, stamp_ns=stamp_ns, status=status),
        Midline.empty(),
        Observables(frame=frame, stamp_ns=stamp_ns, psi_b_rad=0.5, contact=None),
    )


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2)], ids=str)
def test_rows_come_in_the_order_of_frames_whatever_topic_comes_first(tmp_path, order):
    recording = Recording(tmp_path)
    adders = (recording.add_state, recording.add_midline, recording.add_observables)
    parts = [frame_parts(frame) for frame in range(5)]
    for kind in order:
        for part in parts:
            adders[kind](part[kind])
    recording.trial.frames_read = 5
    recording.finish({})
    table = pq.read_table(tmp_path / "tracks.parquet")
    assert table.schema.names == TRACKS.names
    assert table["frame"].to_pylist() == [0, 1, 2, 3, 4]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["frames"] == {"read": 5, "tracked": 3, "no_worm": 2}
    assert summary["complete"] is True


def test_a_frame_without_a_row_is_an_error_and_leaves_no_summary(tmp_path):
    recording = Recording(tmp_path)
    recording.add_state(frame_parts(0)[0])
    recording.trial.frames_read = 1
    with pytest.raises(RuntimeError, match="1 frames were read but 0"):
        recording.finish({})
    assert not (tmp_path / "summary.json").exists()


def test_lengths_are_millimetres_and_angles_degrees(tmp_path):
    recording = Recording(tmp_path)
    recording.add_events(EVENTS)
    for adder, part in zip(
        (recording.add_state, recording.add_midline, recording.add_observables),
        frame_parts(0),
        strict=True,
    ):
        adder(part)
    recording.trial.frames_read = 1
    recording.finish({})
    assert pq.read_table(tmp_path / "tracks.parquet")["psi_b_deg"][0].as_py() == pytest.approx(
        28.6478898
    )
    contact = pq.read_table(tmp_path / "contacts.parquet").to_pylist()[0]
    assert contact["distance_mm"] == pytest.approx(1.95)
    visit, attempt = pq.read_table(tmp_path / "passages.parquet").to_pylist()
    assert (visit["record"], visit["skips"], visit["first_contact_ns"]) == ("visit", 3, None)
    assert (attempt["record"], attempt["penetration_mm"]) == ("attempt", pytest.approx(2.0))


class Sender(WormNode):
    """Stands for tracker and analysis: sends what they send, through the same ledger."""

    def __init__(self, context):
        super().__init__("sender", context=context)
        self.ledger = Ledger(self)
        self.results = {
            topic: self.ledger.publisher(kind, topic, qos) for topic, (kind, qos) in RESULTS.items()
        }
        self.end = self.create_publisher(UInt64, topics.FLOW_END, FLOW)

    def send_frame(self, frame):
        state, midline, observables = frame_parts(frame)
        self.results[topics.WORM_STATE].publish(convert.body_state_to_msg(state))
        self.results[topics.WORM_MIDLINE].publish(convert.midline_to_msg(midline, state))
        self.results[topics.ANALYSIS_STATE].publish(convert.observables_to_msg(observables))


def drain(executor):
    """Run every callback that is ready until a whole pass finds none."""
    while True:
        found = False
        try:
            while True:
                handler, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0)
                handler()
                if handler.exception() is not None:
                    raise handler.exception()
                found = True
        except TimeoutException:
            pass
        if not found:
            return


@pytest.fixture
def graph(ros_context, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    recorder = RecorderNode(
        context=ros_context,
        parameter_overrides=[
            Parameter("out", value=str(out)),
            Parameter("expect", value=["sender"]),
            Parameter("provenance", value='{"bag": "x"}'),
        ],
    )
    sender = Sender(ros_context)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(recorder)
    executor.add_node(sender)
    yield recorder, sender, executor, out
    executor.shutdown()
    recorder.destroy_node()
    sender.destroy_node()


def test_the_recorder_is_done_when_it_holds_all_that_was_sent(graph):
    recorder, sender, executor, out = graph
    burst = 600  # the tracker may give many states at once
    for frame in range(burst):
        sender.send_frame(frame)
    sender.results[topics.ANALYSIS_EVENTS].publish(convert.events_to_msg(EVENTS, 5))
    quantity = Quantity("d_c", 1.9, 1.8, 2.0, 100, "mm", 1.95)
    sender.results[topics.ANALYSIS_SUMMARY].publish(convert.quantities_to_msg([quantity], 5))
    sender.end.publish(convert.count_to_msg(burst))
    drain(executor)
    assert not recorder.done
    assert recorder.missing == "sender has not finished"
    sender.ledger.announce()
    drain(executor)
    assert recorder.done
    summary = json.loads((out / "summary.json").read_text())
    assert summary["frames"]["read"] == burst
    assert summary["quantities"]["d_c"]["value"] == 1.9
    assert summary["provenance"] == {"bag": "x"}
    assert pq.read_metadata(out / "tracks.parquet").num_rows == burst
    assert (out / "bag" / "metadata.yaml").exists()


def test_what_is_noted_while_the_trial_runs_is_in_the_summary_with_its_frame(graph):
    recorder, sender, executor, out = graph
    sender.send_frame(0)
    drain(executor)
    for name, value in (("animal", "worm 7"), ("temperature_c", 21), ("animal", "worm 8")):
        (result,) = recorder.set_parameters([Parameter(name, value=value)])
        assert result.successful, result.reason
    (result,) = recorder.set_parameters([Parameter("date", value="yesterday")])
    assert "give year, month and day" in result.reason
    sender.send_frame(1)
    sender.end.publish(convert.count_to_msg(2))
    sender.ledger.announce()
    drain(executor)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["provenance"] == {
        "bag": "x",
        "trial": {"animal": "worm 8", "temperature_c": 21.0},
    }
    told = [(event["frame"], event["why"]) for event in summary["source_events"]]
    assert sorted(told) == [
        (1, "recorder: animal changed from '' to 'worm 7'"),
        (1, "recorder: animal changed from 'worm 7' to 'worm 8'"),
        (1, "recorder: temperature_c changed from nan to 21.0"),
    ]
    assert {event["stamp_ns"] for event in summary["source_events"]} == {frame_parts(0)[0].stamp_ns}
    (result,) = recorder.set_parameters([Parameter("animal", value="worm 9")])
    assert result.reason == "the trial has ended"


def test_notes_do_not_change_where_a_run_could_go_on_without_them(graph):
    recorder = graph[0]
    recorder.journal = []
    (result,) = recorder.set_parameters([Parameter("animal", value="worm 9")])
    assert "give a rig file" in result.reason


def test_freed_memory_is_given_back_again_and_again_without_a_word_in_the_results(
    graph, tmp_path, monkeypatch
):
    recorder, sender, executor, out = graph
    rows_then = []

    def give_back():
        rows_then.append(recorder._recording.rows)
        give_back_freed_memory()

    monkeypatch.setattr(recorder_node, "give_back_freed_memory", give_back)
    monkeypatch.setattr(recorder_node, "_TRIM_EVERY_FRAMES", 20)
    for frame in range(90):
        sender.send_frame(frame)
    sender.end.publish(convert.count_to_msg(90))
    sender.ledger.announce()
    drain(executor)
    assert recorder.done
    assert rows_then == [20, 40, 60, 80]

    (alone := tmp_path / "alone").mkdir()
    recording = Recording(alone)  # which gives nothing back
    for frame in range(90):
        state, midline, observables = frame_parts(frame)
        recording.add_state(state)
        recording.add_midline(midline)
        recording.add_observables(observables)
    recording.close()
    assert (out / "tracks.parquet").read_bytes() == (alone / "tracks.parquet").read_bytes()


def test_a_burst_of_estimates_is_not_lost(graph):
    recorder, sender, executor, _ = graph
    for _ in range(LATCHED_SET_DEPTH):
        sender.results[topics.ANALYSIS_DISTRIBUTIONS].publish(Float64MultiArray())
    sender.send_frame(0)
    sender.end.publish(convert.count_to_msg(1))
    sender.ledger.announce()
    drain(executor)
    assert recorder.missing == ""
    assert recorder.done


def test_a_message_that_was_sent_and_did_not_come_is_named(graph):
    recorder, sender, executor, out = graph
    sender.send_frame(0)
    sender.ledger.sent[topics.ANALYSIS_EVENTS] += 1
    sender.end.publish(convert.count_to_msg(1))
    sender.ledger.announce()
    drain(executor)
    assert not recorder.done
    assert recorder.missing == "sender sent 1 on analysis/events, 0 came"
    assert not (out / "summary.json").exists()


def test_the_results_bag_can_be_read_and_holds_every_message(graph):
    _, sender, executor, out = graph
    for frame in range(3):
        sender.send_frame(frame)
    sender.end.publish(convert.count_to_msg(3))
    sender.ledger.announce()
    drain(executor)
    with Reader(out / "bag") as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
        assert set(counts) == {"/" + topic for topic in (*RESULTS, *TYPE_OF_TOPIC)}
        assert counts["/worm/state"] == counts["/analysis/state"] == 3
