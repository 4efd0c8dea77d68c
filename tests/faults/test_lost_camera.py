"""A lost camera is looked for, told at once, and never looks like the end of a whole trial."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mjpeg_server import jpeg_picture, mjpeg_server
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_bringup.trial import EndedEarly, Incomplete, WithoutPose
from worm_msgs_py import SourceEventKind
from worm_msgs_py.contract.source_events import SourceEvent, in_words, read_source_events
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.cameras import camera as camera_module
from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.cameras.steady_clock import SteadyClock
from worm_tracker.sources.source_node import spin_source

WAYS = [
    pytest.param(run_in_process, id="one process"),
    pytest.param(run_in_processes, id="a process each"),
]
QUICK = {"reconnect_delay": 0.01}


@pytest.fixture(autouse=True)
def stand_ins_can_be_imported(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1] / "support"))


def graph(out, **source):
    return (
        NodeSpec("worm_tracker.sources.camera_node", "image_source", QUICK | source),
        [
            NodeSpec("standin_tracker_node", "tracker"),
            NodeSpec("standin_recorder_node", "recorder", {"out": out}),
        ],
    )


def watch(context, address, **parameters):
    """Run a camera node alone to its end; return it with the events that it told."""
    node = CameraNode(
        context=context,
        parameter_overrides=[
            Parameter(name, value=value)
            for name, value in ({"camera": address} | QUICK | parameters).items()
        ],
    )
    events = []
    tell = node._tell
    node._tell = lambda event: (events.append(event), tell(event))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        assert spin_source(executor, node, lambda: True, heed_window=False)
    finally:
        executor.shutdown()
        node.destroy_node()
    return node, events


def live(tmp_path, address, *more):
    """`worm live` of small pictures without a chamber; return what it gave."""
    options = ["live", "--camera", address, "--no-chamber", "--private", *more]
    return CliRunner().invoke(app, [*options, "--out", str(tmp_path / "out")])


def test_an_outage_is_told_with_its_length_and_the_attempts(ros_context, capfd):
    with mjpeg_server(20, -1, -1, 20, pause_s=0.001) as address:
        node, events = watch(ros_context, address, reconnect=1.0)
    outage, end = events
    assert (outage.kind, end.kind) == (SourceEventKind.OUTAGE, SourceEventKind.ENDED_EARLY)
    assert outage.count == 3
    assert 0.03 <= outage.duration_s < 20.0
    assert 0 < outage.frame < node.sent
    assert "it came back" in outage.why
    said = capfd.readouterr().err.splitlines()
    assert sum("it is looked for until 1 s have passed" in line for line in said) == 2
    assert sum("it came back" in line for line in said) == 1
    assert sum("the camera is lost" in line for line in said) == 1


@pytest.mark.parametrize("run", WAYS)
def test_a_camera_that_does_not_come_back_ends_the_trial_before_its_time(tmp_path, run):
    with mjpeg_server(20, pause_s=0.001) as address:
        result = run(*graph(tmp_path / "out", camera=address, reconnect=0.1))
    assert result.complete  # every frame that came went all the way
    assert "no frame has come from" in result.ended_early
    assert len((tmp_path / "out").read_text().splitlines()) == result.frames > 0


def test_the_trial_of_a_lost_camera_is_kept_and_does_not_look_whole(tmp_path):
    with mjpeg_server(40, -1, 40, pause_s=0.002) as address:
        done = live(tmp_path, address, "--reconnect-s", "1.2", "--record", str(tmp_path / "record"))
    assert isinstance(done.exception, EndedEarly)
    assert "no frame has come from" in str(done.exception)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["complete"] is False
    assert "no frame has come from" in summary["why_not_complete"]
    events = read_source_events(summary["source_events"])
    # What to try with noise is said too, where enough of it came in time.
    outage, end = (event for event in events if event.kind is not SourceEventKind.WHAT_TO_TRY)
    assert (outage.kind, outage.count) == (SourceEventKind.OUTAGE, 2)
    assert end.kind is SourceEventKind.ENDED_EARLY
    report = (tmp_path / "out" / "report.html").read_text()
    assert "1 outage of the camera" in report.partition("<nav")[0]
    assert "ended before its time" in report.partition("<nav")[0]
    assert "1 outage of the camera" in done.stdout


def test_the_record_of_a_trial_with_outages_replays_to_the_same_tracks(tmp_path):
    with mjpeg_server(30, -1, 30, 30, pause_s=0.002) as address:
        live(tmp_path, address, "--reconnect-s", "1.2", "--record", str(tmp_path / "record"))
    again = CliRunner().invoke(
        app,
        ["replay", str(tmp_path / "record"), "--no-chamber", "--out", str(tmp_path / "again")],
    )
    assert isinstance(again.exception, WithoutPose)  # noise has none; the results are whole
    for name in ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "out" / name).read_bytes()


class Device:
    """A stand-in for what OpenCV opens, with so many frames: tests have no camera to unplug."""

    def __init__(self, frames):
        self.frames = frames

    def grab(self):
        self.frames -= 1
        return self.frames >= 0

    def retrieve(self):
        return True, jpeg_picture(self.frames)

    def get(self, _):
        return 30.0

    def release(self):
        pass


def test_without_one_frame_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(camera_module, "open_capture", lambda *_: Device(0))
    record = ["--record", str(tmp_path / "record")]
    done = live(tmp_path, "/dev/video0", "--reconnect-s", "0.01", *record)
    assert isinstance(done.exception, Incomplete)
    assert str(done.exception) == "no frame has come from /dev/video0"
    assert list(tmp_path.iterdir()) == []


def test_a_video_file_that_ends_is_whole(ros_context, tmp_path):
    import cv2

    path = str(tmp_path / "film.avi")
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), 200.0, (64, 48))
    for number in range(5):
        writer.write(cv2.cvtColor(jpeg_picture(number), cv2.COLOR_GRAY2BGR))
    writer.release()
    node, events = watch(ros_context, path)
    assert node.sent > 0
    assert (events, node.ended_early) == ([], "")


@pytest.mark.parametrize("run", WAYS)
def test_a_signal_during_an_outage_ends_the_trial_at_once_and_whole(tmp_path, run):
    served, signalled = threading.Event(), []

    def picture(number):
        if number == 4:
            served.set()
        return jpeg_picture(number)

    def progress(sent, expected):
        if sent and served.is_set() and not signalled:
            signalled.append(sent)
            os.kill(os.getpid(), signal.SIGINT)

    with mjpeg_server(5, pause_s=0.02, picture=picture) as address:
        result = run(*graph(tmp_path / "out", camera=address, reconnect=600.0), progress)
    assert result.complete
    assert result.ended_early == ""


def test_an_unplugged_device_is_opened_anew(monkeypatch):
    opened = [Device(3), None, None, Device(4)]
    monkeypatch.setattr(camera_module, "open_capture", lambda *_: opened.pop(0) if opened else None)
    camera = Camera("/dev/video0", reconnect_s=0.3, reconnect_delay_s=0.001)
    camera.begin()
    camera._thread.join()
    assert camera.counts.captured == 7
    (outage,) = camera.take_outages()
    assert outage.reconnections == 3
    assert camera.ended
    assert "no frame has come from /dev/video0" in camera.why_lost


def test_a_read_that_never_returns_is_given_up_too(monkeypatch):
    asleep = threading.Event()

    class Dead:
        def grab(self):
            asleep.wait()

        def get(self, _):
            return 30.0

    monkeypatch.setattr(camera_module, "open_capture", lambda *_: Dead())
    for name in ("OPEN_TIMEOUT_S", "LONGEST_PAUSE_S"):
        monkeypatch.setattr(camera_module, name, 0.0)
    camera = Camera("/dev/video0", reconnect_s=0.02, stall_s=0.01)
    camera.begin()
    while not camera.ended:
        assert camera.silent_s < 20.0
    assert "no frame has come" in camera.why_lost
    assert camera.outage is not None
    asleep.set()


def test_pictures_of_another_size_are_told(ros_context):
    import numpy as np

    calls = []

    def picture(number):
        if number == 0:
            calls.append(number)
        return np.zeros((48, 64) if len(calls) == 1 else (96, 128), np.uint8)

    with mjpeg_server(10, 10, pause_s=0.005, picture=picture) as address:
        _, events = watch(ros_context, address, reconnect=0.5)
    (told,) = [event for event in events if event.kind is SourceEventKind.BAD_MESSAGE]
    assert "128 × 96 pixels; a trial has one size, 64 × 48" in told.why


def test_a_clock_that_is_set_back_does_not_tear_the_trial(monkeypatch):
    clock = SteadyClock()
    before = clock.now_ns()
    monkeypatch.setattr(time, "time_ns", lambda: 0)
    assert 0 <= clock.now_ns() - before < 10**11


events = st.lists(
    st.builds(
        SourceEvent,
        st.sampled_from(SourceEventKind),
        st.integers(0, 10**6),
        st.integers(0, 2**62),
        st.text(max_size=20),
        st.floats(0, 1e5),
        st.integers(0, 1000),
    ),
    max_size=20,
)


@given(events)
def test_every_kind_of_event_has_one_line(events):
    assert len(in_words(events)) == len({event.kind for event in events})
