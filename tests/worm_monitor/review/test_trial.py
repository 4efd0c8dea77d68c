"""What is shown of a trial is what its tables say, and what is shown exchanged is the other end."""

import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from report_trial import CHAMBER, record, states, without_chamber
from reviewed_trials import FRAMES, change_summary, small_trial

from worm_monitor.review.trial import plotted_columns, read_reviewed_trial
from worm_msgs_py.errors import ReportError


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return small_trial(tmp_path_factory.mktemp("reviewed") / "out")


@pytest.fixture(scope="module")
def trial(results):
    return read_reviewed_trial(results)


def test_a_pose_is_that_of_the_tables_row(trial, results):
    table = pq.read_table(results / "tracks.parquet")
    for row in (0, 7, FRAMES - 1):
        pose = trial.pose(row)
        for name in ("head", "centroid", "tail"):
            told = [table[f"{name}_{axis}_px"][row].as_py() for axis in "uv"]
            assert pose[name] == pytest.approx(told, rel=1e-4)
        for axis, line in zip("uv", pose["midline"], strict=True):
            assert line == pytest.approx(table[f"midline_{axis}_px"][row].as_py(), rel=1e-4)
        assert pose["frame"] == row
        assert pose["sure"]


def test_a_frame_without_a_worm_has_no_points_and_says_why(trial):
    row = 392
    assert trial.status(row).label == "no_worm"
    assert trial.pose(row)["head"] == [None, None]
    assert trial.pose(row)["midline"] == [[], []]


def test_columns_are_those_of_the_tables_and_exchanged_twice_the_same(trial, tmp_path):
    """A trial whose tracker told the other end has the columns that are shown as exchanged."""
    seen = plotted_columns(trial)
    turned = [
        (replace(state, head=state.tail, tail=state.head), midline)
        for state, midline in states(FRAMES / 12.0, 12.0)
    ]
    other = plotted_columns(read_reviewed_trial(record(tmp_path / "turned", turned)))
    for name in ("r", "theta", "psi"):
        assert np.isfinite(seen[name]).sum() > 400
        for one, its in ((name, f"{name}_exchanged"), (f"{name}_exchanged", name)):
            apart = np.abs(seen[one] - other[its])
            apart = np.minimum(apart, 360.0 - apart) if name != "r" else apart
            assert np.nanmax(apart) < 1e-3, one
            assert (np.isfinite(seen[one]) == np.isfinite(other[its])).all()
    assert (seen["frame"] == np.arange(FRAMES)).all()
    assert seen["t"][12] == pytest.approx(1.0)


def test_all_fits_into_the_blank_ground(trial):
    width, height = trial.size_px
    assert width > CHAMBER.centre_u_px + CHAMBER.radius_px
    assert height > CHAMBER.centre_v_px + CHAMBER.radius_px


def test_a_frame_before_a_bump_is_drawn_with_the_rig_of_its_own(tmp_path):
    """The summary tells the last rig; the frames rest on the one before it."""
    results = small_trial(tmp_path / "out")

    def bump(summary):
        old = {"version": 1, "stamp_ns": 0} | json.loads(json.dumps(summary["geometry"]))
        summary["earlier_geometries"] = [old]
        summary["geometry"]["chamber_a"]["centre_u_px"] += 30.0

    change_summary(results, bump)
    trial = read_reviewed_trial(results)
    assert [rig[0].centre_u_px for rig in trial.rigs] == [537.4, 507.4]
    assert (trial.rig_of == 1).all()  # those without a pose too


def test_a_trial_without_a_chamber_is_shown_without_a_rig(tmp_path):
    bare = record(tmp_path / "out", without_chamber(states(10.0)), chamber=False)
    trial = read_reviewed_trial(bare)
    assert (trial.rig_of == -1).all()
    assert np.isnan(plotted_columns(trial)["r"]).all()
    assert trial.pose(3)["head"][0] > 0


def test_what_is_no_result_is_refused_in_a_line(tmp_path):
    with pytest.raises(ReportError, match="no such results directory"):
        read_reviewed_trial(tmp_path / "none")
    results = small_trial(tmp_path / "out")
    (results / "tracks.parquet").write_bytes(b"PAR1")
    with pytest.raises(ReportError, match=r"tracks\.parquet"):
        read_reviewed_trial(results)
