"""The workspace builds as ROS packages, for people with a full installation."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {
    "worm_analysis",
    "worm_bringup",
    "worm_model",
    "worm_monitor",
    "worm_msgs_py",
    "worm_tracker",
}


def colcon(*args, **kwargs):
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    return subprocess.run(
        [sys.executable, "-m", "colcon", *args],
        cwd=ROOT / "ros2_ws",
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        **kwargs,
    )


def test_colcon_finds_ament_python_packages():
    listed = [line.split("\t") for line in colcon("list").stdout.splitlines()]
    assert {name for name, _, _ in listed} == PACKAGES
    assert {kind for _, _, kind in listed} == {"(ros.ament_python)"}


def test_colcon_builds_and_installs_nodes_and_launch_files(tmp_path):
    done = colcon(
        "--log-base", str(tmp_path / "log"), "build",
        "--build-base", str(tmp_path / "build"), "--install-base", str(tmp_path / "install"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for package, node in [
        ("worm_tracker", "tracker"),
        ("worm_tracker", "replay"),
        ("worm_tracker", "camera"),
        ("worm_analysis", "analysis"),
        ("worm_model", "model"),
        ("worm_monitor", "monitor"),
        ("worm_bringup", "recorder"),
    ]:
        assert (tmp_path / "install" / package / "lib" / package / node).exists()
    share = tmp_path / "install" / "worm_bringup" / "share" / "worm_bringup"
    assert sorted(item.name for item in (share / "launch").iterdir()) == [
        "live.launch.py",
        "replay.launch.py",
    ]


@pytest.mark.parametrize("name", ["replay", "live"])
def test_launch_files_describe_the_graph(name):
    pytest.importorskip("launch_ros", reason="no wheel of it is published")
    path = ROOT / "src" / "worm_bringup" / "launch" / f"{name}.launch.py"
    scope = {}
    exec(compile(path.read_text(), path, "exec"), scope)
    assert scope["generate_launch_description"]().entities


@pytest.fixture
def started(tmp_path):
    """Start a node alone, by its module."""
    processes = []

    def start(module):
        environment = {**os.environ, "ROS_LOG_DIR": str(tmp_path)}
        command = [sys.executable, "-m", module]
        process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    "module",
    [
        "worm_tracker.sources.replay_node",
        "worm_tracker.sources.camera_node",
        "worm_bringup.recorder.recorder_node",
    ],
)
def test_a_node_started_alone_without_what_it_needs_says_so(module, started):
    process = started(module)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode == 2, said
    assert len(said.splitlines()) == 1, said


@pytest.mark.parametrize(
    "module",
    ["worm_tracker.tracker_node", "worm_analysis.analysis_node", "worm_model.model_node"],
)
def test_a_node_started_alone_that_needs_nothing_waits_until_it_is_ended(module, started):
    process = started(module)
    while not catches_sigterm(process):
        assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode == 0, said


def catches_sigterm(process):
    """Tell whether a process has set up what it does on SIGTERM."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1
