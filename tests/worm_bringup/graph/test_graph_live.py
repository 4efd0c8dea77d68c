"""Live, the tracker gets the newest frame and never queues; a replay of the record is the same."""

import os
import signal
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from mjpeg_server import mjpeg_server, number_in
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image

from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.qos import IMAGE_LIVE, RESULT
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.sources.source_node import drain, spin_source

WAYS = [
    pytest.param(run_in_process, id="one process"),
    pytest.param(run_in_processes, id="a process each"),
]


@pytest.fixture(autouse=True)
def stand_ins_can_be_imported(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2] / "support"))


def graph(module, out, **source):
    return (
        NodeSpec(module, "image_source", source),
        [
            NodeSpec("standin_tracker_node", "tracker", {"delay_s": 0.004}),
            NodeSpec("standin_recorder_node", "recorder", {"out": out}),
        ],
    )


def live(out, **source):
    return graph("worm_tracker.sources.camera_node", out, reconnect=0.0, **source)


@pytest.mark.parametrize("run", WAYS)
def test_a_replay_of_the_record_gives_the_same_results(tmp_path, run):
    with mjpeg_server(150, pause_s=0.001) as address:
        seen = run(*live(tmp_path / "live", camera=address, record=tmp_path / "record"))
    assert seen.complete
    assert 0 < seen.frames <= 150
    again = run_in_process(
        *graph("worm_tracker.sources.replay_node", tmp_path / "again", bag=tmp_path / "record")
    )
    assert again.complete
    assert again.frames == seen.frames
    assert (tmp_path / "again").read_bytes() == (tmp_path / "live").read_bytes()


@pytest.mark.parametrize("run", WAYS)
def test_a_signal_ends_a_live_run_whole(tmp_path, run):
    asked = []

    def progress(sent, expected):
        if sent > 5 and not asked:
            asked.append(sent)
            os.kill(os.getpid(), signal.SIGINT)

    with mjpeg_server(None, pause_s=0.002) as address:
        out, record = tmp_path / "live", tmp_path / "record"
        result = run(*live(out, camera=address, record=record), progress)
    assert result.complete
    assert len(out.read_text().splitlines()) == result.frames
    assert (record / "metadata.yaml").exists()


@pytest.mark.parametrize("run", WAYS)
def test_a_camera_that_is_not_there_ends_the_run_with_its_line(tmp_path, run):
    with pytest.raises(BadInput, match=r"^http://127.0.0.1:9/: the stream cannot be opened"):
        run(*live(tmp_path / "out", camera="http://127.0.0.1:9/", record=tmp_path / "record"))
    assert list(tmp_path.iterdir()) == []


def test_what_is_skipped_is_counted_on_diagnostics(ros_context):
    """A subscriber that takes whatever it can sees increasing numbers, and the counts add up."""
    with mjpeg_server(120) as address:
        source = CameraNode(
            context=ros_context,
            parameter_overrides=[
                Parameter("camera", value=address),
                Parameter("reconnect", value=0.0),
            ],
        )
        viewer = Node("viewer", context=ros_context, start_parameter_services=False)
        numbers, statuses = [], []
        viewer.create_subscription(
            Image,
            topics.IMAGE,
            lambda msg: numbers.append(number_in(PictureDecoder().decode(msg))),
            IMAGE_LIVE,
        )
        viewer.create_subscription(
            DiagnosticArray, topics.DIAGNOSTICS, lambda msg: statuses.extend(msg.status), RESULT
        )
        executor = SingleThreadedExecutor(context=ros_context)
        executor.add_node(source)
        executor.add_node(viewer)
        assert spin_source(executor, source, lambda: True, heed_window=True)
        source._reported_s = -float("inf")
        source.report()
        drain(executor)  # an earlier report, or the camera's end, may come first
        last = {item.key: item.value for item in statuses[-1].values}
        executor.shutdown()
        source.destroy_node()
        viewer.destroy_node()
    assert numbers == sorted(set(numbers))
    assert numbers[-1] == 119
    captured, sent, skipped = (int(last[f"frames {k}"]) for k in ("captured", "sent", "skipped"))
    assert 120 - numbers[0] <= captured <= 120  # what came before the source began is not counted
    assert captured == sent + skipped
    assert sent == len(numbers) == source.sent
    assert statuses[-1].message == "ended"
    assert float(last["age of last frame (s)"]) >= 0.0
