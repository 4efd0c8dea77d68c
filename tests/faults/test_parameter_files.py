"""A parameter file that a node cannot use is refused with the parameter's name."""

import pytest
from rclpy.parameter import Parameter

from worm_analysis.analysis_node import AnalysisNode
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.worm_node import WormNode, refuse_unknown_parameters
from worm_tracker.tracker_node import TrackerNode


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("radius_m", float("nan"), "radius_m is nan: give 0.0005 to 0.5 m"),
        ("radius_m", 10.0, "radius_m is 10: .*if that is in mm, give 0.01"),
        ("depth_m", float("inf"), "depth_m is inf"),
        ("px_per_mm", 20.0, "no_chamber"),
    ],
)
def test_a_parameter_that_makes_no_sense_is_named(ros_context, name, value, said):
    with pytest.raises(BadInput, match=said):
        TrackerNode(context=ros_context, parameter_overrides=[Parameter(name, value=value)])


def test_a_misspelt_parameter_is_named_with_the_one_that_may_be_meant(ros_context):
    given = [Parameter("radius_mm", value=10.0)]
    with pytest.raises(BadInput, match="no parameter 'radius_mm': did you mean 'radius_m'"):
        TrackerNode(context=ros_context, parameter_overrides=given)


def test_a_misspelt_parameter_of_a_users_own_node_is_refused_once_it_has_declared_its_own(
    ros_context,
):
    given = [Parameter("intervall", value=1.0)]
    node = WormNode("mine", context=ros_context, parameter_overrides=given)
    node.declare_parameter("interval", 1.0)
    with pytest.raises(BadInput, match="no parameter 'intervall': did you mean 'interval'"):
        refuse_unknown_parameters(node)
    node.destroy_node()


def test_a_whole_number_is_taken_for_a_parameter_that_is_none(ros_context):
    given = [Parameter("max_gap_s", value=2)]
    node = AnalysisNode(context=ros_context, parameter_overrides=given)
    assert node.get_parameter("max_gap_s").value == 2.0
    node.destroy_node()
