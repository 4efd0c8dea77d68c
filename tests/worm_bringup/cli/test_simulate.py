"""`worm simulate` makes bags and tables of a worm whose truth is known, the same by seed."""

import json
import sys

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage

from worm_analysis.results import read_results
from worm_bringup.cli.app import main
from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import simulate
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.image_decoder import PictureDecoder

STEP_MM = 1 / 256
"""Tables without pictures hold millimetres in these steps."""


@pytest.fixture
def worm(monkeypatch, capsys):
    """Return a function that runs `worm simulate` and gives exit status and last line."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["worm", "simulate", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        return ended.value.code or 0, (said.err if ended.value.code else said.out).splitlines()

    return run


def files_in(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_bag_has_a_picture_and_a_row_of_truth_for_each_frame(worm, tmp_path):
    status, said = worm("--out", tmp_path / "crawl", "--minutes", 0.02, "--fps", 10)
    assert (status, said[-1]) == (0, f"Truth: {tmp_path / 'crawl_truth.parquet'}")
    truth = pq.read_table(tmp_path / "crawl_truth.parquet").to_pydict()
    with BagPictures(tmp_path / "crawl") as pictures:
        stamps = [picture.stamp_ns for picture in pictures]
    assert stamps == truth["stamp_ns"] == [100_000_000 * frame for frame in range(12)]
    worm_now = simulate(
        FilamentParameters(), FilamentRig(), seed=0, duration_s=1.2, frames_per_s=10.0
    )
    heads = np.stack([truth["head_x_mm"], truth["head_y_mm"]], axis=1)
    np.testing.assert_allclose(heads, worm_now.midline_mm[:, 0], atol=1e-6)


@pytest.mark.parametrize("words", [[], ["--model", "walk", "--one-chamber"]])
def test_the_same_seed_gives_the_same_bytes_and_another_one_does_not(worm, tmp_path, words):
    short = ("--minutes", 0.01, "--fps", 10, "--px-per-mm", 10, *words)
    for name, seed in (("a", 4), ("b", 4), ("c", 5)):
        (tmp_path / name).mkdir()
        assert worm("--out", tmp_path / name / "bag", "--seed", seed, *short)[0] == 0
    a, b, c = (files_in(tmp_path / name) for name in "abc")
    assert a == b
    assert a["bag_truth.parquet"] != c["bag_truth.parquet"]


def test_many_trials_of_tables_alone_take_turns_in_w_and_can_be_pooled(worm, tmp_path):
    out = tmp_path / "pool"
    words = ("--minutes", 0.5, "--fps", 15, "--exit-width-mm", 1, "--exit-width-mm", 3)
    assert worm("--out", out, "--trials", 3, "--tracks-only", "--seed", 7, *words)[0] == 0
    trials = [read_results(out / f"trial_{index:02d}") for index in range(3)]
    assert [trial.chambers[0].exit_width_m for trial in trials] == [1e-3, 3e-3, 1e-3]
    assert [int(trial.provenance["source"]["seed"]) for trial in trials] == [7, 8, 9]
    for trial in trials:
        assert len(trial.tracks["frame"]) == 450
        assert np.isfinite(trial.tracks["psi_b_deg"]).mean() > 0.9
    summary = json.loads((out / "trial_01" / "summary.json").read_text())
    truth = simulate(
        FilamentParameters(),
        FilamentRig(exit_width_mm=3.0),
        seed=8,
        duration_s=30.0,
        frames_per_s=15.0,
    )
    assert summary["provenance"]["source"]["simulated"] == "filament"
    head = np.hypot(trials[1].tracks["head_x_mm"], trials[1].tracks["head_y_mm"])
    np.testing.assert_allclose(head, np.hypot(*truth.midline_mm[:, 0].T), atol=STEP_MM)


def test_tables_are_those_of_the_film_s_truth(worm, tmp_path):
    words = ("--minutes", 0.02, "--fps", 10, "--px-per-mm", 20)
    assert worm("--out", tmp_path / "bag", *words)[0] == 0
    assert worm("--out", tmp_path / "tables", "--tracks-only", *words)[0] == 0
    truth = pq.read_table(tmp_path / "bag_truth.parquet").to_pydict()
    tracks = pq.read_table(tmp_path / "tables" / "tracks.parquet").to_pydict()
    for name, within in (("head_x_mm", STEP_MM), ("tail_y_mm", STEP_MM), ("centroid_x_mm", 0.02),
                         ("centroid_y_mm", 0.02), ("psi_b_deg", 0.3), ("psi_h_deg", 1.5),
                         ("length_mm", 0.02)):  # fmt: skip
        np.testing.assert_allclose(tracks[name], truth[name], atol=within, err_msg=name)


def test_a_deep_film_is_read_back_as_16_bits(worm, tmp_path):
    words = ("--minutes", 0.005, "--fps", 10, "--px-per-mm", 8, "--bits", 16)
    assert worm("--out", tmp_path / "bag", *words)[0] == 0
    with BagPictures(tmp_path / "bag") as pictures:
        first = deserialize_message(next(iter(pictures)).raw, CompressedImage)
    stored = cv2.imdecode(np.asarray(first.data), cv2.IMREAD_UNCHANGED)
    assert (stored.dtype, stored.shape) == (np.uint16, (224, 640))
    seen = PictureDecoder().decode(first)
    assert (seen.dtype, seen.shape) == (np.uint8, (224, 640))


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--slide-mm", 2], "--slide-mm is the walk's"),
        (["--length-mm", 1], "length_mm = 1"),
        (["--length-mm", 2.5], "length_mm is 2.5; it must be at least head_mm = 3"),
        (["--body-width-mm", 5, "--length-mm", 10], "4 times width_mm = 5"),
        (["--body-width-mm", 5, "--exit-width-mm", 1], "--exit-width-mm is 1: a body 5 mm wide"),
        (["--exposure-ms", 50], "--exposure-ms is 50, longer than a frame: give 33"),
        (["--model", "walk", "--length-mm", 36], "the passage, which is 35 mm long"),
        (["--bits", 12], "--bits is 12: give 8 or 16"),
        (["--exit-width-mm", 1, "--exit-width-mm", 2], "give --trials, too"),
    ],
)
def test_what_does_not_go_together_is_refused_in_a_line(worm, tmp_path, words, why):
    status, said = worm("--out", tmp_path / "bag", *words)
    assert (status, len(said)) == (2, 1)
    assert why in said[0]
    assert list(tmp_path.iterdir()) == []


def test_a_closed_chamber_has_tables_too(worm, tmp_path):
    words = ("--minutes", 0.05, "--fps", 10, "--exit-width-mm", 0, "--tracks-only")
    assert worm("--out", tmp_path / "closed", *words)[0] == 0
    assert set(read_results(tmp_path / "closed").tracks["where"]) == {"chamber_a"}
