"""Frames of a fold that tell a loop otherwise from one to the next: neither way is told."""

from dataclasses import replace

import numpy as np
import pytest
from crossing_loop import CROSSING, LOOP, NODES, TOUCHING, folded, looped
from hypothesis import given
from hypothesis import strategies as st
from waiting_frames import SEEN, WIDTH

from worm_msgs_py import Status
from worm_tracker.midline.moved_aside import moved_aside_px
from worm_tracker.observation import Observation
from worm_tracker.propagation.contradictions import (
    ContradictionSettings,
    contradicted,
    in_doubt_where_contradicted,
)

SETTINGS = ContradictionSettings()


def told(*seen, frames_per_s=25.0, otherwise=None):
    stamps_ns = [round(1e9 * k / frames_per_s) for k in range(len(seen))]
    return in_doubt_where_contradicted(stamps_ns, seen, otherwise or {}, SETTINGS)


OPEN = folded(np.linspace([100, 150], [300, 150], NODES), status=Status.TRACKED, unresolved=None)
COIL = Observation(Status.COILED, 200.0, 200.0, unresolved=SEEN)


@given(st.lists(st.booleans(), min_size=2, max_size=9), st.data())
def test_a_loop_told_both_ways_is_in_doubt_in_all_frames_of_its_fold_whatever_their_order(
    crosses, data
):
    turned = data.draw(st.lists(st.booleans(), min_size=len(crosses), max_size=len(crosses)))
    seen = [
        each.reversed() if is_turned else each
        for each, is_turned in zip(
            (CROSSING if way else TOUCHING for way in crosses), turned, strict=True
        )
    ]
    given_back = told(*seen)
    if len(set(crosses)) == 1:
        assert given_back == seen
        return
    for before, after in zip(seen, given_back, strict=True):
        assert after.status is Status.LOOP_IN_DOUBT
        assert after.points == pytest.approx(before.points)
        assert after.unresolved is SEEN
        untold = np.flatnonzero(~after.told_points)
        assert 27 <= untold[0] <= 30  # from where it meets itself
        assert 70 <= untold[-1] <= 73
        assert after.told_points[[0, -1]].all()


def test_a_body_whose_ends_lie_side_by_side_is_not_told_otherwise_by_the_order_of_its_ends():
    """Each is nearer to where the other was, a frame later."""
    angle = np.linspace(0, 2 * np.pi, NODES)
    towards = 0.7 * WIDTH * np.maximum(1 - np.arange(NODES) / 6, 0)
    radius = (7 + np.linspace(0, 1, NODES)) * WIDTH
    before, after = (
        np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1) + 200
        for r in (radius, radius + towards - towards[::-1])
    )
    ends = after[[0, -1]] - before[[0, -1]], after[[-1, 0]] - before[[0, -1]]
    assert abs(ends[1]).sum() < abs(ends[0]).sum()
    for each in (folded(after), folded(after).reversed()):
        assert told(folded(before), each)[1] is each


def test_it_is_in_doubt_as_far_as_the_body_lies_folded():
    while_it_moves = [COIL] * 4
    ways = [CROSSING, COIL, TOUCHING]
    seen = [CROSSING, *while_it_moves, OPEN, *while_it_moves, *ways, *while_it_moves, OPEN]
    given_back = told(*seen)
    in_doubt = [k for k, each in enumerate(given_back) if not each.loops_known]
    assert in_doubt == [10, 12]
    assert all(
        each is before for each, before in zip(given_back, seen, strict=True) if each.loops_known
    )


def test_frames_far_apart_in_time_do_not_contradict_each_other():
    assert told(CROSSING, TOUCHING, frames_per_s=5.0) == [CROSSING, TOUCHING]
    assert told(CROSSING, *[COIL] * 5, TOUCHING)[0] is CROSSING


