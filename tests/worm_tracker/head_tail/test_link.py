"""Which end is which goes over from one midline to the next, however near to itself a body lies."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_tracker.frame_queue import FrameQueue
from worm_tracker.frame_state import PendingFrame
from worm_tracker.head_tail.identity import HeadTail, HeadTailSettings
from worm_tracker.head_tail.link import Chain, LinkSettings
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.worm_track import WormTrack

LENGTH, WIDTH, POINTS = 200.0, 10.0, 65


def hairpin(arm, apart=5.0):
    """Return a body on its way through a U-turn, whose first end is as far beyond the bend."""
    beyond = arm - np.linspace(0.0, LENGTH, POINTS)
    return np.stack([-np.abs(beyond), np.where(beyond > 0, 0.0, apart)], axis=1)


def folded(points, *, path_number=0, turned_round=False, over_limits=0.0):
    return Observation(
        Status.FOLDED,
        points=points,
        widths=np.full(POINTS, WIDTH),
        confidence=1.0,
        width=WIDTH,
        end_sd_px=(0.1, 0.1),
        over_limits=over_limits,
        path_number=path_number,
        turned_round=turned_round,
    )


EVEN = 0.5 * LENGTH
"""A hairpin whose arms are as long as this is nearly the same from either end."""


def test_the_place_of_a_hairpin_with_even_arms_does_not_tell_its_ends():
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN)))
    assert chain.push(folded(hairpin(EVEN + 4.0))).reliability < 0.9


@given(
    arms=st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=30),
    path_number=st.sampled_from([1, -1]),
)
def test_a_body_that_is_slid_along_itself_keeps_its_ends_there_and_back(arms, path_number):
    chain = Chain(WormTrack(), LinkSettings())
    for off in arms:
        points = hairpin(EVEN + off)
        link = chain.push(folded(points, path_number=path_number))
        assert np.array_equal(link.observation.points, points)
        assert link.reliability > 0.999


@pytest.mark.parametrize(
    ("arm", "sd_px", "is_sure"),
    [
        pytest.param(EVEN, 8.0, False, id="on each other, and one is not seen"),
        pytest.param(EVEN, 0.5, True, id="on each other, and both are seen"),
        pytest.param(EVEN + 20.0, 8.0, True, id="far from each other"),
    ],
)
def test_ends_that_lie_on_each_other_unseen_may_change_places(arm, sd_px, is_sure):
    """The one that comes out next may be either, however smoothly a body is slid on with it."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(arm), path_number=1))
    later = folded(hairpin(arm + 1.0), path_number=1)
    hidden = (sd_px > 0.4 * WIDTH) * 3
    link = chain.push(replace(later, seen_end_sd_px=(sd_px, 0.5), occluded=(hidden, 0)))
    assert (link.reliability > 0.99) == is_sure
    assert is_sure or link.reliability < 0.7


@pytest.mark.parametrize(
    ("path_number", "gone"),
    [pytest.param(2, 0, id="another path"), pytest.param(1, 1, id="a frame without a midline")],
)
def test_a_path_that_was_left_tells_nothing_of_the_ends(path_number, gone):
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), path_number=1))
    for _ in range(gone):
        chain.miss()
    later = folded(hairpin(EVEN + 4.0), path_number=path_number)
    assert chain.push(later).reliability < 0.9


@pytest.mark.parametrize(("frames_unexplained", "is_sure"), [(5, True), (6, False)])
def test_a_body_that_was_lost_meanwhile_may_have_changed_its_ends(frames_unexplained, is_sure):
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), path_number=-1))
    for _ in range(frames_unexplained):
        chain.push(folded(hairpin(EVEN), path_number=-1, over_limits=2.0))
    link = chain.push(folded(hairpin(EVEN + 4.0), path_number=-1))
    assert (link.reliability > 0.99) == is_sure


def test_ends_are_those_of_the_last_explained_body_where_one_was_turned_round():
    """In between it was followed the wrong way round, and nearer to what it was then."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN)))
    wrong = hairpin(EVEN)[::-1]
    chain.push(folded(wrong, over_limits=2.0, path_number=3))
    chain.push(folded(wrong, over_limits=2.0, path_number=3))
    link = chain.push(folded(hairpin(EVEN + 1.0), turned_round=True, path_number=4))
    assert np.array_equal(link.observation.points, hairpin(EVEN + 1.0))
    assert link.reliability == LinkSettings().turned_reliability
    assert link.frames_passed == 2


@pytest.mark.parametrize(("turned_round", "is_certain"), [(True, True), (False, False)])
def test_the_head_stays_certain_over_a_body_that_was_followed_the_wrong_way_round(
    turned_round, is_certain
):
    head_tail = HeadTail(WormTrack(), HeadTailSettings())
    queue = FrameQueue(
        head_tail, 256, np.nan, most_frames_for_body=0, agreement=AgreementSettings()
    )
    into_the_turn = [folded(hairpin(arm), path_number=1) for arm in np.arange(-60.0, EVEN, 4.0)]
    seen = [replace(each, end_sd_px=(0.0, 0.0)) for each in into_the_turn]
    lost = folded(hairpin(EVEN, apart=0.5)[::-1], over_limits=2.0)  # the same from either end
    seen += [Observation(Status.COILED, followed=lost)] * 2
    seen += [folded(hairpin(EVEN), turned_round=turned_round)]
    for frame, observation in enumerate(seen):
        queue.push(PendingFrame(frame, frame, observation, None))
    given = queue.finish()
    certain = [each.state.head_certainty > 0.9 for each in given if each.state.status.has_pose]
    assert all(certain) if is_certain else not any(certain)
