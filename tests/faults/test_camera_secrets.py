"""A camera's password reaches the camera and nothing else."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.stream_reader import StreamReader
from mjpeg_server import mjpeg_server
from rcl_interfaces.msg import ParameterEvent
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_bringup.cli import main
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.cameras.camera_address import kind_of, shown_address

PASSWORD = "hunter2secret"
LOGIN = f"admin:{PASSWORD}"


def with_login(address, login=LOGIN):
    return address.replace("http://", f"http://{login}@") + f"?token={PASSWORD}"


def all_bytes(folder):
    """Every byte of every file in a folder; what is compressed also as it was before."""
    for file in sorted(folder.rglob("*")):
        if not file.is_file():
            continue
        data = file.read_bytes()
        yield file, data
        if file.suffix == ".mcap":
            for record in StreamReader(io.BytesIO(data)).records:
                yield file, repr(record).encode()
        if file.suffix == ".parquet":
            yield file, repr(pq.read_table(file).to_pydict()).encode()


def worm_live(tmp_path, address, *more):
    """`worm live` as a user runs it, with the address in the environment."""
    return subprocess.run(
        [
            Path(sys.executable).with_name("worm"), "live", "--no-chamber", "--reconnect-s", "0.3",
            "--out", tmp_path / "out", "--record", tmp_path / "record", *more,
        ],
        env={
            **os.environ,
            "WORM_CAMERA": address,
            "ROS_LOG_DIR": str(tmp_path / "log"),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
            "OPENCV_FFMPEG_LOGLEVEL": "48",
            "OPENCV_LOG_LEVEL": "DEBUG",
            "OPENCV_VIDEOIO_DEBUG": "1",
        },
        capture_output=True,
        check=False,
    )  # fmt: skip


def test_the_password_opens_the_camera_and_stands_nowhere(tmp_path):
    with mjpeg_server(40, -1, 30, pause_s=0.005, login=LOGIN) as address:
        done = worm_live(tmp_path, with_login(address))
    assert done.returncode == 1, done.stderr.decode()  # the camera was lost at the end
    assert b"reconnect" in done.stderr
    seen = set()
    for file, data in all_bytes(tmp_path):
        seen.add(file.name)
        assert PASSWORD.encode() not in data, file
        assert b"admin" not in data, file
    assert {"summary.json", "report.html", "tracks.parquet", "metadata.yaml"} <= seen
    for said in (done.stdout, done.stderr):
        assert PASSWORD.encode() not in said
        assert b"admin" not in said


@pytest.mark.parametrize(
    "address",
    [
        f"http://admin:{PASSWORD}@127.0.0.1:9/video",
        f"http://127.0.0.1:9/video?user=admin&password={PASSWORD}",
        f"rtsp://127.0.0.1:9/user=admin&password={PASSWORD}&channel=1.sdp",
        f"ftp://admin:{PASSWORD}@lab/film",
        f"admin:{PASSWORD}@lab/video",
        f"lab/video?password={PASSWORD}",
        f"http://admin:{PASSWORD}#x@127.0.0.1:9/video",
        f"http://admin:1/{PASSWORD}@127.0.0.1:9/video",
        f"http://[{PASSWORD}@/",
    ],
)
def test_a_refusal_does_not_show_it(address, monkeypatch, capfd):
    monkeypatch.setenv("WORM_CAMERA", address)
    monkeypatch.setattr(sys, "argv", ["worm", "live", "--private"])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    said = "".join(capfd.readouterr())
    assert "cannot be opened" in said or "no such camera" in said
    assert PASSWORD not in said
    assert "admin" not in said


def test_no_parameter_shows_it(ros_context):
    """Parameters are published as they are declared."""
    events = []
    viewer = Node("viewer", context=ros_context, start_parameter_services=False)
    viewer.create_subscription(ParameterEvent, "/parameter_events", events.append, 100)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(viewer)
    with mjpeg_server(None, pause_s=0.01, login=LOGIN) as address:
        node = CameraNode(
            context=ros_context,
            parameter_overrides=[Parameter("camera", value=with_login(address))],
        )
        while not any("camera" in repr(event) for event in events):
            executor.spin_once(timeout_sec=10.0)
        assert node.get_parameter("camera").value == address.replace("http://", "http://…@") + "?…"
        node.destroy_node()
    executor.shutdown()
    viewer.destroy_node()
    assert PASSWORD not in repr(events)


def test_no_process_has_it_on_its_command_line_or_in_a_file(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1] / "support"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr("tempfile.tempdir", None)
    seen = []

    def progress(sent, expected):
        if seen or not sent:
            return
        for child in Path(f"/proc/{os.getpid()}/task").glob("*/children"):
            seen.extend(
                Path(f"/proc/{number}/cmdline").read_bytes() for number in child.read_text().split()
            )
        seen.extend(data for _, data in all_bytes(tmp_path / "tmp"))

    with mjpeg_server(40, pause_s=0.01, login=LOGIN) as address:
        source = NodeSpec(
            "worm_tracker.sources.camera_node",
            "image_source",
            {"camera": with_login(address), "reconnect": 0.05},
        )
        nodes = [
            NodeSpec("standin_tracker_node", "tracker"),
            NodeSpec("standin_recorder_node", "recorder", {"out": str(tmp_path / "out")}),
        ]
        result = run_in_processes(source, nodes, progress)
    assert result.frames
    assert len(seen) >= 3
    assert not any(PASSWORD.encode() in data for data in seen)


words = st.text(st.characters(codec="utf-8", exclude_characters="…"), min_size=6, max_size=12)


@given(words, words, st.sampled_from(["http", "https", "rtsp", "rtsps"]))
def test_whatever_the_password_is_it_is_not_shown(user, password, scheme):
    shown = shown_address(f"{scheme}://{user}:{password}@camera.lab:554/stream")
    assert password not in shown
    assert shown in (f"{scheme}://…@camera.lab:554/stream", f"{scheme}://…")


@given(words)
def test_nor_is_what_stands_in_the_query(secret):
    assert secret not in shown_address(f"http://camera.lab/video?password={secret}")


@pytest.mark.parametrize(
    ("address", "shown"),
    [
        ("http://lab:8080/video.mjpg", "http://lab:8080/video.mjpg"),
        ("rtsp://me:pw@lab:554/1", "rtsp://…@lab:554/1"),
        ("rtsp://me:p@w@lab/1", "rtsp://…@lab/1"),
        ("http://me:p%40w@[fe80::1]:80/1", "http://…@[fe80::1]:80/1"),
        ("rtsps://lab:7441/aB3dE6gH9jK1?enableSrtp", "rtsps://lab:7441/…?…"),
        ("/dev/video0", "/dev/video0"),
        ("0", "0"),
        ("film.avi", "film.avi"),
    ],
)
def test_what_is_no_secret_is_shown(address, shown):
    assert shown_address(address) == shown


def test_a_password_that_must_be_encoded_is_told():
    with pytest.raises(BadInput, match="%40") as caught:
        Camera("http://me:pass/word@127.0.0.1:9/")
    assert "word" not in str(caught.value).partition(";")[0]
    assert kind_of("http://me:pass/word@127.0.0.1:9/")