def test_stamps_that_do_not_increase_tell_no_time():
    seen = [CROSSING, TOUCHING]
    assert in_doubt_where_contradicted([40, 40], seen, {}, SETTINGS) == seen
    assert in_doubt_where_contradicted([40, 0], seen, {}, SETTINGS) == seen


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_frame_that_both_ways_tell_otherwise_puts_the_loop_in_doubt_in_all_of_the_fold(
    is_reversed,
):
    otherwise = TOUCHING.reversed() if is_reversed else TOUCHING
    given_back = told(CROSSING, CROSSING, CROSSING, otherwise={1: otherwise})
    assert [each.loops_known for each in given_back] == [False, False, False]
    assert all(each.points is CROSSING.points for each in given_back)
    assert told(CROSSING, CROSSING, otherwise={1: CROSSING}) == [CROSSING, CROSSING]


def test_a_frame_of_which_a_loop_in_doubt_leaves_nothing_is_followed_only():
    """Its ends meet, so that all of it is the loop."""
    angle = np.linspace(0, 2 * np.pi, NODES)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 5 * WIDTH + 200
    aside = 2 * WIDTH * np.sin(2 * angle)[:, np.newaxis]
    (after,) = told(folded(ring), otherwise={0: folded(ring + aside)})
    assert after.status is Status.COILED
    assert not after.has_midline
    assert after.followed.points is ring
    assert after.followed.in_doubt == (0, NODES)


def test_a_frame_that_both_ways_tell_otherwise_but_for_a_loop_is_not_told():
    """An end of it lies elsewhere, say."""
    elsewhere = CROSSING.points.copy()
    elsewhere[-9:] += np.linspace(0, 1.2 * WIDTH, 9)[:, np.newaxis]
    before, after = told(CROSSING, CROSSING, otherwise={1: folded(elsewhere)})
    assert before is CROSSING
    assert after.status is Status.COILED
    assert after.followed is CROSSING
    near = folded(CROSSING.points + 0.6 * WIDTH)
    assert told(CROSSING, otherwise={0: near}) == [CROSSING]


@pytest.mark.parametrize("px", [0.0, 0.9 * WIDTH, -0.9 * WIDTH])
def test_a_body_that_moves_is_told(px):
    moved = folded(looped(crosses=True, slid_px=px))
    assert told(CROSSING, moved) == [CROSSING, moved]


def test_the_slower_the_camera_the_farther_a_body_may_have_moved():
    moved = folded(looped(crosses=True, slid_px=1.8 * WIDTH))
    assert contradicted(CROSSING, moved, 0.04, SETTINGS) is not None
    assert contradicted(CROSSING, moved, 0.1, SETTINGS) is None


def test_a_bend_that_slides_along_the_body_tells_nothing_otherwise():
    """Its middle lies more than a width aside a frame later; it is no loop."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 5)
    bend = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.6 * WIDTH
    arm = np.stack([np.linspace(-9 * WIDTH, 0, 48), np.full(48, -0.6 * WIDTH)], axis=1)
    hairpin = np.concatenate([arm, bend, (arm * [1, -1])[::-1]]) + 200
    slid = hairpin + np.array([1.6 * WIDTH, 0])
    assert np.nanmax(moved_aside_px(slid, hairpin, SETTINGS.most_along_widths * WIDTH)) > WIDTH
    assert told(folded(hairpin), folded(slid))[0].loops_known


def test_what_is_in_doubt_already_contradicts_nothing_and_stays_in_doubt():
    doubted = replace(TOUCHING, status=Status.LOOP_IN_DOUBT, in_doubt=(LOOP.start, LOOP.stop))
    assert told(CROSSING, doubted) == [CROSSING, doubted]
    first, _, third = told(CROSSING, TOUCHING, doubted)
    assert not first.loops_known
    assert third.in_doubt[0] <= LOOP.start < LOOP.stop <= third.in_doubt[1]


def test_a_body_of_which_hardly_anything_is_left_is_not_told_but_followed():
    hidden = replace(TOUCHING, status=Status.END_HIDDEN, occluded=(25, 30))
    *_, after = told(CROSSING, TOUCHING, hidden)
    assert after.status is Status.COILED
    assert after.unresolved is SEEN
    assert after.followed is not None
    assert not after.has_midline
