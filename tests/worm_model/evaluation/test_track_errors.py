"""The figures of an evaluation are those of hand-made tables whose errors are known."""

import json
from copy import deepcopy

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from worm_model.evaluation import (
    ChamberCircle,
    evaluate_tracks,
    frame_table_of,
    read_tracks,
    read_truth,
)
from worm_model.evaluation.track_errors import matches, runs
from worm_msgs_py.errors import EvaluationError

FRAMES, STEP_NS = 200, 100_000_000
"""20 s at 10 frames a second."""
LENGTH = 100.0


def straight_worm():
    """Columns of a worm that lies along u and moves along v, a pixel a frame."""
    k = np.arange(FRAMES)
    s = np.linspace(0.0, LENGTH, 30)
    return {
        "stamp_ns": (1000 + k * STEP_NS).tolist(),
        "frame": k.tolist(),
        "status": ["tracked"] * FRAMES,
        "where": ["chamber_a"] * FRAMES,
        "chamber": ["chamber_a"] * FRAMES,
        "head_certainty": [1.0] * FRAMES,
        "head_u_px": [300.0] * FRAMES,
        "head_v_px": (50.0 + k).tolist(),
        "centroid_u_px": [350.0] * FRAMES,
        "centroid_v_px": (50.0 + k).tolist(),
        "tail_u_px": [400.0] * FRAMES,
        "tail_v_px": (50.0 + k).tolist(),
        "midline_u_px": [(300.0 + s).tolist()] * FRAMES,
        "midline_v_px": [[50.0 + f] * 30 for f in k.tolist()],
        "r_h_mm": [9.0] * FRAMES,
        "contact": [bool(f // 10 % 2) for f in k.tolist()],
        "circle_u_px": [500.0] * FRAMES,
        "circle_v_px": [510.0] * FRAMES,
        "circle_radius_px": [400.0] * FRAMES,
        "exit_deg": [179.0] * FRAMES,
    }


def compared(change=lambda columns: None, truth=None, circles=None, **options):
    columns = straight_worm()
    change(columns)
    tracks = frame_table_of("tracks", columns, circles)
    return evaluate_tracks(tracks, frame_table_of("truth", truth or straight_worm()), **options)


def value(result, name):
    return result[name].value


def shift(columns, name, by):
    columns[name] = [x + by for x in columns[name]]


def swap(columns, rows):
    for axis in "uv":
        head, tail = columns[f"head_{axis}_px"], columns[f"tail_{axis}_px"]
        midline = columns[f"midline_{axis}_px"] = list(columns[f"midline_{axis}_px"])
        for k in rows:
            head[k], tail[k] = tail[k], head[k]
            midline[k] = midline[k][::-1]


def test_the_truth_itself_has_no_error():
    result = compared()
    for figure in result.figures:
        perfect = 0.0 if "error" in figure.name or "rms" in figure.name else 1.0
        assert figure.value == pytest.approx(perfect, abs=1e-9), figure
        assert figure.n > 0
    assert result.joined_by == "stamp_ns"
    assert result.frames_in_common == FRAMES


def test_errors_are_distances():
    def change(columns):
        shift(columns, "head_u_px", 3.0)
        shift(columns, "head_v_px", 4.0)
        shift(columns, "tail_v_px", -2.0)
        shift(columns, "centroid_u_px", 0.25)
        shift(columns, "r_h_mm", -0.5)

    result = compared(change)
    assert value(result, "head_error_median") == pytest.approx(5.0)
    assert value(result, "head_error_95") == pytest.approx(5.0)
    assert value(result, "tail_error_median") == pytest.approx(2.0)
    assert value(result, "tip_nearer_end_error_median") == pytest.approx(3.5)
    assert value(result, "centroid_error_95") == pytest.approx(0.25)
    assert value(result, "r_h_error_median") == pytest.approx(0.5)
    assert result["head_error_median"].n == FRAMES
    assert value(result, "right_end_for_head") == 1.0


def test_the_95th_percentile_sees_the_worst_frames_and_the_median_does_not():
    def change(columns):
        for k in range(20):
            columns["head_u_px"][k] += 40.0

    result = compared(change)
    assert value(result, "head_error_median") == 0.0
    assert value(result, "head_error_95") == pytest.approx(40.0)


@pytest.mark.parametrize(("across", "along"), [(1.5, 0.0), (0.0, 10.0)])
def test_midline_rms_counts_both_ways_and_shape_only_what_is_across(across, along):
    def change(columns):
        for axis, by in (("u", along), ("v", across)):
            columns[f"midline_{axis}_px"] = [
                [x + by for x in row] for row in columns[f"midline_{axis}_px"]
            ]

    result = compared(change)
    assert value(result, "midline_rms_median") == pytest.approx(np.hypot(across, along))
    shape = value(result, "midline_shape_rms_median")
    # Along: only the ends that stick out are away from the other curve; ∫x² over 10 px of 100 px.
    assert shape == pytest.approx(across if across else np.sqrt(10.0**3 / 3 / LENGTH), rel=0.05)


def test_a_midline_of_few_points_on_an_arc_is_as_good_as_one_of_many():
    truth, few = straight_worm(), straight_worm()
    for columns, count in ((truth, 400), (few, 14)):
        phi = np.linspace(0.0, 2.0, count)
        columns["midline_u_px"] = [(60.0 * np.cos(phi)).tolist()] * FRAMES
        columns["midline_v_px"] = [(60.0 * np.sin(phi)).tolist()] * FRAMES
    result = evaluate_tracks(frame_table_of("few", few), frame_table_of("truth", truth))
    assert value(result, "midline_rms_median") < 0.02


def test_exchanged_ends_are_counted_after_five_seconds_and_free_figures_do_not_mind():
    result = compared(lambda columns: swap(columns, range(20, 80)))
    assert result["right_end_for_head"].n == FRAMES - 50
    assert value(result, "right_end_for_head") == pytest.approx(1.0 - 30 / 150)
    assert value(result, "tip_nearer_end_error_95") == 0.0
    assert value(result, "midline_shape_rms_95") == pytest.approx(0.0, abs=1e-9)
    assert value(result, "head_error_95") == pytest.approx(LENGTH)
    uniform = np.sqrt(LENGTH**2 / 3.0)  # rms of 2x − L over 0…L
    assert value(result, "midline_rms_95") == pytest.approx(uniform, rel=0.01)


def test_exchanges_that_are_flagged_uncertain_are_told_apart():
    def change(columns):
        swap(columns, range(100, 130))
        columns["head_certainty"][100:130] = [0.8] * 30

    result = compared(change)
    assert value(result, "right_end_for_head") == pytest.approx(0.8)
    assert value(result, "right_end_where_certain") == 1.0
    assert value(result, "certain_of_the_head") == pytest.approx(0.8)
    assert value(compared(change, certain=0.7), "right_end_where_certain") == pytest.approx(0.8)


def test_missing_frames_and_disowned_ones_are_not_tracked():
    def change(columns):
        for name in columns:
            columns[name] = columns[name][50:]
        columns["status"][:10] = ["coiled"] * 10
        for k in range(10):
            columns["head_u_px"][k] = 1e6

    result = compared(change)
    assert value(result, "tracked") == pytest.approx(140 / 200)
    assert value(result, "head_error_95") == 0.0
    assert result["head_error_95"].n == 140


def test_contact_that_is_not_told_is_not_right():
    def change(columns):
        columns["contact"][:20] = [None] * 20
        columns["contact"][20:30] = [True] * 10

    truth = straight_worm()
    truth["contact"][190:] = [None] * 10
    result = compared(change, truth)
    assert value(result, "contact_agreement") == pytest.approx(160 / 190)
    assert result["contact_agreement"].n == 190
    assert value(result, "contact_told") == pytest.approx(170 / 190)
    assert value(result, "contact_agreement_where_told") == pytest.approx(160 / 170)


def test_episodes_that_were_missed_invented_or_split_lower_recall_and_precision():
    def change(columns):
        columns["contact"][10:20] = [False] * 10  # missed
        columns["contact"][24:26] = [True] * 2  # invented
        columns["contact"][33:36] = [False] * 3  # split
        columns["contact"][52:58] = [False] * 6  # split

    result = compared(change)
    assert (result["contact_episode_recall"].n, result["contact_episode_precision"].n) == (10, 12)
    assert value(result, "contact_episode_recall") == pytest.approx(9 / 10)
    assert value(result, "contact_episode_precision") == pytest.approx(9 / 12)
    assert value(result, "contact_episode_f1") == pytest.approx(2 * 9 / 22)


def test_a_gap_of_half_a_second_splits_no_episode_and_a_longer_one_does():
    def change(columns):
        columns["contact"][12:17] = [None] * 5
        columns["contact"][31:37] = [None] * 6

    result = compared(change)
    assert result["contact_episode_precision"].n == 11
    assert value(result, "contact_episode_recall") == 1.0
    assert value(result, "contact_agreement") == pytest.approx(189 / 200)


def test_where_that_is_wrong_or_unknown_is_not_right():
    def change(columns):
        columns["where"][:30] = ["unknown"] * 30
        columns["where"][30:40] = ["passage"] * 10

    assert value(compared(change), "where_agreement") == pytest.approx(0.8)


def test_circles_are_compared_by_name_and_exits_on_the_round():
    found = {"chamber_a": ChamberCircle(500.3, 509.6, 402.0, -179.5)}
    result = compared(circles=found)
    assert value(result, "chamber_a_centre_error") == pytest.approx(0.5)
    assert value(result, "chamber_a_radius_error") == pytest.approx(0.5)
    assert value(result, "chamber_a_exit_error") == pytest.approx(1.5)
    assert "no such chamber" in compared(circles={})["chamber_a_centre_error"].why


def test_too_little_is_said_to_be_too_little():
    truth = {name: values[:8] for name, values in straight_worm().items()}
    result = compared(truth=truth)
    for name in ("head_error_95", "tracked", "right_end_for_head", "contact_episode_f1"):
        assert result[name].value is None
        assert "not enough data" in result[name].why


def test_columns_that_are_not_there_are_named_and_the_rest_is_still_compared():
    optional = (
        "midline_u_px",
        "contact",
        "where",
        "head_certainty",
        "r_h_mm",
        "circle_u_px",
        "stamp_ns",
    )

    def change(columns):
        for name in optional:
            del columns[name]

    truth = straight_worm()
    change(truth)
    result = compared(change, truth)
    assert result.joined_by == "frame"
    missing = {figure.name for figure in result.figures if figure.value is None}
    assert {figure.name for figure in result.figures} - missing == {
        f"{name}_{part}"
        for name in ("head_error", "tail_error", "tip_nearer_end_error", "centroid_error")
        for part in ("median", "95")
    } | {"tracked"}
    assert json.loads(json.dumps(result.document(), allow_nan=False))


def test_frames_join_where_stamps_have_another_origin():
    result = compared(lambda columns: shift(columns, "stamp_ns", 7))
    assert result.joined_by == "frame"
    assert value(result, "head_error_95") == 0.0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        pytest.param(lambda c: c.pop("tail_v_px"), "no column tail_v_px", id="a point"),
        pytest.param(lambda c: (c.pop("stamp_ns"), c.pop("frame")), "stamp_ns", id="no key"),
        pytest.param(
            lambda c: (shift(c, "stamp_ns", 7), shift(c, "frame", 900)),
            "no frame in common",
            id="another trial",
        ),
        pytest.param(
            lambda c: c["stamp_ns"].__setitem__(1, c["stamp_ns"][0]), "two rows", id="twice"
        ),
        pytest.param(lambda c: c["frame"].__setitem__(3, None), "empty rows", id="empty key"),
    ],
)
def test_tables_that_cannot_be_compared_are_refused_in_one_line(change, says):
    with pytest.raises(EvaluationError, match=says) as refusal:
        compared(change)
    assert "\n" not in str(refusal.value)


