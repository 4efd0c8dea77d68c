"""Nothing of a graph leaves this machine, unless `--network` says so."""

import os
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from picture_bags import write_bag
from sockets import children, udp_addresses

from worm_bringup.graph.ros_environment import free_domain
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.network import Reach, dds_settings, environment

WORM = Path(sys.executable).with_name("worm")
SUPPORT = Path(__file__).parents[1] / "support"
ROS = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE", "SKIP_DEFAULT_XML_FILE",
       "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY", "ROS_DOMAIN_ID")  # fmt: skip


def plain_environment(**values):
    """The environment of a shell in which nothing of ROS is set, but what is given."""
    plain = {name: value for name, value in os.environ.items() if name not in ROS}
    return {**plain, "PYTHONPATH": str(SUPPORT), **values}


@contextmanager
def running(*command, **values):
    """Run a program that says a line when it is ready; end it by SIGTERM."""
    process = subprocess.Popen(
        command, env=plain_environment(**values), stdout=subprocess.PIPE, text=True
    )
    with process:
        try:
            assert process.stdout.readline() == "going\n"
            yield process
        finally:
            process.terminate()


@contextmanager
def graph(how, folder, *prefix, **values):
    bag = write_bag(folder / "bag", 40, shape=(8, 8))
    script = str(SUPPORT / "graph_script.py")
    with running(
        *prefix, sys.executable, script, how, str(bag), str(folder / "out"), **values
    ) as process:
        yield process


def other_program(*prefix, seconds=60, **values):
    """What a program with settings of its own hears of the states."""
    script = str(SUPPORT / "other_program.py")
    kind = "sensor_msgs.msg.JointState"
    done = subprocess.run(
        [*prefix, sys.executable, script, kind, "worm/state", str(seconds)],
        env=plain_environment(**values),
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


@pytest.fixture
def domain():
    """The number of a ROS domain that is this test's own."""
    with free_domain() as number:
        yield str(number)


@pytest.mark.parametrize("how", ["OWN", "MACHINE"])
def test_every_socket_of_a_graph_is_bound_on_the_loopback(tmp_path, domain, how):
    with graph(how, tmp_path, ROS_DOMAIN_ID=domain) as process:
        assert udp_addresses(process.pid) == {"127.0.0.1"}


def test_every_socket_of_a_graph_in_processes_is_bound_on_the_loopback(tmp_path):
    with graph("PROCESSES", tmp_path) as process:
        nodes = children(process.pid)
        assert len(nodes) == 3
        # The parent's own is the lock of the domain.
        for pid in (process.pid, *nodes):
            assert udp_addresses(pid) == {"127.0.0.1"}


def test_no_setting_opens_a_graph_that_was_not_asked_to(tmp_path, domain):
    settings = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
        "ROS_LOCALHOST_ONLY": "1",  # binds every interface, whatever its name says
        "ROS_STATIC_PEERS": "192.0.2.1",
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    }
    with graph("MACHINE", tmp_path, ROS_DOMAIN_ID=domain, **settings) as process:
        assert udp_addresses(process.pid) == {"127.0.0.1"}


def test_a_profile_in_the_working_directory_opens_nothing(tmp_path, domain, monkeypatch):
    monkeypatch.chdir(tmp_path)
    profile = Path(dds_settings(Reach.MACHINE)["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text()
    for name in ("DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml"):
        Path(name).write_text(profile.replace("127.0.0.1", "0.0.0.0"))
    with graph("MACHINE", tmp_path, ROS_DOMAIN_ID=domain) as process:
        assert udp_addresses(process.pid) == {"127.0.0.1"}


def test_a_program_with_default_settings_hears_a_visible_graph(tmp_path, domain):
    with graph("MACHINE", tmp_path, ROS_DOMAIN_ID=domain):
        assert other_program(ROS_DOMAIN_ID=domain) == "heard"


def test_nobody_hears_a_private_graph(tmp_path, domain):
    with graph("OWN", tmp_path, ROS_DOMAIN_ID=domain):
        assert other_program(ROS_DOMAIN_ID=domain, seconds=3) == "silence"


def test_a_node_started_alone_keeps_to_the_loopback(tmp_path, domain):
    bag = write_bag(tmp_path / "bag", 5, shape=(8, 8))
    script = (
        "import sys; from worm_tracker.sources import replay_node;"
        "from worm_tracker.sources.source_node import SourceNode;"
        "is_watched = SourceNode.is_watched;"
        "replay_node.ReplayNode.is_watched = property(lambda self: print('going', flush=True));"
        "sys.exit(replay_node.main(sys.argv))"
    )
    command = (sys.executable, "-c", script, "--ros-args", "-p", f"bag:={bag}")
    with running(*command, ROS_DOMAIN_ID=domain) as process:
        assert udp_addresses(process.pid) == {"127.0.0.1"}


def test_a_profile_of_the_users_stays_in_its_place():
    with environment(FASTRTPS_DEFAULT_PROFILES_FILE="/etc/mine.xml"):
        settings = dds_settings(Reach.MACHINE, heed_profile=True)
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in settings
    assert settings["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_another_middleware_keeps_to_this_machine_by_its_discovery():
    with environment(RMW_IMPLEMENTATION="rmw_cyclonedds_cpp"):
        assert dds_settings(Reach.MACHINE)["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"ROS_DOMAIN_ID": "400"}, "ROS_DOMAIN_ID=400: it is a number from 0 to 232"),
        ({"ROS_DOMAIN_ID": "x"}, "ROS does not start: .*ROS_DOMAIN_ID is not an integral number"),
        (
            {
                "ROS_SECURITY_ENABLE": "true",
                "ROS_SECURITY_STRATEGY": "Enforce",
                "ROS_SECURITY_KEYSTORE": "/nowhere",
            },
            "ROS does not start: .*/nowhere/enclaves. does not exist",
        ),
    ],
    ids=["domain", "no number", "no keys"],
)
def test_an_environment_that_ros_refuses_is_one_line(tmp_path, settings, line):
    bag = write_bag(tmp_path / "bag", 3)
    done = subprocess.run(
        [WORM, "replay", bag, "--no-chamber", "--visible", "--out", tmp_path / "out"],
        env=plain_environment(**settings),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert re.search(f"^worm: {line}", done.stderr, re.MULTILINE), done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "value"), [("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"), ("ROS_LOCALHOST_ONLY", "1")]
)
def test_an_open_network_that_the_environment_forbids_is_refused(monkeypatch, name, value):
    for variable in ROS:
        monkeypatch.delenv(variable, raising=False)
    assert dds_settings(Reach.NETWORK) == {}
    monkeypatch.setenv(name, value)
    with pytest.raises(BadInput, match=rf"--network: {name}={value} forbids it"):
        dds_settings(Reach.NETWORK)


def test_another_machine_hears_nothing_of_a_visible_graph(tmp_path, two_hosts):
    here, there = two_hosts
    with graph("MACHINE", tmp_path, *here):
        assert other_program(*there, seconds=4) == "silence"


def test_another_machine_hears_a_graph_that_is_open_to_the_network(tmp_path, two_hosts):
    here, there = two_hosts
    with graph("NETWORK", tmp_path, *here):
        assert other_program(*there) == "heard"
