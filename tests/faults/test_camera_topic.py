"""A driver in another process is a camera like any other: its stamps, its losses, its outages."""

import os
import signal
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from driver import PERIOD_NS, START_NS
from mjpeg_server import number_in
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.ros_environment import free_domain
from worm_msgs_py import SourceEventKind
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros import camera_driver
from worm_msgs_py.ros.network import Reach
from worm_tracker.sources import camera_node
from worm_tracker.sources.bags.pictures import pictures_of_bag

SUPPORT = Path(__file__).parents[1] / "support"
TOPIC = "/camera/image_raw"


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """A ROS domain of the test's own, in which programs of this machine hear each other."""
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    with free_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield


@pytest.fixture
def told(monkeypatch):
    """The events that the source tells."""
    events = []
    tell = camera_node.CameraNode._tell
    monkeypatch.setattr(
        camera_node.CameraNode,
        "_tell",
        lambda node, event: (events.append(event), tell(node, event)),
    )
    return events


@contextmanager
def driver(*arguments, topic=TOPIC):
    command = [sys.executable, SUPPORT / "driver.py", topic, *map(str, arguments)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:
        try:
            yield process
        finally:
            process.kill()


def tell(process, *commands):
    for command in commands:
        print(command, file=process.stdin, flush=True)


def at(steps):
    """A progress callback that acts at numbers of frames sent; at 0 the graph begins to film."""

    def progress(sent, expected):
        steps.pop(sent, lambda: None)()

    return progress


def end():
    os.kill(os.getpid(), signal.SIGINT)


def run(tmp_path, progress=None, **parameters):
    source = {"topic": TOPIC, "record": str(tmp_path / "record")} | parameters
    nodes = [
        NodeSpec("standin_tracker_node", "tracker"),
        NodeSpec("standin_recorder_node", "recorder", {"out": tmp_path / "out"}),
    ]
    node = NodeSpec("worm_tracker.sources.camera_node", "image_source", source)
    return run_in_process(node, nodes, progress, reach=Reach.MACHINE)


def recorded(tmp_path):
    """The numbers that the recorded pictures show, and their stamps."""
    pictures = list(pictures_of_bag(tmp_path / "record"))
    return [number_in(grey) for grey, _ in pictures], [stamp_ns for _, stamp_ns in pictures]


@pytest.mark.parametrize(
    ("encoding", "reliability"),
    [
        ("mono8", "reliable"),
        ("mono8", "best_effort"),
        ("mono16", "best_effort"),
        ("bgr8", "reliable"),
        ("rgb8", "best_effort"),
        ("jpeg", "best_effort"),
    ],
)
def test_every_picture_of_a_driver_is_a_frame_with_its_stamp(tmp_path, encoding, reliability):
    with driver(encoding, reliability) as process:
        result = run(tmp_path, at({0: lambda: tell(process, 30), 30: end}))
    numbers, stamps = recorded(tmp_path)
    assert numbers == list(range(30))
    assert stamps == [START_NS + number * PERIOD_NS for number in numbers]
    assert (result.frames, result.counts["frames lost"]) == (30, "0")
    assert result.complete


def test_what_never_came_is_counted(tmp_path, told):
    """Of a burst deeper than the driver's own queue some are lost: none of them unsaid."""
    with driver("mono8", "best_effort") as process:
        steps = {0: lambda: tell(process, 10), 5: lambda: tell(process, "burst 2000", 10)}
        result = run(tmp_path, at(steps), stall=5.0, reconnect=0.0)
    assert f"no frame has come on {TOPIC}" in result.ended_early
    numbers, _ = recorded(tmp_path)
    lost = [event.count for event in told if event.kind is SourceEventKind.LOST_ON_THE_WAY]
    skipped = int(result.counts["frames skipped"])
    first = numbers[0]  # what came before the two had met cannot be known
    assert len(numbers) + skipped + sum(lost) == 2020 - first
    assert numbers[-1] == 2019
    assert (np.diff(numbers) > 0).all()


def test_a_driver_that_stops_and_another_that_begins_is_an_outage(tmp_path, told):
    with ExitStack() as drivers:
        first = drivers.enter_context(driver("mono8", "best_effort"))

        def another():
            first.kill()
            tell(drivers.enter_context(driver("mono8", "best_effort", 1000)), 20)

        steps = {0: lambda: tell(first, 20), 20: another, 40: end}
        result = run(tmp_path, at(steps), stall=0.3, reconnect=600.0)
    outage, *_ = [event for event in told if event.kind is SourceEventKind.OUTAGE]
    assert (outage.frame, outage.stamp_ns) == (20, START_NS + 19 * PERIOD_NS)
    assert outage.duration_s > 0.3
    assert result.complete
    assert recorded(tmp_path)[0] == [*range(20), *range(1000, 1020)]


def test_an_encoding_that_is_not_read_is_refused_in_one_line(tmp_path):
    with driver("bayer_rggb8", "reliable") as process, pytest.raises(BadInput) as caught:
        run(tmp_path, at({0: lambda: tell(process, 5)}))
    assert str(caught.value).startswith(f"{TOPIC}: pictures are encoded as 'bayer_rggb8'")
    assert not (tmp_path / "record").exists()


def test_a_topic_that_nobody_publishes_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(camera_driver, "_DISCOVERY_TICKS", 1)
    with pytest.raises(BadInput, match=f"{TOPIC}: nobody publishes there; does the driver run"):
        run(tmp_path)


def run_till_refused(tmp_path):
    for _ in range(10):  # on a busy machine the second may be found too late
        run(tmp_path, stall=0.1, reconnect=0.0)


def test_two_cameras_on_a_topic_are_refused(tmp_path):
    with driver("mono8", "reliable") as first, driver("mono8", "reliable") as second:
        for process in (first, second):
            assert process.stdout.readline() == "publishes\n"
        with pytest.raises(BadInput, match=f"{TOPIC}: driver and driver publish there"):
            run_till_refused(tmp_path)


def test_the_graphs_own_topic_is_refused(tmp_path):
    with pytest.raises(BadInput, match="this graph sends its own pictures there"):
        run(tmp_path, topic="/image_raw")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--topic", TOPIC, "--private"], "leave out --private"),
        (["--topic", TOPIC, "--camera", "0"], "either --camera"),
        ([], "either --camera"),
    ],
)
def test_options_that_make_no_camera_are_refused(words, said, monkeypatch):
    monkeypatch.delenv("WORM_CAMERA", raising=False)
    done = CliRunner().invoke(app, ["live", *words])
    assert said in str(done.exception)
