"""A second graph on the same names is refused before it has done anything."""

import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from forked_commands import worm
from picture_bags import write_bag

from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.claims import claim, claimed_name, full_name

SUPPORT = Path(__file__).parents[1] / "support"
WORM = Path(sys.executable).with_name("worm")
NO_POSES = 1
"""Exit status of a run whose pictures show no worm."""
RESUME = """
import rclpy, sys
from rclpy.node import Node
from std_srvs.srv import Trigger
rclpy.init(args=[])
node = Node("operator", start_parameter_services=False)
client = node.create_client(Trigger, "/image_source/resume")
assert client.wait_for_service(timeout_sec=60)
answer = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, answer, timeout_sec=60)
assert answer.result().success
"""


def until_somebody_holds(domain, node):
    """Wait until a graph has a name; a second one that starts now must be refused."""
    deadline_s = time.monotonic() + 120
    while time.monotonic() < deadline_s:
        if claimed_name(domain, node) in Path("/proc/net/unix").read_text():
            return
    raise AssertionError(f"nobody holds {node}")


def test_of_two_graphs_the_second_is_refused_and_the_first_is_as_if_alone(tmp_path, environment):
    bag = write_bag(tmp_path / "bag", 12)
    replay = ["replay", bag, "--no-chamber"]
    visible = [WORM, *replay, "--visible", "--start-paused"]
    with subprocess.Popen([*visible, "--out", tmp_path / "first"], env=environment) as first:
        try:
            until_somebody_holds(int(environment["ROS_DOMAIN_ID"]), "/image_source")
            second = subprocess.run(
                [*visible, "--out", tmp_path / "second"],
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            subprocess.run([sys.executable, "-c", RESUME], env=environment, check=True)
            assert first.wait(60) == NO_POSES
        finally:
            with suppress(ProcessLookupError):
                first.send_signal(signal.SIGKILL)
    assert second.returncode == 2
    (line,) = [line for line in second.stderr.splitlines() if line.startswith("worm:")]
    assert "a node /image_source runs already in ROS domain" in line
    assert "--namespace /rig2" in line
    assert "ROS_DOMAIN_ID=" in line
    assert "Traceback" not in second.stderr
    assert not (tmp_path / "second").exists()
    alone = worm(*replay, "--out", tmp_path / "alone", env=environment)
    assert alone.returncode == NO_POSES
    for name in (
        "tracks.parquet",
        "contacts.parquet",
        "passages.parquet",
        "sums.parquet",
        "summary.json",
    ):
        first, alone = (tmp_path / run / name for run in ("first", "alone"))
        assert first.read_bytes() == alone.read_bytes(), name


def test_a_name_is_free_again_when_its_holder_is_killed():
    script = (
        "import sys; from worm_msgs_py.ros.claims import claim\n"
        "with claim(5, ['/rig/killed']): print('held', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(BadInput, match="/rig/killed runs already in ROS domain 5"):
            claim(5, ["/rig/killed"]).__enter__()
        holder.kill()
        holder.wait()
        with claim(5, ["/rig/killed"]):
            pass


def test_other_names_and_other_domains_are_free():
    # Names that no graph of another test, which may run beside this one, has in any domain.
    with claim(6, ["/claims/a"]), claim(6, ["/claims/b"]), claim(7, ["/claims/a"]):
        pass


def test_a_name_of_three_hundred_characters_can_be_held():
    long = "/" + "r" * 300
    with claim(6, [long]), pytest.raises(BadInput, match="runs already"), claim(6, [long]):
        pass


@pytest.mark.parametrize("namespace", ["rig1", "/rig1", "/rig1/"])
def test_a_namespace_is_the_same_however_it_is_written(namespace):
    assert full_name(namespace, "tracker") == "/rig1/tracker"


def test_a_node_started_alone_is_refused_beside_one_of_its_name(environment):
    script = "import sys; from worm_analysis.analysis_node import main; sys.exit(main(sys.argv))"
    with claim(int(environment["ROS_DOMAIN_ID"]), ["/rig3/analysis"]):
        done = subprocess.run(
            [sys.executable, "-c", script, "--ros-args", "-r", "__ns:=/rig3"],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert "a node /rig3/analysis runs already" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_graph_is_refused_where_another_machine_tracks(two_hosts, tmp_path, environment):
    """Between machines there is no lock: whoever publishes the states is looked for."""
    here, there = two_hosts
    bag = write_bag(tmp_path / "bag", 40, shape=(8, 8))
    script = [sys.executable, SUPPORT / "graph_script.py", "NETWORK", bag, tmp_path / "first"]
    environment["PYTHONPATH"] = str(SUPPORT)
    with subprocess.Popen(
        [*here, *script], env=environment, stdout=subprocess.PIPE, text=True
    ) as first:
        try:
            assert first.stdout.readline() == "going\n"
            replay = [WORM, "replay", bag, "--no-chamber", "--visible", "--network"]
            second = subprocess.run(
                [*there, *replay, "--out", tmp_path / "second"],
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
        finally:
            first.terminate()
    assert second.returncode == 2
    assert "a graph with the topic /worm/state runs already" in second.stderr
