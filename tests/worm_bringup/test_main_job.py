"""The main job as a user runs it: both example bags through the `worm` command, against truth."""

import io
import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import worm
from possible_values import impossible, impossible_in_tracks

from worm_analysis.results import contacts, passages, tracks

BAGS = Path(__file__).parents[2] / "bags"
FILES = {
    "tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet", "summary.json",
    "report.html",
}  # fmt: skip

# One worker for all of them: they share the two long runs.
pytestmark = pytest.mark.xdist_group("main job")


def script(*words):
    """Run the command as a user does; otherwise imports are saved."""
    command = [Path(sys.executable).with_name("worm"), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="session")
def larva(tmp_path_factory):
    out = tmp_path_factory.mktemp("larva") / "out"
    done = script("replay", BAGS / "larva", "--out", out)
    assert done.returncode == 0, done.stderr
    assert str(out / "report.html") in done.stdout.splitlines()[-1]
    return out


@pytest.fixture(scope="session")
def wormtracer(tmp_path_factory):
    out = tmp_path_factory.mktemp("wormtracer") / "out"
    args = ("--no-chamber", "--polarity", "bright")
    done = worm("replay", BAGS / "wormtracer", "--out", out, *args)
    assert done.returncode == 0, done.stderr
    return out


def columns(path):
    """Return a table's columns as arrays, without the lists."""
    table = pq.read_table(path)
    return {
        name: np.array(table[name].to_pylist())
        for name in table.schema.names
        if not name.startswith("midline")
    }


def test_nothing_impossible_is_told_of_the_examples(larva, wormtracer):
    for directory in (larva, wormtracer):
        summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
        assert impossible(summary) == []
        assert impossible_in_tracks(columns(directory / "tracks.parquet")) == []


def distance(table, truth, point, of=None):
    return np.hypot(
        table[f"{point}_u_px"] - truth[f"{of or point}_u_px"],
        table[f"{point}_v_px"] - truth[f"{of or point}_v_px"],
    )


def test_replay_writes_the_files_and_columns_of_the_contract(larva):
    (picture,) = larva.glob("report_frame_*.png")
    there = {item.name for item in larva.iterdir()}
    assert there == FILES | {"bag", "figures", picture.name}
    for name, table in [("tracks", tracks), ("contacts", contacts), ("passages", passages)]:
        assert pq.read_schema(larva / f"{name}.parquet").equals(table.SCHEMA)


def test_the_report_opens_with_a_frame_of_the_bag_in_which_the_worm_is_where_it_is(larva):
    """The picture is dark at the head that its row tells, and the body is as wide as told."""
    (picture,) = larva.glob("report_frame_*.png")
    table = columns(larva / "tracks.parquet")
    row = int(np.flatnonzero(table["frame"] == int(picture.stem.removeprefix("report_frame_")))[0])
    grey = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE)
    midline = pq.read_table(larva / "tracks.parquet", columns=["midline_u_px", "midline_v_px"])
    u, v = (np.array(midline.column(k)[row].as_py())[5:-5].round().astype(int) for k in (0, 1))
    assert np.mean(grey[v, u] < 100) > 0.95
    page = (larva / "report.html").read_text(encoding="utf-8")
    assert re.search(r'<figure id="([\w-]+)"', page)[1] == "fig-frame"
    assert f"Frame {row}, at" in page.replace("\xa0", " ").replace("\u2009", "")


def test_every_frame_of_the_bag_has_a_row(larva):
    truth = columns(BAGS / "larva_truth.parquet")
    tracks = columns(larva / "tracks.parquet")
    assert np.array_equal(tracks["frame"], np.arange(len(truth["frame"])))
    assert np.array_equal(tracks["stamp_ns"], truth["stamp_ns"])
    frames = json.loads((larva / "summary.json").read_text())["frames"]
    assert frames["read"] == len(truth["frame"])
    assert sum(count for name, count in frames.items() if name != "read") == frames["read"]


def test_head_centroid_and_tail_are_where_they_are(larva):
    tracks, truth = columns(larva / "tracks.parquet"), columns(BAGS / "larva_truth.parquet")
    assert np.nanmedian(distance(tracks, truth, "head")) <= 2.0
    assert np.nanmedian(distance(tracks, truth, "tail")) <= 2.0
    assert np.nanmedian(distance(tracks, truth, "centroid")) <= 1.0
    tracked = tracks["status"] == "tracked"
    right = distance(tracks, truth, "head") < distance(tracks, truth, "head", of="tail")
    assert right[tracked].mean() >= 0.95
    assert tracked.mean() >= 0.95


def test_the_chamber_is_found_below_a_pixel(larva):
    chamber = json.loads((larva / "summary.json").read_text())["geometry"]["chamber_a"]
    # As drawn: bags/README.md.
    assert chamber["centre_u_px"] == pytest.approx(507.37, abs=0.15)
    assert chamber["centre_v_px"] == pytest.approx(515.62, abs=0.15)
    assert chamber["radius_px"] == pytest.approx(400.0, rel=1e-3)
    assert chamber["exit_deg"] == pytest.approx(147.0, abs=0.3)
    assert chamber["exit_width_mm"] == pytest.approx(2.0, abs=0.05)


