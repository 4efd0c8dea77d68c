"""The same rig file, given to lone nodes by --params-file: each has its own part of it."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python

from worm_bringup.graph.ros_environment import free_domain, own_context
from worm_msgs_py.ros.network import Reach, dds_settings, environment

LARVA = Path(__file__).parents[3] / "bags" / "larva"
WORM = [sys.executable, "-c", "from worm_bringup.cli import main; main()"]
RIG = """
/**:
  ros__parameters:
    contact_factor: 0.35
    max_megapixels: 8
/**/tracker:
  ros__parameters:
    radius_m: 12e-3
/**/recorder:
  ros__parameters:
    date: 2026-03-21
/**/image_source:
  ros__parameters:
    camera: /dev/video0
"""
WAIT_S = 180.0
ASKED = 30
"""How often: DDS loses an answer to a client that the server has not discovered yet."""


class Asker:
    """A program of somebody else's that calls the parameter services of a node."""

    def __init__(self, context, node):
        self._node = Node("asker", context=context, start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        self._of = f"/rig1/{node}"

    def call(self, kind, name, request):
        client = self._node.create_client(kind, f"{self._of}/{name}")
        assert client.wait_for_service(timeout_sec=WAIT_S)
        for _ in range(ASKED):
            future = client.call_async(request)
            self._executor.spin_until_future_complete(future, timeout_sec=WAIT_S / ASKED)
            if future.done():
                return future.result()
        raise AssertionError(f"{self._of} answers no {name}")

    def value(self, name):
        request = GetParameters.Request(names=[name])
        (value,) = self.call(GetParameters, "get_parameters", request).values
        return parameter_value_to_python(value)

    def set(self, name, value):
        asked = Parameter(name, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[asked])
        (result,) = self.call(SetParameters, "set_parameters", request).results
        return result

    def close(self):
        self._executor.shutdown()
        self._node.destroy_node()


@pytest.fixture
def alone(tmp_path):
    """Start a node by `worm node` with the rig file, and give who asks it."""
    (tmp_path / "rig.yaml").write_text(RIG, encoding="utf-8")
    (tmp_path / "out").mkdir()
    started, askers = [], []
    with free_domain() as domain, environment(ROS_DOMAIN_ID=str(domain)):
        ours = tuple(dds_settings(Reach.OWN))  # of the tests: nothing else is to hear them
        surroundings = {name: value for name, value in os.environ.items() if name not in ours}
        with own_context(Reach.MACHINE) as context:

            def start(name, ros_name, *parameters):
                given = [word for each in parameters for word in ("-p", each)]
                words = ["--ros-args", "--params-file", "rig.yaml", "-r", "__ns:=/rig1", *given]
                command = [*WORM, "node", name, *words]
                started.append(subprocess.Popen(command, cwd=tmp_path, env=surroundings))
                askers.append(Asker(context, ros_name))
                return started[-1], askers[-1]

            yield start
            for asker in askers:
                asker.close()
            for process in started:
                process.kill()
                process.wait()


@pytest.mark.parametrize(
    ("name", "ros_name", "parameters", "has"),
    [
        ("tracker", "tracker", (), {"radius_m": 0.012, "max_megapixels": 8.0}),
        ("analysis", "analysis", ("max_gap_s:=1",), {"contact_factor": 0.35, "max_gap_s": 1.0}),
        ("recorder", "recorder", ("out:=out",), {"date": "2026-03-21"}),
        ("replay", "image_source", (f"bag:={LARVA}",), {"max_megapixels": 8.0, "rate": 0.0}),
    ],
)
def test_a_lone_node_has_its_part_of_the_file_and_ends_in_order(
    alone, name, ros_name, parameters, has
):
    process, asker = alone(name, ros_name, *parameters)
    for parameter, value in has.items():
        assert asker.value(parameter) == value
    misspelt = asker.set("radius_mm", 10.0)
    assert "has no parameter 'radius_mm'" in misspelt.reason
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=WAIT_S) == (1 if name == "replay" else 0)  # it has sent nothing


def test_a_lone_player_takes_another_rate_while_it_waits(alone):
    _, asker = alone("replay", "image_source", f"bag:={LARVA}")
    assert asker.set("rate", 2).successful
    assert asker.value("rate") == 2.0
    fixed = asker.set("loop", True)
    assert fixed.reason.startswith("loop is fixed while the node runs")
