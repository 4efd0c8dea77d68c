"""A rig file means to every command what it means to ROS, and what is wrong in it is one line."""

from pathlib import Path

import numpy as np
import pytest
import rclpy
import yaml
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from worm_bringup.graph.nodes import NODES, ROS_NAMES, parameters_of
from worm_bringup.rig.rig_file import _RosLoader, declared_of, read_rig
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.network import Reach, dds_settings, environment

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "rig.yaml"
SCALARS = (
    *("1", "0", "-3", "+3", "010", "0x1f", "1_000", "1.5", "21.", ".5", "1e3", "1e-3", "-2.5E+4"),
    *(".nan", "nan", "inf", "-.inf", "true", "True", "TRUE", "tRue", "yes", "No", "on", "Off"),
    *("y", "N", "~", "null", "''", "'3'", '"yes"', "2026-03-21", "12:30", "/dev/video0", "worm 7"),
    *("[a, b]", "['1', b]", "http://u:p@cam/x", "1.2.3", "0.3 # of d_w", "08", "1e", "e3", "--1"),
)
SECTIONS = ("/**", "/**/tracker", "tracker", "/tracker", "/rig1/tracker", "/*/tracker", "/rig1/**",
            "/rig2/tracker", "/**/rig1/tracker", "rig1/tracker")  # fmt: skip


def of_ros(text, folder, namespace="/"):
    """Return what rcl gives a node called tracker of a parameter file."""
    file = folder / "ros.yaml"
    file.write_text(text, encoding="utf-8")
    context = Context()
    words = ["--ros-args", "--params-file", str(file), "-r", f"__ns:={namespace}"]
    with environment(ROS_LOG_DIR=str(folder), **dds_settings(Reach.OWN)):
        rclpy.init(args=words, context=context, signal_handler_options=SignalHandlerOptions.NO)
        node = Node("tracker", context=context, start_parameter_services=False)
        told = {name: each.value for name, each in node._parameter_overrides.items()}
        node.destroy_node()
        rclpy.shutdown(context=context)
    return told


def test_every_value_is_read_as_ros_reads_it(tmp_path):
    lines = [f"    value_{k}: {scalar}" for k, scalar in enumerate(SCALARS)]
    text = "\n".join(["/**:", "  ros__parameters:", *lines])
    ours = yaml.load(text, _RosLoader)["/**"]["ros__parameters"]
    theirs = of_ros(text, tmp_path)
    for k, scalar in enumerate(SCALARS):
        name = f"value_{k}"
        assert type(ours[name]) is type(theirs[name]), scalar
        np.testing.assert_equal(ours[name], theirs[name], scalar)


@pytest.mark.parametrize("namespace", ["/", "/rig1", "/lab/rig1"])
def test_a_section_speaks_to_the_nodes_that_ros_means(tmp_path, namespace):
    for section in SECTIONS:
        text = f"{section}:\n  ros__parameters:\n    radius_m: 0.02\n"
        (tmp_path / "rig.yaml").write_text(text, encoding="utf-8")
        ours = read_rig([tmp_path / "rig.yaml"], namespace.lstrip("/"))
        assert ours.of("tracker") == of_ros(text, tmp_path, namespace), section


def test_what_comes_later_counts_in_a_file_and_between_files(tmp_path):
    first, second = tmp_path / "rig.yaml", tmp_path / "trial.yaml"
    everybody = "/**:\n  ros__parameters:\n    radius_m: 0.02\n    window: 4\n"
    tracker = "tracker:\n  ros__parameters:\n    radius_m: 0.03\n"
    for text, radius_m in ((everybody + tracker, 0.03), (tracker + everybody, 0.02)):
        first.write_text(text, encoding="utf-8")
        assert of_ros(text, tmp_path)["radius_m"] == radius_m
        assert read_rig([first]).of("tracker") == {"radius_m": radius_m}
    assert read_rig([first]).of("image_source", parameters_of("camera")) == {}
    assert read_rig([first]).of("image_source", parameters_of("replay")) == {"window": 4}
    second.write_text("/**/recorder:\n  ros__parameters:\n    animal: '7'\n", encoding="utf-8")
    both = read_rig([first, second])
    assert both.of("recorder") == {"animal": "7"}
    assert both.of("tracker")["radius_m"] == 0.02