def test_tables_and_summary_are_read_from_files(tmp_path):
    columns = straight_worm()
    truth = tmp_path / "truth.parquet"
    pq.write_table(pa.table(columns), truth)
    results = tmp_path / "out"
    results.mkdir()
    own = {name: columns[name] for name in columns if not name.startswith(("circle", "exit"))}
    pq.write_table(pa.table(own), results / "tracks.parquet")
    circle = {"centre_u_px": 500.0, "centre_v_px": 510.0, "radius_px": 400.4, "exit_deg": None}
    summary = {"geometry": {"chamber_a": circle}}
    (results / "summary.json").write_text(json.dumps(summary))
    for path in (results, results / "tracks.parquet"):
        result = evaluate_tracks(read_tracks(path), read_truth(truth))
        assert value(result, "head_error_95") == 0.0
        assert value(result, "chamber_a_radius_error") == pytest.approx(0.1)
        assert result["chamber_a_exit_error"].value is None
    (results / "summary.json").write_text("[1")
    with pytest.raises(EvaluationError, match=r"summary\.json"):
        read_tracks(results)
    (tmp_path / "text.parquet").write_text("not a table")
    for wrong in ("text.parquet", "none.parquet", "out"):
        with pytest.raises(EvaluationError, match=wrong):
            read_truth(tmp_path / wrong)


