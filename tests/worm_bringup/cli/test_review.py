"""`worm review` refuses what it cannot show, and gives the command that replays a trial again."""

import shlex
import socket
import sys
from dataclasses import asdict
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from picture_bags import write_bag
from reviewed_trials import small_trial

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli.app import main
from worm_bringup.cli.replay_again import replay_command
from worm_model.inference.comparison import ModelParameters
from worm_tracker.parameters import MOST_HOLD_BACK_FRAMES, TrackerParameters


def refused(monkeypatch, capsys, *words):
    """Return the line with which the command refuses."""
    monkeypatch.setattr(sys, "argv", ["worm", "review", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        main()
    line = capsys.readouterr().err
    assert ended.value.code == 2
    assert line.count("\n") == 1
    return line


def test_what_is_no_result_is_refused_in_a_line(monkeypatch, capsys, tmp_path):
    assert "no such results directory" in refused(monkeypatch, capsys, tmp_path / "none")
    assert "summary.json" in refused(monkeypatch, capsys, tmp_path)
    results = small_trial(tmp_path / "out")
    assert "nowhere" in refused(monkeypatch, capsys, results, "--bag", tmp_path / "nowhere")
    assert "is not the bag of" in refused(
        monkeypatch, capsys, results, "--bag", write_bag(tmp_path / "film")
    )
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert f"port {port}" in refused(monkeypatch, capsys, results, "--port", port)
    (results / "summary.json").write_text("{")
    assert "summary.json" in refused(monkeypatch, capsys, results)


def told(source=None, trial=None, **parameters):
    """Return the provenance of a trial that was run with some parameters."""
    defaults = {
        "tracker": asdict(TrackerParameters(hold_back_frames=MOST_HOLD_BACK_FRAMES)),
        "analysis": asdict(AnalysisParameters()),
        "model": asdict(ModelParameters()),
    }
    found = {
        "source": {"bag": "film", "topic": "image_raw"} | (source or {}),
        "parameters": {
            node: {name: value if value == value else None for name, value in its.items()}
            | parameters.get(node, {})
            for node, its in defaults.items()
        },
    }
    return found | ({"trial": trial} if trial else {})


def given_again(monkeypatch, command):
    """Return the parameters that `worm replay` gives the nodes when the command is typed."""
    words = shlex.split(command)
    seen = {}

    def take(trial, out, *_, **__):
        seen.update(trial.parameters, source=trial.source.parameters, out=out)
        raise KeyboardInterrupt

    monkeypatch.setattr("worm_bringup.cli.replay.run_trial", take)
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit):
        main()
    return seen


def test_a_trial_with_defaults_needs_no_options():
    command = replay_command(Path("out/a b"), told(), Path("bags/film"))
    assert command.line == (
        "worm replay bags/film --topic image_raw --corrections 'out/a b' --out 'out/a b-corrected'"
    )
    assert command.stands_for == ""


def test_a_live_trials_frames_wait_no_longer_when_it_is_replayed():
    of_live = {"hold_back_frames": TrackerParameters().hold_back_frames}
    command = replay_command(Path("out"), told(tracker=of_live), Path("bags/film"))
    assert "--hold-back-frames 256 " in command.line
    assert command.stands_for == ""


def test_a_trial_that_is_corrected_already_is_corrected_in_its_place():
    line = replay_command(Path("out/t-corrected"), told(), Path("film")).line
    assert line.endswith("--corrections out/t-corrected --out out/t-corrected")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"trial": {"notes": "x", "animal": "y"}}, "recorder, notes, animal as in summary.json"),
        ({"tracker": {"calibration_frames": 20}}, "tracker, calibration_frames: 20"),
        ({"model": {"rule": "rate"}}, "model, rule: rate"),
    ],
)
def test_the_command_names_what_the_results_do_not_lead_to(given, said):
    command = replay_command(Path("out"), told(**given), None)
    assert command.line.startswith("worm replay BAG ")
    assert "BAG stands for the bag" in command.stands_for
    assert " --rig RIG_FILE " in command.line
    assert said in command.stands_for


REAL = st.floats(0.004, 0.02)


@given(
    radius_m=REAL,
    width_m=st.floats(1e-4, 3e-3),
    depth_m=st.floats(5e-4, 5e-3),
    body_width_m=st.none() | st.floats(1e-4, 2e-3),
    factor=st.floats(0.1, 1.0),
)
@example(radius_m=0.01, width_m=0.002, depth_m=0.004, body_width_m=None, factor=1.0)  # as usual
def test_numbers_in_millimetres_lead_back_to_the_metres_that_were_used(
    radius_m, width_m, depth_m, body_width_m, factor
):
    provenance = told(
        tracker={"radius_m": radius_m, "exit_width_m": width_m, "depth_m": depth_m},
        analysis={"body_width_m": body_width_m, "release_factor": factor},
    )
    words = shlex.split(replay_command(Path("out"), provenance, None).line)
    options = dict(zip(words[3::2], words[4::2], strict=True))
    usual = TrackerParameters()
    for option, used_m, usual_m in (
        ("--radius-mm", radius_m, usual.radius_m),
        ("--exit-width-mm", width_m, usual.exit_width_m),
    ):
        told_m = float(options[option]) * 1e-3 if option in options else usual_m
        assert told_m == pytest.approx(used_m, rel=1e-15)
    assert ("--body-width-mm" in options) == (body_width_m is not None)


def test_the_command_gives_the_nodes_the_parameters_of_the_trial(monkeypatch, tmp_path):
    used = {
        "tracker": {
            "polarity": "bright", "radius_m": 0.0123, "centre_u_px": 200.5, "centre_v_px": 235.25,
            "radius_px": 160.125, "exit_deg": -3.5, "depth_m": 0.0017, "max_megapixels": 12.5,
        },
        "analysis": {"contact_factor": 0.4, "release_factor": 0.41, "minimum_n": 7,
                     "body_width_m": 0.00061, "max_gap_s": 0.25},
    }  # fmt: skip
    source = {"topic": "image_raw/compressed", "start_offset_s": "1.5", "playback_duration_s": "9"}
    command = replay_command(tmp_path / "out", told(source, **used), Path("bags/trial")).line
    command = command.replace(f"--corrections {tmp_path / 'out'} ", "")  # there are none here
    seen = given_again(monkeypatch, command)
    for node, its in told(**used)["parameters"].items():
        assert its == {k: v if v == v else None for k, v in seen[node].items()}
    assert seen["source"]["start_offset"] == 1.5
    assert seen["source"]["playback_duration"] == 9.0
    assert seen["out"] == tmp_path / "out-corrected"
