"""`worm calibrate`: what it finds is shown, written after a yes alone, and tracks as before."""

from math import hypot
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import run_command
from typer.testing import CliRunner

from worm_bringup.cli import calibrate as command
from worm_bringup.cli.app import app
from worm_bringup.rig.rig_file import read_rig
from worm_msgs_py.ros.network import Reach, dds_settings
from worm_tracker.calibration.calibrate import CALIBRATION

BAGS = Path(__file__).parents[3] / "bags"


def worm(folder, *words, **environment):
    given = dds_settings(Reach.OWN) | environment
    return run_command([str(word) for word in words], folder, given)


def real(values):
    """Return numbers, NaN where there is none."""
    return np.array([np.nan if value is None else value for value in values])


@pytest.mark.parametrize(("bag", "part"), [("larva", 1.5), ("trial", 2.0)])
def test_a_replay_with_the_file_gives_the_tracks_of_one_without(tmp_path, bag, part):
    status, said = worm(tmp_path, "calibrate", BAGS / bag, "--out", "rig.yaml", "--yes")
    assert status == 0, said
    assert "16 of 16 pictures agree" in said
    tracks = []
    for out, more in (("with", ["--rig", "rig.yaml"]), ("without", [])):
        words = ("--out", out, "--playback-duration", part, *more)
        status, said = worm(tmp_path, "replay", BAGS / bag, *words)
        assert status == 0, said
        tracks.append(pq.read_table(tmp_path / out / "tracks.parquet").to_pydict())
    with_file, without = tracks
    assert with_file["status"] == without["status"]
    rig = read_rig([tmp_path / "rig.yaml"]).of("tracker")
    within_px = 3.0 * hypot(*2 * (CALIBRATION.common_to_pictures_sd_px,))  # of centre and radius
    within_mm = within_px * 1e3 * rig["radius_m"] / rig["radius_px"]
    for point in ("head", "centroid", "tail"):
        for axis in "uv":
            name = f"{point}_{axis}_px"
            np.testing.assert_allclose(real(with_file[name]), real(without[name]), atol=within_px)
        for axis in "xy":
            name = f"{point}_{axis}_mm"
            np.testing.assert_allclose(real(with_file[name]), real(without[name]), atol=within_mm)


def test_the_picture_beside_shows_walls_exit_and_scale(tmp_path):
    assert worm(tmp_path, "calibrate", BAGS / "larva", "--out", "rig.yaml", "--yes")[0] == 0
    drawn = cv2.imread(str(tmp_path / "rig.png")).astype(int)
    coloured = np.ptp(drawn, axis=2) > 40
    rig = read_rig([tmp_path / "rig.yaml"]).of("tracker")
    v, u = np.nonzero(coloured)
    off = np.hypot(u - rig["centre_u_px"], v - rig["centre_v_px"]) - rig["radius_px"]
    on_wall = np.abs(off) < 6.0
    exit_ = np.radians(rig["exit_deg"])
    angle = np.arctan2(rig["centre_v_px"] - v[on_wall], u[on_wall] - rig["centre_u_px"])
    assert len(np.unique(np.degrees(angle).round())) >= 359
    assert (np.abs(np.angle(np.exp(1j * (angle - exit_)))) < 0.01).any()
    bar = u[~on_wall]
    assert np.ptp(bar) == pytest.approx(5.0 * rig["radius_px"] / 10.0, abs=8.0)  # 5 mm
    assert (v[~on_wall] > 0.9 * drawn.shape[0]).all()


@pytest.fixture
def at_a_terminal(monkeypatch, tmp_path):
    """Run the command as if somebody sat there, who answers."""
    monkeypatch.setattr(command, "_somebody_is_there", lambda: True)
    monkeypatch.delenv("WORM_CAMERA", raising=False)
    out = tmp_path / "rig.yaml"

    def run(answer, *more):
        words = ["calibrate", str(BAGS / "larva"), "--out", str(out), *more]
        return CliRunner().invoke(app, words, input=answer)

    return run, out