masks = st.lists(st.booleans(), max_size=60).map(lambda bits: np.array(bits, dtype=bool))


@given(masks)
def test_runs_tile_what_is_on(on):
    again = np.zeros_like(on)
    for first, last in runs(on):
        assert not again[max(first - 1, 0) : last + 1].any()  # runs do not touch
        again[first : last + 1] = True
    np.testing.assert_array_equal(again, on)


@given(masks, st.randoms(use_true_random=False))
def test_matches_are_one_to_one_symmetric_and_full_for_the_same(on, random):
    other = on.copy()
    for k in range(len(on)):
        other[k] ^= random.random() < 0.2
    one, two = runs(on), runs(other)
    assert matches(one, one) == len(one)
    assert matches(one, two) == matches(two, one) <= min(len(one), len(two))


@settings(max_examples=15, deadline=None)
@given(
    du=st.floats(-40, 40),
    dv=st.floats(-40, 40),
    rows=st.sets(st.integers(0, FRAMES - 1), max_size=FRAMES),
)
def test_a_shift_is_the_error_of_every_point_whatever_the_ends_are_called(du, dv, rows):
    assume(np.hypot(du, dv) < LENGTH / 3)

    def change(columns):
        for point in ("head", "tail", "centroid"):
            shift(columns, f"{point}_u_px", du)
            shift(columns, f"{point}_v_px", dv)
        swap(columns, rows)

    result = compared(change)
    apart = pytest.approx(np.hypot(du, dv), abs=1e-9)
    assert value(result, "tip_nearer_end_error_median") == apart
    assert value(result, "tip_nearer_end_error_95") == apart
    assert value(result, "centroid_error_median") == apart
    late = sum(k >= 50 for k in rows)
    assert value(result, "right_end_for_head") == pytest.approx(1 - late / 150)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 1000))
def test_the_order_of_rows_does_not_matter(seed):
    columns = straight_worm()
    order = np.random.default_rng(seed).permutation(FRAMES)
    mixed = {name: [deepcopy(values[k]) for k in order] for name, values in columns.items()}
    straight = compared().document()
    tracks, truth = frame_table_of("tracks", mixed), frame_table_of("truth", columns)
    assert evaluate_tracks(tracks, truth).document() == straight
    assert evaluate_tracks(truth, tracks).document() == straight
