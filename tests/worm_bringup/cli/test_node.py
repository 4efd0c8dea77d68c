"""One node alone, as a user starts it: what it cannot use is one line and status 2."""

import subprocess
import sys

import pytest
from forked_commands import run_command

from worm_bringup.graph.nodes import NODES
from worm_msgs_py.ros.network import Reach, dds_settings

SEVERAL = """
/**:
  ros__parameters:
    radius_m: 0.012
    contact_factor: 0.4
/**/image_source:
  ros__parameters:
    camera: /dev/video0
"""


def refused(words, folder):
    status, said = run_command(words, folder, dds_settings(Reach.OWN))
    lines = [line for line in said.splitlines() if line and "[rcl]" not in line]
    assert status == 2, said
    assert len(lines) == 1, said
    return lines[0]


@pytest.mark.parametrize("name", NODES)
def test_a_misspelt_parameter_is_refused_by_every_node(tmp_path, name):
    said = refused(["node", name, "--ros-args", "-p", "polaritty:=dark"], tmp_path)
    assert "has no parameter 'polaritty'" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["trakcer"], "'trakcer' is not one of 'replay', 'camera'"),
        (["tracker", "radius_m:=0.01"], "put --ros-args before"),
        (["tracker", "--ros-args", "-p", "radius_m:=wide"], "radius_m is 'wide': give a number"),
        (["tracker", "--ros-args", "-p", "radius_m:=10.0"], "if that is in mm, give 0.01"),
        (["replay", "--ros-args", "-p", "loop:=1"], "loop is 1: give true or false"),
        (["model", "--ros-args", "-p", "rule:=never"], "rule is 'never': give per_cycle or"),
        (["analysis", "--ros-args", "-p", "radius_m:=0.01"], "has no parameter 'radius_m'"),
        (["tracker", "--ros-args", "--params-file", "gone.yaml"], "gone.yaml"),
        (["tracker", "--ros-args", "--params-file", "wrong.yaml"], "did you mean 'radius_m'"),
    ],
)
def test_what_a_node_cannot_use_is_one_line(tmp_path, words, said):
    wrong = SEVERAL.replace("radius_m", "radius_mm")
    (tmp_path / "wrong.yaml").write_text(wrong, encoding="utf-8")
    assert said in refused(["node", *words], tmp_path)


def test_a_file_may_speak_to_several_nodes_at_once(tmp_path):
    (tmp_path / "rig.yaml").write_text(SEVERAL, encoding="utf-8")
    words = ["--ros-args", "--params-file", "rig.yaml"]
    for name, said in (("replay", "no bag was given"), ("recorder", "give an existing, empty")):
        assert said in refused(["node", name, *words], tmp_path)
    words += ["-p", "contact_factor:=0.4"]  # from the command line it is for this node alone
    wrong = [*words, "-p", "min_episode_s:=1.0"]
    assert "'min_episode_s'" in refused(["node", "replay", *wrong], tmp_path)


def test_a_node_started_as_a_module_refuses_the_same(tmp_path):
    words = ["-m", NODES["tracker"], "--ros-args", "-p", "radius_mm:=10.0"]
    ended = subprocess.run([sys.executable, *words], capture_output=True, text=True, cwd=tmp_path)
    assert ended.returncode == 2
    assert "did you mean 'radius_m'" in ended.stderr
