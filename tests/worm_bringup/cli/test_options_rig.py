"""--rig: every command that needs a rig takes the file, and an option wins over it."""

import json
from dataclasses import fields
from pathlib import Path

import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
import pytest
import typer
from forked_commands import run_command

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli import options
from worm_bringup.cli.app import app
from worm_msgs_py.ros.network import Reach, dds_settings
from worm_tracker.parameters import MOST_HOLD_BACK_FRAMES

pytestmark = pytest.mark.xdist_group("options of a rig")  # what they share is made once

LARVA = Path(__file__).parents[3] / "bags" / "larva"
RIG = """
/**:
  ros__parameters:
    radius_m: 0.01
    exit_width_m: 0.0021
    contact_factor: 0.35
/**/tracker:
  ros__parameters:
    hold_back_frames: 300
/**/model:
  ros__parameters:
    rule: per_phase
/**/image_source:
  ros__parameters:
    camera: film.avi
    playback_duration: 1.5
/**/recorder:
  ros__parameters:
    animal: worm 7 <of nine>
    temperature_c: 21.5
"""


def worm(folder, *words):
    return run_command([str(word) for word in words], folder, dds_settings(Reach.OWN))


def summary(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def replayed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rig")
    (folder / "rig.yaml").write_text(RIG, encoding="utf-8")
    other = RIG.replace("radius_m: 0.01", "radius_m: 0.012")
    (folder / "other.yaml").write_text(other, encoding="utf-8")
    words = ("--rig", "rig.yaml", "--max-gap-s", "0.7", "--exit-width-mm", "1.9")
    status, said = worm(folder, "replay", LARVA, *words, "--out", "out")
    assert status == 0, said
    table = pq.read_table(folder / "out" / "tracks.parquet")
    pa_csv.write_csv(table.select(["stamp_ns", "head_x_mm", "head_y_mm"]), folder / "tracks.csv")
    pa_csv.write_csv(table.select(["stamp_ns", "head_u_px", "head_v_px"]), folder / "pixels.csv")
    return folder


def test_a_replay_has_its_parameters_from_the_file_and_options_win(replayed):
    provenance = summary(replayed / "out")["provenance"]
    tracker, analysis = provenance["parameters"]["tracker"], provenance["parameters"]["analysis"]
    assert (tracker["exit_width_m"], tracker["radius_m"]) == (0.0019, 0.01)
    assert tracker["hold_back_frames"] == 300
    assert (analysis["contact_factor"], analysis["max_gap_s"]) == (0.35, 0.7)
    assert provenance["parameters"]["model"]["rule"] == "per_phase"
    assert provenance["source"]["playback_duration_s"] == 1.5
    assert provenance["trial"] == {"animal": "worm 7 <of nine>", "temperature_c": 21.5}


def test_the_report_says_at_its_head_what_was_noted(replayed):
    page = (replayed / "out" / "report.html").read_text(encoding="utf-8")
    head = page.partition("</header>")[0]
    assert "Animal: worm 7 &lt;of nine&gt;; Temperature: 21.5 °C." in head


def test_without_a_file_nothing_is_noted_and_frames_wait_as_long_as_they_may(replayed):
    words = ("--playback-duration", "1.5", "--out", "plain")
    assert worm(replayed, "replay", LARVA, *words)[0] == 0
    provenance = summary(replayed / "plain")["provenance"]
    assert "trial" not in provenance
    assert provenance["parameters"]["tracker"]["hold_back_frames"] == MOST_HOLD_BACK_FRAMES
    assert 'class="noted"' not in (replayed / "plain" / "report.html").read_text("utf-8")


def test_analyse_takes_lengths_contact_rule_and_notes_of_the_file(replayed):
    words = ("--rig", "rig.yaml", "--contact-factor", "0.4", "--out", "again")
    status, said = worm(replayed, "analyse", "tracks.csv", *words)
    assert status == 0, said
    provenance = summary(replayed / "again")["provenance"]
    assert provenance["trial"]["animal"] == "worm 7 <of nine>"
    assert provenance["parameters"]["analysis"]["contact_factor"] == 0.4
    assert provenance["parameters"]["rig"]["exit_width_mm"] == 2.1


def test_analyse_takes_the_walls_place_for_a_table_in_pixels_alone(replayed):
    place = "tracker:\n  ros__parameters:\n    centre_u_px: 500.0\n    centre_v_px: 510.0\n"
    (replayed / "place.yaml").write_text(
        place + "    radius_px: 400.0\n    exit_deg: 147.0\n", encoding="utf-8"
    )
    words = ("--rig", "rig.yaml", "--rig", "place.yaml")
    assert worm(replayed, "analyse", "pixels.csv", *words, "--out", "pixels")[0] == 0
    seen = summary(replayed / "pixels")["geometry"]["chamber_a"]
    assert (seen["centre_u_px"], seen["radius_px"], seen["exit_deg"]) == (500.0, 400.0, 147.0)
    assert worm(replayed, "analyse", "tracks.csv", *words, "--out", "metres")[0] == 0
    assert summary(replayed / "metres")["provenance"]["parameters"]["rig"]["circle_px"] is None


def test_analyse_refuses_a_file_that_contradicts_the_results_own_rig(replayed):
    assert worm(replayed, "analyse", "out", "--rig", "rig.yaml", "--out", "same")[0] == 0
    status, said = worm(replayed, "analyse", "out", "--rig", "other.yaml", "--out", "no")
    assert status == 2
    assert "rest on R = 10 mm, the rig file says 12" in said


def test_simulate_takes_the_exits_width_and_refuses_another_chamber(replayed):
    words = ("--minutes", "0.01", "--model", "walk", "--tracks-only", "--out", "made")
    assert worm(replayed, "simulate", "--rig", "rig.yaml", *words)[0] == 0
    assert summary(replayed / "made")["geometry"]["chamber_a"]["exit_width_mm"] == 2.1
    status, said = worm(replayed, "simulate", "--rig", "other.yaml", *words)
    assert status == 2
    assert "radius_m is 0.012: the simulated rig is the paper's" in said


def test_live_has_its_camera_from_the_file(replayed):
    status, said = worm(replayed, "live", "--rig", "rig.yaml", "--private")
    assert status == 2
    assert "film.avi" in said
    (replayed / "no_camera.yaml").write_text(
        "tracker:\n  ros__parameters:\n    radius_m: 0.01\n", encoding="utf-8"
    )
    status, said = worm(replayed, "live", "--rig", "no_camera.yaml", "--private")
    assert status == 2
    assert "give either --camera (or WORM_CAMERA) or --topic, or a rig file" in said


@pytest.mark.parametrize("command", ["replay", "live", "analyse", "simulate"])
def test_what_is_wrong_in_the_file_is_one_line_of_every_command(replayed, command):
    (replayed / "wrong.yaml").write_text(RIG.replace("radius_m", "radius_mm"), "utf-8")
    words = {"replay": [LARVA], "live": ["--camera", "sim"], "analyse": ["out"], "simulate": []}
    status, said = worm(
        replayed, command, *words[command], "--rig", "wrong.yaml", "--out", "nothing"
    )
    assert status == 2
    assert said.strip().splitlines() == [said.strip()]
    assert "wrong.yaml" in said
    assert "did you mean 'radius_m'" in said
    assert not (replayed / "nothing").exists()


def test_every_parameter_of_the_analysis_is_an_option_with_its_unit():
    known = {field.name for field in fields(options.AnalysisOptions)} - {"body_width_mm"}
    assert known | {"body_width_m"} == {field.name for field in fields(AnalysisParameters)}
    for name in ("replay", "live", "analyse"):
        command = typer.main.get_command(app).commands[name]
        written = {option for each in command.params for option in each.opts}
        assert {"--" + option.replace("_", "-") for option in known} <= written
