"""The workspace builds as ROS packages, for people with a full installation."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from worm_bringup.graph.nodes import parameters_of

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


def launch_file(name):
    """Return what a launch file defines."""
    path = ROOT / "src" / "worm_bringup" / "launch" / f"{name}.launch.py"
    scope = {}
    exec(compile(path.read_text(), path, "exec"), scope)
    return scope


@pytest.mark.parametrize("name", ["replay", "live"])
def test_launch_files_describe_the_graph(name):
    pytest.importorskip("launch_ros", reason="no wheel of it is published")
    assert launch_file(name)["generate_launch_description"]().entities


@pytest.fixture
def launched(monkeypatch):
    """Return the nodes that a launch file starts, where a stand-in takes the place of launch.

    The stand-in notes what launch is given, by the names that launch has for it.
    """
    names = {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
        "launch_ros.parameter_descriptions": ["ParameterValue"],
    }
    for module, kinds in names.items():
        stand_in = ModuleType(module)
        for kind in kinds:
            setattr(stand_in, kind, lambda *given, **named: SimpleNamespace(given=given, **named))
        monkeypatch.setitem(sys.modules, module, stand_in)

    def launch(name, **told):
        (entities,) = launch_file(name)["generate_launch_description"]().given
        *arguments, action = entities
        defaults = {argument.given[0]: argument.default_value for argument in arguments}
        assert set(told) <= set(defaults)
        return action.function(SimpleNamespace(launch_configurations={**defaults, **told}))

    return launch


def parameters_given(node):
    """Return the words that a node is given, by name; each is one that the node takes."""
    declared = {one.name: one for one in parameters_of(node.executable)}
    given = {name: value for each in node.parameters if isinstance(each, dict)
             for name, value in each.items()}  # fmt: skip
    for name, value in given.items():
        (word,) = value.given
        assert value.value_type is declared[name].kind
        typed = word == "true" if value.value_type is bool else value.value_type(word)
        assert not declared[name].refusal(typed)
    return {name: value.given[0] for name, value in given.items()}


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("replay", {"bag": "b", "out": "o", "rate": "2.5", "no_chamber": "true"}),
        ("live", {"camera": "/dev/video0", "record": "r", "out": "o", "polarity": "bright"}),
        ("live", {"topic": "/camera/image_raw", "out": "o"}),
    ],
)
def test_a_launch_file_gives_each_node_the_rig_file_and_before_it_what_is_told(
    launched, name, told, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for there in ("b", "o"):
        (tmp_path / there).mkdir()
    nodes = launched(name, rig="rig.yaml", namespace="/rig1", **told)
    assert {node.executable for node in nodes} >= {"tracker", "analysis", "model", "recorder"}
    assert {node.namespace for node in nodes} == {"/rig1"}
    assert {node.parameters[0] for node in nodes} == {"rig.yaml"}  # what comes later counts
    given = [parameters_given(node) for node in nodes]
    assert {k: v for each in given for k, v in each.items()} == told
    # What is not told is left to the rig file and the node: no default of the launch file's.
    bare = launched(name, rig="rig.yaml")
    assert not any(parameters_given(node) for node in bare)
    assert all(node.parameters == [] for node in launched(name))


def test_a_live_trial_without_a_place_for_results_starts_no_recorder(launched):
    nodes = launched("live", camera="/dev/video0")
    assert [node.executable for node in nodes] == ["model", "analysis", "tracker", "camera"]


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
    _, said = process.communicate(timeout=180.0)
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
    _, said = process.communicate(timeout=180.0)
    assert process.returncode == 0, said


def catches_sigterm(process):
    """Tell whether a process has set up what it does on SIGTERM."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1