def test_the_example_is_taken_by_every_node_that_it_speaks_to():
    rig = read_rig([EXAMPLE])
    assert rig.of("tracker")["exit_width_m"] == 0.002
    assert rig.of("recorder")["date"] == "2026-03-21"
    assert rig.of("image_source", parameters_of("replay")) == {}
    assert set(rig.told) == {"tracker", "analysis", "image_source", "recorder"}


NUMBERS = [
    (ROS_NAMES.get(name, name), declared)
    for name in NODES
    for declared in parameters_of(name)
    if declared.name not in ("out", "bag", "record")
]


@pytest.mark.parametrize(("node", "declared"), NUMBERS)
def test_a_wrong_value_and_a_wrong_name_are_one_line_for_every_parameter(tmp_path, node, declared):
    file = tmp_path / "rig.yaml"
    wrong = "1" if declared.kind in (str, bool, list) else "many"
    file.write_text(f"/**/{node}:\n  ros__parameters:\n    {declared.name}: {wrong}\n", "utf-8")
    with pytest.raises(BadInput) as refused:
        read_rig([file])
    assert str(refused.value).startswith(f"{file}: {node}: {declared.name} is ")
    assert "give" in str(refused.value)
    file.write_text(f"/**/{node}:\n  ros__parameters:\n    {declared.name}q: 1\n", "utf-8")
    with pytest.raises(BadInput) as refused:
        read_rig([file])
    line = str(refused.value)
    assert line.startswith(f"{file}: {node} has no parameter '{declared.name}q': did you mean")
    assert "\n" not in line


def section(name, *lines):
    return "\n".join([f"{name}:", "  ros__parameters:", *(f"    {line}" for line in lines)])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is no parameter file"),
        ("- a\n- b", "is no parameter file"),
        ("tracker: [", "line 1: is no YAML"),
        ("tracker:\n  radius_m: 0.01", "tracker: give its parameters under ros__parameters:"),
        ("tracker:\n  ros__parameters:", "tracker: give its parameters under ros__parameters:"),
        (section("trakcer", "radius_m: 0.01"), "'trakcer' is no node .*: did you mean 'tracker'"),
        (section("/**/tracker", "radius_m: 10.0"), "radius_m is 10: .*in mm, give 0.01"),
        (section("/**/tracker", "radius_m: '0.01'"), "radius_m is '0.01': give a number"),
        (section("/**/tracker", "radius_m: {b: 1}"), "radius_m is {'b': 1}: give a number"),
        (section("/**", "polarty: dark"), "did you mean 'polarity'"),
        (section("/**", "contact_factor: 99.0"), "analysis: contact_factor is 99"),
        (section("/**/analysis", "radius_m: 0.01"), "analysis has no parameter 'radius_m'"),
        (section("/**/tracker", "radius_px: 100.0"), "tracker: the chamber is given in part"),
        (section("/**/tracker", "px_per_mm: 20.0"), "tracker: px_per_mm .* leave it out"),
        (section("/**/recorder", "date: 21.3.2026"), "date is '21.3.2026': give year, month"),
        (section("/**/recorder", "operator: 7"), "operator is 7: give words, in quotation marks"),
        (section("/**/recorder", "temperature_c: 294.0"), "temperature_c is 294: give -5 to 60"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_with_its_name(tmp_path, text, said):
    file = tmp_path / "rig.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=said) as refused:
        read_rig([file])
    assert str(refused.value).startswith(str(file))
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_or_no_text_is_refused(tmp_path):
    with pytest.raises(BadInput, match=r"gone\.yaml: No such file"):
        read_rig([tmp_path / "gone.yaml"])
    (tmp_path / "picture.yaml").write_bytes(b"\xff\xd8\xff\xe0")
    with pytest.raises(BadInput, match="is no text"):
        read_rig([tmp_path / "picture.yaml"])


def test_no_file_says_nothing():
    rig = read_rig(None)
    assert all(rig.of(node) == {} for node in ("tracker", "analysis", "model", "recorder"))
    assert set(declared_of("image_source")) >= {"bag", "camera", "seed"}
