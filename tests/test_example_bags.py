"""The example bags are what `bags/build.py` makes, byte for byte, and what their README says."""

import importlib.util
import json
import re
import sys
import zipfile
from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from rosbags.rosbag2 import Reader
from typer.testing import CliRunner

from worm_analysis.parameters import AnalysisParameters
from worm_analysis.report.figures.trajectories import _rows_in
from worm_analysis.results import read_results
from worm_bringup.cli.app import app
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import rig_of_summary
from worm_bringup.tracks.track_table import TrackTable
from worm_model.filament.parameters import FILAMENT, FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.strokes import PERISTALSIS_RAD
from worm_model.filament.trial import _start_at_rest, simulate
from worm_model.simulator.film import encode
from worm_model.simulator.rig import Optics
from worm_model.simulator.rig.views import both_chambers

BAGS = Path(__file__).parents[1] / "bags"


@pytest.fixture(scope="module")
def build():
    spec = importlib.util.spec_from_file_location("bags_build", BAGS / "build.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def larva_truth():
    return pq.read_table(BAGS / "larva_truth.parquet")


def stamps(bag):
    with Reader(bag) as reader:
        return [stamp for _, stamp, _ in reader.messages()]


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE).astype(int)


def test_larva_film_is_drawn_again_with_the_same_pictures(build, larva_truth):
    """Bytes are the same on one machine; another processor may round a few pixels otherwise."""
    film = list(islice(build.larva_film(6), 6))
    kept = build.jpegs_of_bag(BAGS / "larva")
    for frame in film:
        again = decoded(encode(frame.picture, build.LARVA_JPEG_QUALITY))
        difference = np.abs(again - decoded(kept[frame.truth.frame]))
        assert (difference > 0).mean() < 0.01
        assert difference.max() < 12
    row = larva_truth.slice(5, 1).to_pylist()[0]
    assert row["head_u_px"] == pytest.approx(film[5].truth.head_u_px, abs=1e-6)
    assert row["midline_v_px"] == pytest.approx(film[5].truth.midline_v_px, abs=1e-6)


def test_larva_bag_and_truth_have_the_same_frames(larva_truth):
    assert stamps(BAGS / "larva") == larva_truth["stamp_ns"].to_pylist()
    assert larva_truth["frame"].to_pylist() == list(range(800))
    assert np.diff(larva_truth["stamp_ns"]).tolist() == [62_500_000] * 799


def test_larva_stays_in_the_chamber_touches_the_wall_and_crawls_forwards(larva_truth):
    columns = {name: larva_truth[name].to_numpy() for name in ("r_h_mm", "r_c_mm", "r_t_mm")}
    assert max(columns["r_h_mm"].max(), columns["r_t_mm"].max()) < 10.0
    assert columns["r_h_mm"].max() > 9.9
    assert set(larva_truth["where"].to_pylist()) == {"chamber_a"}
    x, y, head_x, head_y = (
        larva_truth[name].to_numpy()
        for name in ("centroid_x_mm", "centroid_y_mm", "head_x_mm", "head_y_mm")
    )
    step = 16  # one second
    advance = (x[step:] - x[:-step]) * (head_x - x)[:-step]
    advance += (y[step:] - y[:-step]) * (head_y - y)[:-step]
    assert (advance > 0).mean() > 0.85


def test_larvas_head_and_tail_never_change_places(larva_truth):
    head, tail = (
        np.stack([larva_truth[f"{end}_{axis}_px"].to_numpy() for axis in "uv"], axis=1)
        for end in ("head", "tail")
    )
    assert np.hypot(*np.diff(head, axis=0).T).max() < 30.0
    assert np.hypot(*np.diff(tail, axis=0).T).max() < 30.0


def test_wormtracer_bag_is_rebuilt_from_itself(build, tmp_path):
    build.build_wormtracer(tmp_path / "wormtracer", frames=20)
    made, kept = (
        build.jpegs_of_bag(tmp_path / "wormtracer"),
        build.jpegs_of_bag(BAGS / "wormtracer"),
    )
    assert made == kept[:20]
    assert stamps(tmp_path / "wormtracer") == stamps(BAGS / "wormtracer")[:20]


