"""The scores of the fold benchmark: what is right, what is wrong and certain."""

from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.folds import figures, score
from benchmarks.midline_distance import frechet_px
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import BodyState, Keypoint, Midline, Status, TrackedFrame

WIDTH = 20.0
LINE = np.c_[np.linspace(100.0, 500.0, 241), np.full(241, 300.0)]


def film(frames=4, folded=()):
    return SimpleNamespace(
        worm="4001",
        look="darker",
        radius_mm=10.0,
        exit_width_mm=2.0,
        width_px=WIDTH,
        midline_px=np.tile(LINE, (frames, 1, 1)),
        half_width_px=np.full((frames, 241), WIDTH / 2),
        centroid_px=np.full((frames, 2), 300.0),
        folded=np.isin(np.arange(frames), folded),
        contact=np.zeros(frames, bool),
    )


def tracked(
    line, status=Status.TRACKED, certainty=0.99, r_m=0.005, length_px=np.nan, head_sd_m=0.0
):
    state = BodyState(
        frame=0,
        stamp_ns=0,
        status=status,
        head_certainty=certainty,
        head=Keypoint(*line[0], -r_m, 0.0),
        centroid=Keypoint(300.0, 300.0),
        width_m=5e-4,
        length_px=length_px,
        head_sd_m=head_sd_m,
    )
    nothing = np.full(len(line), np.nan)
    return TrackedFrame(state, Midline(*line.T, nothing, nothing, nothing, nothing))


def figures_of(*frames):
    told = film(len(frames), folded=range(len(frames)))
    return figures(
        told, [score(each, told, k) for k, each in enumerate(frames)], [1.0] * len(frames)
    )


def test_the_truth_itself_is_right():
    found = figures_of(*[tracked(LINE[::6])] * 4)
    assert found["folded_right"] == found["folded_right_by_arc"] == 100
    assert found["unmarked"] == found["off_worm"] == found["swapped_certain"] == 0


def test_head_and_tail_exchanged_are_an_unmarked_error_where_certain_only():
    sure, unsure = tracked(LINE[::-6]), tracked(LINE[::-6], certainty=0.6)
    found = figures_of(sure, unsure, sure, unsure)
    assert found["folded_right"] == 0
    assert found["folded_unmarked"] == 50
    assert found["unmarked_frames"] == [0, 2]
    assert found["swapped_certain"] == 2


def test_a_midline_out_in_the_water_is_wrong_though_its_head_is_right():
    slack = LINE.copy()
    slack[100:140, 1] += 25.0 * np.sin(np.linspace(0, np.pi, 40))
    found = figures_of(*[tracked(slack)] * 4)
    assert found["folded_unmarked"] == 100
    assert found["off_worm"] == 4


def test_a_length_is_right_within_two_percent_of_the_true_one_and_counted_where_it_is_told():
    near, far, none = (tracked(LINE, length_px=length) for length in (407.0, 409.0, np.nan))
    refused = tracked(LINE * np.nan, Status.COILED, 0.5, length_px=400.0)
    found = figures_of(near, far, none, refused)
    assert found["length_right_folded"] == 50
    assert found["length_right_open"] is None


def test_contact_is_not_told_of_a_head_that_is_not_placed_well_be_it_near_the_wall_or_far():
    surely, maybe, far = (
        tracked(LINE, r_m=r_m, head_sd_m=sd_m)
        for r_m, sd_m in ((0.0099, 5e-5), (0.0099, 1e-4), (0.009, 1e-4))
    )
    found = figures_of(surely, maybe, far, far)
    assert found["contact_told"] == 25
    assert found["contact_right"] == 0, "the film has no contact"


def test_a_midline_that_stops_short_is_wrong_and_a_frame_without_pose_is_no_error():
    short, none = tracked(LINE[:200]), tracked(LINE * np.nan, Status.COILED, 0.5)
    found = figures_of(short, none, none, none)
    assert found["folded_right"] == 0
    assert found["unmarked_frames"] == [0]
    assert found["statuses"] == {"tracked": 1, "coiled": 3}


