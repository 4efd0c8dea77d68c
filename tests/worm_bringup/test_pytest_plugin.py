"""A user's test of a node has our fixtures from the installation alone."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
NODE_TEST = """
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from worm_msgs_py import topics
from worm_msgs_py.ros import qos
from worm_tracker.sources.replay_node import ReplayNode


def test_each_frame_has_a_state(ros_context, run_graph):
    from worm_tracker.tracker_node import TrackerNode

    seen = []
    mine = Node("mine", context=ros_context)
    mine.create_subscription(JointState, topics.WORM_STATE, seen.append, qos.RESULT)
    short = [Parameter("bag", value=BAG), Parameter("playback_duration", value=0.5)]
    replay = ReplayNode(context=ros_context, parameter_overrides=short)
    run_graph(replay, TrackerNode(context=ros_context), mine)
    assert len(seen) == replay.sent == 8
"""


def installed(folder):
    """Make what pip writes of the entry points that pyproject.toml has."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    plugins = project["entry-points"]["pytest11"]
    info = folder / "plugin_of_worm_escape-0.1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plugin-of-worm-escape\n")
    (info / "RECORD").write_text("")
    lines = [f"{name} = {module}" for name, module in plugins.items()]
    (info / "entry_points.txt").write_text("\n".join(["[pytest11]", *lines, ""]))
    return folder


def test_the_test_of_a_node_needs_no_conftest(tmp_path):
    (tmp_path / "mine").mkdir()
    bag = ROOT / "bags" / "larva"
    (tmp_path / "mine" / "test_mine.py").write_text(f"BAG = {str(bag)!r}\n{NODE_TEST}")
    site = installed(tmp_path / "site")
    paths = [str(site), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "ROS"))
    } | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=tmp_path / "mine",
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout


def test_messages_are_checked_wherever_the_plugin_is():
    assert os.environ["ROS_PYTHON_CHECK_FIELDS"] == "1"