def test_wormtracer_has_1500_frames_at_66_hz_and_a_mask_for_each(build):
    assert stamps(BAGS / "wormtracer") == [round(k * 1e9 / 66) for k in range(1500)]
    picture = cv2.imdecode(
        np.frombuffer(build.jpegs_of_bag(BAGS / "wormtracer")[700], np.uint8), cv2.IMREAD_GRAYSCALE
    )
    with zipfile.ZipFile(BAGS / "wormtracer_masks.zip") as masks:
        names = sorted(masks.namelist())
        mask = cv2.imdecode(np.frombuffer(masks.read(names[700]), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert len(names) == 1500
    assert mask.shape == picture.shape == (221, 255)
    inside = mask == mask[mask.shape[0] // 2 :].max()
    rarer = inside if inside.mean() < 0.5 else ~inside
    assert picture[rarer].mean() > 1.5 * picture[~rarer].mean()


def truth_of_trial():
    return pq.read_table(BAGS / "trial_truth.parquet").to_pydict()


def test_the_trial_is_simulated_again_with_the_same_worm(build):
    """Only its first second: the rest follows from it."""
    words = dict(zip(build.TRIAL[::2], build.TRIAL[1::2], strict=False))
    again = simulate(
        FilamentParameters(),
        FilamentRig(exit_width_mm=float(words["--exit-width-mm"])),
        seed=int(words["--seed"]),
        duration_s=1.0,
        frames_per_s=float(words["--fps"]),
    )
    truth = truth_of_trial()
    head = np.stack([truth["head_x_mm"][:10], truth["head_y_mm"][:10]], axis=1)
    np.testing.assert_allclose(again.midline_mm[:, 0], head, atol=1e-6)


def test_the_trial_has_contacts_in_both_chambers_failed_attempts_and_an_escape():
    truth = truth_of_trial()
    assert stamps(BAGS / "trial") == truth["stamp_ns"]
    where = np.array(truth["where"])
    touches = np.array([contact is True for contact in truth["contact"]])
    for chamber in ("chamber_a", "chamber_b"):
        assert (touches & (where == chamber)).sum() > 50
    changes = where[np.r_[True, where[1:] != where[:-1]]].tolist()
    ways = list(zip(changes, changes[1:], changes[2:], strict=False))
    assert ("chamber_a", "passage", "chamber_b") in ways  # an escape
    assert any(a == c and b == "passage" for a, b, c in ways)  # an attempt that failed
    size = sum(path.stat().st_size for path in (BAGS / "trial").iterdir())
    assert size < 20e6


def test_the_pool_has_trials_over_the_papers_widths_and_was_analysed_by_this_software():
    trials = [read_results(path) for path in sorted((BAGS / "pool").iterdir())]
    widths = [1e3 * trial.chambers[0].exit_width_m for trial in trials]
    assert widths == pytest.approx([0.5, 5.0, 3.0, 1.0, 5.0, 0.5, 5.0, 3.0, 1.0, 5.0, 3.0, 3.0])
    size = sum(path.stat().st_size for path in (BAGS / "pool").rglob("*") if path.is_file())
    assert size < 5e6


TOLD_AT_EVERY_WIDTH = ("tau_h", "n_s", "success", "beta", "failures_without_contact")


def test_the_pool_has_data_for_every_figure_and_every_number_of_the_paper(tmp_path):
    trials = [str(path) for path in sorted((BAGS / "pool").iterdir())]
    done = CliRunner().invoke(app, ["report", *trials, "--out", str(tmp_path / "pooled")])
    assert done.exit_code == 0, done.output
    page = (tmp_path / "pooled" / "report.html").read_text()
    drawn = re.findall(r'<figure id="([^"]+)"(?: class="([^"]*)")?>', page)
    assert len(drawn) > 10
    assert [name for name, kind in drawn if kind == "none"] == []
    by_width = json.loads((tmp_path / "pooled" / "summary.json").read_text())["by_width"]
    assert sorted(by_width) == ["0.5", "1", "3", "5"]
    for width, told in by_width.items():
        wanted = list(TOLD_AT_EVERY_WIDTH)
        if width != "5":  # where the paper tells none
            wanted.append("failures_touching_in_elongation")
        assert [name for name in wanted if told[name]["value"] is None] == [], width


def test_phases_of_the_stroke_told_in_the_pool_are_the_simulated_worms_own():
    """Told is the half stroke before x_p, by the length, which a withdrawal changes as well."""
    right, told, failures = 0, 0, 0
    for place in sorted((BAGS / "pool").iterdir()):
        source = read_results(place).provenance["source"]
        failed = [
            row
            for row in pq.read_table(place / "passages.parquet").to_pylist()
            if row["record"] == "attempt" and row["complete"] and not row["success"]
        ]
        failures += len(failed)
        known = [row for row in failed if row["stroke_phase"] != "unknown"]
        told += len(known)
        tracks = pq.read_table(place / "tracks.parquet", columns=["stamp_ns", "head_x_mm"])
        stamp_ns, x_mm = (tracks.column(name).to_numpy() for name in tracks.column_names)
        for row in known:
            during = (stamp_ns >= row["start_ns"]) & (stamp_ns <= row["end_ns"])
            deepest_s = 1e-9 * stamp_ns[during][np.argmax(x_mm[during])]
            grows = stroke_grows(int(source["seed"]), deepest_s - 0.15)
            right += row["stroke_phase"] == ("elongation" if grows else "contraction")
    assert told > 30
    assert told > 0.7 * failures
    assert right > 0.95 * told


def stroke_grows(seed, time_s):
    begin = np.random.default_rng(np.random.SeedSequence(seed).spawn(5)[0])
    worm, rig = FilamentParameters(), FilamentRig(exit_width_mm=1.0)
    _, activity = _start_at_rest(worm, rig, begin, FILAMENT)
    turns = (time_s + FILAMENT.settle_s) / worm.peristalsis_s
    return np.cos(2.0 * np.pi * turns + activity[PERISTALSIS_RAD]) > 0.0


def test_a_trial_of_the_pool_is_analysed_again_with_the_same_numbers(tmp_path):
    kept = BAGS / "pool" / "trial_03"
    results = read_results(kept)
    table = TrackTable(kept / "tracks.parquet")
    tmp_path.joinpath("again").mkdir()
    rig = rig_of_summary(kept / "summary.json")
    analyse_tracks(table, rig, AnalysisParameters(), tmp_path / "again")
    again = read_results(tmp_path / "again")
    for quantity in results.quantities:
        assert again.quantity(quantity.name).value == pytest.approx(quantity.value, nan_ok=True)


def test_a_frame_in_the_middle_of_the_passage_is_drawn_in_its_own_chambers_frame():
    """There the millimetres of both frames are nearly the same."""
    kept = read_results(BAGS / "pool" / "trial_01")
    rig = both_chambers(20.0, 3.0, Optics()).chambers
    own = [_rows_in(kept, chamber) for chamber in kept.chambers]
    pixels = np.full((2, len(kept.t_s)), np.nan)
    for chamber, rows in zip(rig, own, strict=True):
        x_m, y_m = (1e-3 * kept.tracks[f"head_{axis}_mm"][rows] for axis in "xy")
        pixels[:, rows] = chamber.to_pixels(x_m, y_m)
    tracks = {**kept.tracks, "head_u_px": pixels[0], "head_v_px": pixels[1]}
    seen = replace(kept, chambers=rig, tracks=tracks)
    middle = np.abs(kept.tracks["head_x_mm"] - 27.5) < 0.4
    assert middle.sum() > 5
    for chamber, rows in zip(rig, own, strict=True):
        np.testing.assert_array_equal(_rows_in(seen, chamber), rows)
