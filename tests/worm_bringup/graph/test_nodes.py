"""Every parameter of every node: what is wrong is refused, at start and at set; a page has all."""

import importlib.util
import re
from pathlib import Path

import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_bringup.graph.node_spec import NodeSpec, node_class
from worm_bringup.graph.nodes import NODES, parameters_of
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.parameter_files import OF_THE_GRAPH
from worm_msgs_py.ros.parameters import FIXED

DOCS = Path(__file__).parents[3] / "docs"
SPEC = importlib.util.spec_from_file_location("make_nodes", DOCS / "make_nodes.py")
PAGE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(PAGE)

EVERY = [
    pytest.param(node, declared, id=f"{node}-{declared.name}")
    for node in NODES
    for declared in parameters_of(node)
]
OF_NUMBERS = [case for case in EVERY if case.values[1].limit is not None]


@pytest.fixture(scope="module")
def running():
    with PAGE.running_nodes() as nodes:
        yield nodes


def of_another_type(declared):
    return 1 if declared.kind in (str, bool, list) else "many"


def out_of_range(declared):
    return declared.kind(declared.limit.high * 1.01 + 1)


def refused_values(declared):
    yield of_another_type(declared)
    if declared.limit is not None:
        yield out_of_range(declared)
        below = declared.kind(declared.limit.low - 1)
        if below != declared.or_else:
            yield below
    if declared.choices:
        yield "neither"


@pytest.mark.parametrize(("node", "declared"), EVERY)
def test_a_wrong_value_is_refused_at_start_before_the_node_does_anything(
    ros_context, node, declared
):
    for value in refused_values(declared):
        given = [Parameter(declared.name, value=value)]
        with pytest.raises(
            BadInput, match=rf"^node {PAGE.ROS_NAMES.get(node, node)}: .* is "
        ) as it:
            node_class(NODES[node])(context=ros_context, parameter_overrides=given)
        assert f": {declared.name} is " in str(it.value)
        assert "\n" not in str(it.value)


@pytest.mark.parametrize(("node", "declared"), EVERY)
def test_a_misspelt_name_is_refused_at_start_with_the_one_that_is_meant(
    ros_context, node, declared
):
    misspelt = declared.name[:-1] + "q" + declared.name[-1]
    spec = NodeSpec(NODES[node], PAGE.ROS_NAMES.get(node, node), {misspelt: declared.default})
    with pytest.raises(
        BadInput, match=f"has no parameter '{misspelt}': did you mean '{declared.name}'"
    ):
        spec.make(context=ros_context)


@pytest.mark.parametrize(("node", "declared"), EVERY)
def test_a_wrong_value_and_a_wrong_name_are_refused_at_set_with_the_reason(running, node, declared):
    name, before = declared.name, running[node].get_parameter(declared.name).value
    for value in refused_values(declared):
        (result,) = running[node].set_parameters([Parameter(name, value=value)])
        assert not result.successful
        assert result.reason.startswith(f"{name} is ")
    misspelt = [Parameter(name + "q", value=declared.default)]
    result = running[node].set_parameters_atomically(misspelt)
    assert not result.successful
    assert f"did you mean '{name}'" in result.reason
    (undeclared,) = running[node].set_parameters([Parameter(name)])
    assert not undeclared.successful
    after = running[node].get_parameter(name).value
    assert str(after) == str(before)


@pytest.mark.parametrize(("node", "declared"), EVERY)
def test_what_is_fixed_is_refused_at_set_and_what_is_live_is_taken(running, node, declared):
    value = running[node].read_parameter(declared.name)
    (result,) = running[node].set_parameters([Parameter(declared.name, value=value)])
    if declared.changes:
        assert result.successful or declared.name == "exposure_ms"  # no device is here to ask
    else:
        assert not result.successful
        assert result.reason == f"{declared.name} {FIXED}" or declared.refusal(value)


@pytest.mark.parametrize(("node", "declared"), OF_NUMBERS)
def test_a_number_at_the_end_of_its_range_is_taken(running, node, declared):
    for value in (declared.limit.low, declared.limit.high):
        assert declared.refusal(declared.kind(value)) == ""


@pytest.mark.parametrize(("node", "declared"), EVERY)
def test_a_parameter_tells_others_what_it_is(running, node, declared):
    told = running[node].describe_parameter(declared.name)
    assert told.description == declared.description
    assert declared.description.endswith(".")
    assert told.read_only is not declared.changes
    assert declared.allowed in told.additional_constraints
    assert declared.kind not in (int, float) or declared.limit is not None
    ranges = [*told.floating_point_range, *told.integer_range]
    assert len(ranges) <= 1
    for of_ros in ranges:
        assert (of_ros.from_value, of_ros.to_value) == (declared.limit.low, declared.limit.high)
    if declared.limit is not None and not declared.limit.or_zero and declared.or_else is None:
        assert ranges


@pytest.mark.parametrize("node", NODES)
def test_the_service_of_ros_gives_the_reason(running, node):
    client_node = Node(f"asks_{node}", context=running[node].context)
    name = f"{running[node].get_fully_qualified_name()}/set_parameters"
    client = client_node.create_client(SetParameters, name)
    executor = SingleThreadedExecutor(context=running[node].context)
    executor.add_node(client_node)
    executor.add_node(running[node])
    declared = parameters_of(node)[0]
    request = SetParameters.Request(
        parameters=[
            Parameter(declared.name, value=of_another_type(declared)).to_parameter_msg(),
            Parameter("windoww", value=1).to_parameter_msg(),
        ]
    )
    assert client.wait_for_service(timeout_sec=60.0)
    future = client.call_async(request)
    executor.spin_until_future_complete(future, timeout_sec=60.0)
    wrong, unknown = future.result().results
    assert wrong.reason == f"{declared.name} {declared.refusal(of_another_type(declared))}"
    assert "has no parameter 'windoww'" in unknown.reason
    executor.remove_node(running[node])
    executor.shutdown()
    client_node.destroy_node()


def test_every_node_that_can_be_started_is_listed():
    src = DOCS.parent / "src"
    started = {
        ".".join(file.relative_to(src).with_suffix("").parts[1:])
        for file in src.glob("worm_*/worm_*/**/*.py")
        if "\ndef main(" in (text := file.read_text("utf-8"))
        and re.search(r"^class \w+Node\(", text, re.MULTILINE)
    }
    assert started == set(NODES.values())


def test_a_file_for_several_nodes_knows_every_parameter_and_no_other():
    of_the_nodes: dict[str, set[str]] = {}
    for node in NODES:
        names = of_the_nodes.setdefault(PAGE.ROS_NAMES.get(node, node), set())
        names |= {declared.name for declared in parameters_of(node)}
    assert {node: set(names) for node, names in OF_THE_GRAPH.items()} == of_the_nodes


def test_the_page_is_what_the_nodes_say():
    written = (DOCS / "nodes.md").read_text(encoding="utf-8")
    assert written == PAGE.page(), "run python docs/make_nodes.py"
