"""`worm model` prints what the exact walk says, draws it, and refuses bad parameters."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_msgs_py.errors import BadInput


def run(*arguments):
    return CliRunner().invoke(app, ["model", *map(str, arguments)], catch_exceptions=False)


def solved(*arguments):
    done = run("solve", "--json", *arguments)
    assert done.exit_code == 0
    return json.loads(done.stdout)


def test_the_known_walk_is_solved_and_says_what_it_rests_on():
    found = solved("--exit-width-mm", 1, "--reversal", 0.3, "--at-s", 10, "--at-s", 30)
    assert found["mean_s"] == pytest.approx(50.88, abs=0.005)
    assert found["skips"] == pytest.approx(0.151, abs=0.0005)
    assert found["at_s"] == [10.0, 30.0]
    assert 1.0 > found["survival"][0] > found["survival"][1] > 0.0
    assert found["interval_90_s"][0] < found["median_s"] < found["interval_90_s"][1]
    assert found["start"] == "uniform"
    assert found["parameters"]["rule"] == "per_cycle"
    assert found["parameters"]["exit_arc_mm"] == pytest.approx(1.803, abs=0.001)
    assert "counter-clockwise" in found["conventions"]["theta"]


def test_every_option_of_the_walk_reaches_it():
    options = {
        "--exit-width-mm": ("exit_width_mm", 2.0),
        "--radius-mm": ("radius_mm", 12.0),
        "--depth-mm": ("depth_mm", 1.0),
        "--speed-mm-s": ("speed_mm_s", 3.0),
        "--slide-mm": ("mean_slide_mm", 1.0),
        "--hop-mm": ("mean_hop_mm", 2.0),
        "--reversal": ("reversal", 0.1),
        "--rule": ("rule", "rate"),
    }
    given = [part for option, (_, value) in options.items() for part in (option, value)]
    found = solved(*given, "--no-hop-may-land")["parameters"]
    assert {name: found[name] for name, _ in options.values()} == dict(options.values())
    assert not found["hop_may_land"]
    assert not solved("--no-effective-width")["parameters"]["effective_width"]


def test_a_state_and_its_mirror_image_are_solved():
    left = solved("--theta-deg", 60, "--direction", "cw", "--phase", "hop")
    right = solved("--theta-deg", -60, "--direction", "ccw", "--phase", "hop")
    assert left["mean_s"] == pytest.approx(right["mean_s"])
    assert left["start"]["direction"] == "cw"
    assert solved("--theta-deg", 60, "--direction", "ccw")["mean_s"] > left["mean_s"]


def test_a_persistence_that_there_is_not_says_why():
    found = solved("--reversal", 0)
    assert found["t_per_s"] is None
    assert "never" in found["t_per_why"]


def test_the_table_has_every_number():
    shown = run("solve", "--at-s", 12.5, "--theta-deg", 90, "--direction", "cw").stdout
    for word in ("mean τ_h", "sd", "median", "skips", "not found by 12.5 s", "t_per", "90°, cw"):
        assert word in shown


def test_figures_are_written_whole_and_the_same_each_time(tmp_path):
    for name in ("one.svg", "two.svg"):
        assert run("figure", "--out", tmp_path / name, "--rule", "per_phase").exit_code == 0
    one = (tmp_path / "one.svg").read_text(encoding="utf-8")
    assert one == (tmp_path / "two.svg").read_text(encoding="utf-8")
    assert one.startswith("<?xml")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.svg", "two.svg"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        pytest.param(["solve", "--exit-width-mm", "70"], "shorter than the wall's", id="wide exit"),
        pytest.param(
            ["solve", "--reversal", "1.5"], "--reversal is 1.5: give a share", id="reversal"
        ),
        pytest.param(["solve", "--theta-deg", "30"], "--direction", id="no direction"),
        pytest.param(["solve", "--direction", "cw"], "--theta-deg", id="no angle"),
        pytest.param(
            ["solve", "--theta-deg", "0", "--direction", "cw"], "has found the exit", id="in it"
        ),
        pytest.param(
            ["solve", "--no-effective-width", "--depth-mm", "1"], "leave out --depth-mm", id="h"
        ),
        pytest.param(["compare", "--rule", "rate"], "--rule is for predictions", id="no results"),
        pytest.param(["figure", "--out", "walk.gif"], ".svg, .png, .pdf", id="suffix"),
        pytest.param(
            ["figure", "--out", "no/such/walk.svg"], "there is no directory", id="directory"
        ),
        pytest.param(
            ["figure", "--out", "walk.svg", "--rule", "rate"], "per_cycle or per_phase", id="rate"
        ),
    ],
)
def test_bad_parameters_are_refused_and_leave_nothing(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=re.escape(words)):
        run(*arguments)
    assert not list(tmp_path.iterdir())


def test_bad_parameters_are_one_line_and_status_2():
    done = subprocess.run(
        [Path(sys.executable).with_name("worm"), "model", "solve", "--exit-width-mm", "70"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert "shorter than the wall's" in done.stderr


def test_a_machine_s_first_figure_says_nothing_of_fonts(tmp_path):
    at_once = (
        "import sys, threading, matplotlib\n"
        "timer = threading.Timer\n"
        "threading.Timer = lambda seconds, *said: timer(0, *said)\n"
        "from worm_bringup.cli.app import main\n"
        "main()\n"
    )
    figure = tmp_path / "walk.svg"
    done = subprocess.run(
        [sys.executable, "-c", at_once, "model", "figure", "--out", figure],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"MPLCONFIGDIR": str(tmp_path)},
    )
    assert done.returncode == 0
    assert done.stderr == ""
    assert figure.exists()