def test_a_head_without_a_pose_counts_where_it_is_told_for_certain():
    near = LINE[:150]
    far = near + np.array([0.0, 30.0])
    found = figures_of(tracked(near, Status.END_HIDDEN), tracked(far, Status.END_HIDDEN))
    assert found["folded_right"] == 0
    assert found["unmarked_frames"] == [1]


def film_of(line):
    """Return a film of one folded frame in which the body lies along a line."""
    half = np.full((1, len(line)), WIDTH / 2)
    there = vars(film(1, folded=[0]))
    return SimpleNamespace(**{**there, "midline_px": line[np.newaxis], "half_width_px": half})


def in_doubt_between(line, first, behind):
    told = line.copy()
    told[first:behind] = np.nan
    return tracked(told, Status.LOOP_IN_DOUBT)


def beside_itself():
    """Return a body three strands of which lie half a width beside each other."""
    leg, turn = np.linspace(0.0, 160.0, 81), np.linspace(0.0, np.pi, 9)[1:-1]
    there = np.c_[100 + leg, np.full(81, 300.0)]
    bend = np.c_[260 + 5 * np.sin(turn), 305 - 5 * np.cos(turn)]
    back = np.c_[260 - leg, np.full(81, 310.0)]
    other = np.c_[100 - 5 * np.sin(turn), 315 - 5 * np.cos(turn)]
    again = np.c_[100 + leg, np.full(81, 320.0)]
    return np.concatenate([there, bend, back, other, again])


def figures_of_parts(line, told):
    there = film_of(line)
    return figures(there, [score(told, there, 0)], [1.0])


@pytest.mark.parametrize("aside_px", [0.0, 7.0])
def test_parts_beside_a_loop_in_doubt_are_right_though_other_strands_lie_nearer(aside_px):
    """Seven pixels aside a strand lies nearer to the one beside it than to its own."""
    line = beside_itself()[::2]
    told = in_doubt_between(line + np.array([0.0, aside_px]), 36, 60)
    assert figures_of_parts(beside_itself(), told)["unmarked_frames"] == []


@pytest.mark.parametrize("stretch", [slice(0, 40), slice(80, 120)])
def test_a_part_that_lies_elsewhere_is_an_unmarked_error(stretch):
    line = beside_itself()[::2]
    line[stretch, 1] += 1.5 * WIDTH
    told = in_doubt_between(line, 52, 70)
    assert figures_of_parts(beside_itself(), told)["unmarked_frames"] == [0]


def test_a_head_in_the_wall_is_counted():
    found = figures_of(tracked(LINE, r_m=0.01005), tracked(LINE, r_m=0.01015))
    assert found["in_wall"] == 1


def test_reliability_sums_up_what_was_told_and_what_came_true():
    frames = [tracked(LINE, certainty=0.97), tracked(LINE[::-1], certainty=0.97)]
    bins = figures_of(*frames)["reliability"]
    assert bins[6] == pytest.approx([2, 1.94, 1])
    assert sum(each[0] for each in bins) == 2


@given(st.integers(2, 9), st.integers(0, 2**32 - 1))
def test_frechet_is_the_shortest_lead_between_two_who_walk_the_lines(n, seed):
    one, other = np.random.default_rng(seed).normal(size=(2, n, 2))

    def lead(i, j):
        here = np.hypot(*(one[i] - other[j]))
        if i == j == 0:
            return here
        ways = [(i - 1, j), (i, j - 1), (i - 1, j - 1)]
        return max(here, min(lead(*way) for way in ways if min(way) >= 0))

    if n <= 6:
        assert frechet_px(one, other) == pytest.approx(lead(n - 1, n - 1))
    assert frechet_px(one, one) == 0
    assert frechet_px(one, other) == pytest.approx(frechet_px(other, one))
