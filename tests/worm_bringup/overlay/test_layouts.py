"""Every topic, field and name in the layouts for viewers is in a bag that the software makes."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from forked_commands import worm
from other_reader import messages_by_topic

from worm_bringup.overlay.foxglove_server import SERVED

ROOT = Path(__file__).parents[3]
FOXGLOVE = json.loads((ROOT / "docs/layouts/foxglove.json").read_text(encoding="utf-8"))
PLOTJUGGLER = ElementTree.parse(ROOT / "docs/layouts/plotjuggler.xml")
PANELS = FOXGLOVE["configById"]

pytestmark = pytest.mark.xdist_group("layouts")


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """All messages of a result of the example bag, by topic."""
    out = tmp_path_factory.mktemp("layouts") / "out"
    options = ["--with-pictures", "--playback-duration", "12"]
    worm("replay", ROOT / "bags/larva", "--out", out, *options).check_returncode()
    return messages_by_topic(out)


def plotted():
    """Return every path of a Foxglove plot with what is said of it."""
    for panel, config in PANELS.items():
        if panel.startswith("Plot!"):
            yield from config["paths"]
            if "xAxisPath" in config:
                yield config["xAxisPath"]


def values_at(message, path):
    """Return what a Foxglove message path finds: fields, [number] and [:]."""
    found = [message]
    for name, index in re.findall(r"\.(\w+)|\[(\d+|:)\]", path):
        if name:
            found = [getattr(item, name) for item in found]
        elif index == ":":
            found = [each for item in found for each in item]
        else:
            found = [item[int(index)] for item in found]
    return found


@pytest.mark.parametrize("path", [*plotted()], ids=lambda path: path["value"])
def test_what_foxglove_plots_is_there(found, path):
    topic, _, fields = path["value"].partition(".")
    assert path["enabled"] is True
    seen = [value for _, message in found[topic] for value in values_at(message, "." + fields)]
    assert len(seen) > 10
    index = re.fullmatch(r"position\[(\d+)\]", fields)
    if index:
        (_, message) = found[topic][0]
        assert message.name[int(index.group(1))] == path["label"]


def test_the_curve_that_is_called_c_theta_is_c_theta(found):
    (_, message), *_ = found["/analysis/correlation"]
    assert message.joint_names[0] == "C_theta"
    lags = [point.time_from_start for point in message.points]
    assert lags[0].sec == lags[0].nanosec == 0
    assert message.points[0].positions[0] == pytest.approx(1.0)


def test_the_picture_has_its_camera_and_its_annotations(found):
    mode = PANELS["Image!worm"]["imageMode"]
    (annotations,) = mode["annotations"]
    for topic in (mode["imageTopic"], mode["calibrationTopic"], annotations):
        assert len(found[topic]) > 100
    assert len(found[mode["imageTopic"]]) == len(found[annotations])


def test_the_scene_stands_on_a_frame_that_is_there(found):
    scene = PANELS["3D!rig"]
    frames = {item.child_frame_id for _, tf in found["/tf_static"] for item in tf.transforms}
    assert scene["followTf"] in frames
    for topic in scene["topics"]:
        assert found[topic]


def test_the_same_topics_are_served_live():
    used = {path["value"].partition(".")[0] for path in plotted()} | {
        *PANELS["3D!rig"]["topics"],
        PANELS["Image!worm"]["imageMode"]["imageTopic"],
        PANELS["Image!worm"]["imageMode"]["calibrationTopic"],
        *PANELS["Image!worm"]["imageMode"]["annotations"],
    }
    assert used <= {"/" + topic for topic in SERVED}


def test_every_panel_is_placed_once():
    def leaves(node):
        if isinstance(node, str):
            return [node]
        return leaves(node["first"]) + leaves(node["second"])

    assert sorted(leaves(FOXGLOVE["layout"])) == sorted(PANELS)


@pytest.mark.parametrize(
    "curve", [item.get("name") for item in PLOTJUGGLER.iter("curve")], ids=lambda name: name
)
def test_what_plotjuggler_plots_is_there(found, curve):
    """Of a JointState it makes a series ``TOPIC/NAME/position`` for each name."""
    topic, name, field = curve.rsplit("/", 2)
    assert field == "position"
    assert all(name in message.name for _, message in found[topic])
    assert len(found[topic]) > 100
