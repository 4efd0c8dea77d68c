"""Every doubtful frame is in a stretch, no stretch begins or ends with one that is not."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.results.doubtful_stretches import Doubt, doubtful_stretches
from worm_msgs_py import Status
from worm_msgs_py.units import NS_PER_S

FRAME_NS = NS_PER_S // 10
BODY_PX = 100.0


def crawling(frames, step_px=3.0):
    """Return the tracks of a worm that crawls straight ahead, its head surely known."""
    u = step_px * np.arange(frames)
    return {
        "frame": np.arange(frames),
        "stamp_ns": FRAME_NS * np.arange(frames, dtype=np.int64),
        "status": np.full(frames, "tracked", object),
        "head_certainty": np.full(frames, 0.99),
        "head_u_px": u + BODY_PX,
        "head_v_px": np.zeros(frames),
        "tail_u_px": u,
        "tail_v_px": np.zeros(frames),
    }


def without_pose(tracks, rows, status):
    tracks["status"][rows] = status
    tracks["head_certainty"][rows] = 0.5
    for name in ("head_u_px", "head_v_px", "tail_u_px", "tail_v_px"):
        tracks[name][rows] = np.nan


def exchanged(tracks, rows):
    head = tracks["head_u_px"][rows].copy()
    tracks["head_u_px"][rows], tracks["tail_u_px"][rows] = tracks["tail_u_px"][rows], head


def frames_of(stretches, why):
    return [(each.first_frame, each.last_frame) for each in stretches if each.why is why]


@pytest.mark.parametrize("frames", [0, 1, 30])
def test_a_worm_that_is_surely_known_leaves_nothing_to_look_at(frames):
    assert doubtful_stretches(crawling(frames)) == []


@given(st.lists(st.sampled_from([s.label for s in Status]), min_size=1, max_size=60), st.data())
def test_every_doubtful_frame_is_in_one_stretch_of_its_kind(statuses, data):
    tracks = crawling(len(statuses))
    sure = data.draw(st.lists(st.booleans(), min_size=len(statuses), max_size=len(statuses)))
    doubtful = {why: set() for why in (Doubt.UNSURE_HEAD, Doubt.FOLDED, Doubt.LOST)}
    for row, label in enumerate(statuses):
        status = Status.from_label(label)
        tracks["status"][row] = label
        tracks["head_certainty"][row] = 0.99 if sure[row] else 0.89
        if status in (Status.FOLDED, Status.LOOP_IN_DOUBT, Status.COILED):
            doubtful[Doubt.FOLDED].add(row)
        elif not status.may_have_head:
            doubtful[Doubt.LOST].add(row)
        if status.may_have_head and not sure[row]:
            doubtful[Doubt.UNSURE_HEAD].add(row)
    found = doubtful_stretches(tracks)
    for why, rows in doubtful.items():
        told = sorted(frames_of(found, why))
        held = [set(range(first, last + 1)) for first, last in told]
        assert all(sum(row in each for each in held) == 1 for row in rows)
        assert all({first, last} <= rows for first, last in told)
        ends = [b[0] - a[1] for a, b in pairwise(told)]
        assert all(FRAME_NS * apart > NS_PER_S for apart in ends)


def test_an_exchange_of_head_and_tail_is_found_at_both_of_its_ends():
    tracks = crawling(50)
    exchanged(tracks, slice(20, 33))
    found = doubtful_stretches(tracks)
    assert frames_of(found, Doubt.EXCHANGED) == [(19, 20), (32, 33)]
    assert [each.why for each in found] == [Doubt.EXCHANGED] * 2


@pytest.mark.parametrize(("gap", "expected"), [(5, [(19, 25)]), (11, [])])
def test_an_exchange_is_told_over_a_short_gap_and_not_over_one_in_which_it_may_turn(gap, expected):
    tracks = crawling(50)
    without_pose(tracks, slice(20, 20 + gap), "no_worm")
    exchanged(tracks, slice(20 + gap, None))
    found = doubtful_stretches(tracks)
    assert frames_of(found, Doubt.EXCHANGED) == expected
    assert frames_of(found, Doubt.LOST) == [(20, 19 + gap)]


def test_the_worst_comes_first_and_says_how_sure():
    tracks = crawling(100)
    without_pose(tracks, slice(60, 65), "no_worm")
    tracks["head_certainty"][10:30] = np.linspace(0.55, 0.8, 20)
    exchanged(tracks, slice(95, None))
    exchange, unsure, lost = doubtful_stretches(tracks)
    assert (exchange.why, exchange.first_frame) == (Doubt.EXCHANGED, 94)
    assert (unsure.first_frame, unsure.last_frame) == (10, 29)
    assert unsure.least_certainty == 0.55
    assert unsure.duration_s == pytest.approx(1.9)
    assert lost.first_stamp_ns == 60 * FRAME_NS
    assert np.isnan(lost.least_certainty)