def test_evaluate_says_how_far_the_tracks_are_from_the_truth(larva):
    done = worm("evaluate", larva, BAGS / "larva_truth.parquet", "--json")
    assert done.returncode == 0, done.stderr
    figures = {name: item["value"] for name, item in json.loads(done.stdout)["figures"].items()}
    assert figures["head_error_median"] <= 0.3
    assert figures["head_error_95"] <= 1.8
    assert figures["tip_nearer_end_error_95"] <= 1.2
    assert figures["centroid_error_median"] <= 0.3
    assert figures["midline_rms_median"] <= 0.5
    assert figures["right_end_for_head"] >= 0.995
    assert figures["contact_agreement"] >= 0.97
    assert figures["where_agreement"] == 1.0
    assert figures["chamber_a_centre_error"] <= 0.15
    assert figures["chamber_a_radius_error"] <= 0.1
    assert figures["chamber_a_exit_error"] <= 0.3


def test_positions_and_body_angle_in_the_chamber_frame(larva):
    tracks, truth = columns(larva / "tracks.parquet"), columns(BAGS / "larva_truth.parquet")
    for name in ("head_x_mm", "head_y_mm", "r_h_mm"):
        assert np.nanmedian(np.abs(tracks[name] - truth[name])) < 0.05
    turn = np.exp(1j * (tracks["theta_h_rad"] - truth["theta_h_rad"]))
    far = truth["r_h_mm"] > 2.0  # near the centre the angle means little
    assert np.nanmedian(np.abs(np.angle(turn[far]))) < np.radians(1.0)
    # ψ_b from the truth's own head and centroid, by its definition.
    normal = truth["head_x_mm"] + 1j * truth["head_y_mm"]
    body = normal - (truth["centroid_x_mm"] + 1j * truth["centroid_y_mm"])
    psi_b = np.angle(body / normal)
    error = np.angle(np.exp(1j * (np.radians(tracks["psi_b_deg"]) - psi_b)))
    assert np.nanmedian(np.abs(error[far])) < np.radians(2.0)


def drawn_too(out):
    """Return the files of a result but for its bag, with its picture and figures."""
    return [
        *FILES,
        *(item.relative_to(out) for item in (*out.glob("report_frame_*"), *out.glob("figures/*"))),
    ]


def test_a_process_for_each_node_gives_the_same_bytes(larva, tmp_path):
    done = worm("replay", BAGS / "larva", "--out", tmp_path / "out", "--processes")
    assert done.returncode == 0, done.stderr
    for name in drawn_too(larva):
        assert (tmp_path / "out" / name).read_bytes() == (larva / name).read_bytes(), name


def test_the_same_bag_gives_the_same_bytes(tmp_path):
    for name, run in (("first", script), ("second", worm)):
        done = run("replay", BAGS / "larva", "--out", tmp_path / name, "--playback-duration", "8")
        assert done.returncode == 0, done.stderr
    for name in drawn_too(tmp_path / "first"):
        first, second = ((tmp_path / run / name).read_bytes() for run in ("first", "second"))
        assert first == second, name


def test_a_real_worm_has_a_midline_or_a_reason(wormtracer):
    table = pq.read_table(wormtracer / "tracks.parquet")
    points = np.array([len(line) for line in table["midline_u_px"].to_pylist()])
    statuses = np.array(table["status"].to_pylist())
    assert len(statuses) == 1500
    assert (points > 0).mean() >= 0.8
    assert not (statuses[points == 0] == "tracked").any()


def drawn_body(row, shape):
    """Fill the body that a row describes: discs along its midline."""
    mask = np.zeros(shape, np.uint8)
    line = zip(row["midline_u_px"], row["midline_v_px"], row["midline_width_px"], strict=True)
    points = np.array(list(line), dtype=np.float64)
    points = points[np.isfinite(points).all(axis=1)]  # a hidden end is not given
    dense = np.linspace(0, len(points) - 1, 6 * len(points))
    u, v, width = (np.interp(dense, np.arange(len(points)), column) for column in points.T)
    for centre_u, centre_v, across in zip(u, v, width, strict=True):
        centre = (round(centre_u * 16), round(centre_v * 16))
        cv2.circle(mask, centre, round(across / 2 * 16), 1, -1, cv2.LINE_8, 4)
    return mask > 0


def test_the_body_covers_the_hand_cleaned_masks(wormtracer):
    rows = pq.read_table(wormtracer / "tracks.parquet").to_pylist()
    overlaps = []
    with zipfile.ZipFile(BAGS / "wormtracer_masks.zip") as archive:
        names = sorted(name for name in archive.namelist() if name.endswith(".png"))
        assert len(names) == len(rows)
        for row, name in zip(rows[::10], names[::10], strict=True):
            if not np.isfinite(row["midline_u_px"] or np.nan).any():
                continue  # nothing of it is told
            coded = np.frombuffer(io.BytesIO(archive.read(name)).getvalue(), np.uint8)
            mask = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE) > 0
            _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
            worm_mask = labels == 1 + np.argmax(stats[1:, cv2.CC_STAT_AREA])
            body = drawn_body(row, mask.shape)
            overlaps.append((body & worm_mask).sum() / (body | worm_mask).sum())
    assert np.median(overlaps) >= 0.8


def test_without_a_chamber_pixels_are_there_and_the_rest_says_why(wormtracer):
    tracks = columns(wormtracer / "tracks.parquet")
    assert np.isfinite(tracks["head_u_px"][tracks["status"] == "tracked"]).all()
    assert np.isnan(tracks["head_x_mm"]).all()
    summary = json.loads((wormtracer / "summary.json").read_text())
    assert summary["geometry"] == {}
    assert summary["quantities"]["d_c"]["value"] is None
    assert "no chamber" in summary["quantities"]["d_c"]["why"]