def test_nothing_is_written_before_a_yes(at_a_terminal):
    run, out = at_a_terminal
    said = run("n\n")
    assert said.exit_code == 1
    assert "centre 507.37" in said.output
    assert "Nothing was written." in said.output
    assert list(out.parent.iterdir()) == []
    shown = said.output.partition("Look at ")[2].partition(":")[0]
    assert shown.endswith("rig.png")
    assert not Path(shown).exists()
    assert run("y\n").exit_code == 0
    assert out.exists()
    assert out.with_suffix(".png").exists()


def test_a_file_that_is_there_is_replaced_by_consent_alone(at_a_terminal):
    run, out = at_a_terminal
    out.write_text("mine", encoding="utf-8")
    said = run("n\n")
    assert f"Replace {out}?" in said.output
    assert out.read_text(encoding="utf-8") == "mine"
    refused = run("", "--yes")
    assert "add --overwrite" in str(refused.exception)
    assert out.read_text(encoding="utf-8") == "mine"
    assert run("", "--yes", "--overwrite").exit_code == 0
    assert "polarity" in out.read_text(encoding="utf-8")
    out.write_text("mine", encoding="utf-8")
    assert run("y\n").exit_code == 0
    assert "polarity" in out.read_text(encoding="utf-8")


def test_a_file_of_before_gives_what_no_picture_shows_and_keeps_other_nodes(tmp_path):
    (tmp_path / "before.yaml").write_text(
        "/**/tracker:\n  ros__parameters:\n    radius_m: 0.012\n    depth_m: 0.002\n"
        "    centre_u_px: 1.0\n    centre_v_px: 2.0\n    radius_px: 30.0\n"
        "/**/recorder:\n  ros__parameters:\n    date: 2026-03-21\n    animal: 'no: 7'\n",
        encoding="utf-8",
    )
    words = ("--rig", "before.yaml", "--depth-mm", "1.8", "--yes", "--out", "rig.yaml")
    status, said = worm(tmp_path, "calibrate", BAGS / "larva", *words)
    assert status == 0, said
    assert "if R is 12 mm" in said
    rig = read_rig([tmp_path / "rig.yaml"])
    tracker = rig.of("tracker")
    assert (tracker["radius_m"], tracker["depth_m"]) == (0.012, 0.0018)
    assert tracker["radius_px"] == pytest.approx(400.0, abs=0.1)
    assert rig.of("recorder") == {"date": "2026-03-21", "animal": "no: 7"}


def test_a_camera_is_looked_at_and_stands_in_the_file(tmp_path):
    status, said = worm(tmp_path, "calibrate", "--camera", "sim", "--out", "rig.yaml", "--yes")
    assert status == 0, said
    rig = read_rig([tmp_path / "rig.yaml"])
    assert rig.of("image_source") == {"camera": "sim"}
    assert rig.of("tracker")["radius_px"] == pytest.approx(200.0, abs=0.1)
    assert rig.of("tracker")["exit_width_m"] == pytest.approx(2e-3, abs=1e-5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["larva"], "nobody is here to look and say yes"),
        (["--yes"], "give either a bag or --camera"),
        (["larva", "--camera", "sim", "--yes"], "give either a bag or --camera"),
        (["wormtracer", "--yes"], "wormtracer: 0 of 16 pictures show a circular wall"),
        (["gone", "--yes"], "gone: no such bag"),
    ],
)
def test_what_cannot_be_calibrated_is_one_line(tmp_path, words, said):
    words = [BAGS / word if not word.startswith("-") and word != "sim" else word for word in words]
    status, printed = worm(tmp_path, "calibrate", *words, "--out", "rig.yaml")
    assert status == 2
    assert len(printed.strip().splitlines()) == 1
    assert said in printed
    assert not (tmp_path / "rig.yaml").exists()


def test_a_bag_wins_over_the_camera_of_the_environment(tmp_path):
    words = ("calibrate", BAGS / "larva", "--out", "rig.yaml", "--yes")
    assert worm(tmp_path, *words, WORM_CAMERA="/dev/video9")[0] == 0
    assert read_rig([tmp_path / "rig.yaml"]).of("image_source") == {}
