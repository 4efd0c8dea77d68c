"""An end that lies on the body is not told where it cannot have been by how it moves."""

import numpy as np
import pytest
from hairpin_frames import FRAMES, MIDDLE, film, gap_of, with_end_off
from hypothesis import given
from hypothesis import strategies as st
from waiting_frames import WIDTH

from worm_msgs_py import Status
from worm_tracker.observation import Observation
from worm_tracker.waiting.brief_gaps import BriefGaps, BriefGapSettings


def told_in_the_middle(frames):
    return BriefGaps(BriefGapSettings()).tell(frames, len(frames))[MIDDLE]


def off_in_the_middle(*args, **more):
    return film([MIDDLE], lambda k: with_end_off(k, *args, **more))


def is_told_as_it_was(frames):
    return told_in_the_middle(frames) is frames[MIDDLE].observation


@pytest.mark.parametrize("off_widths", [0.75, 1.0, 3.0])
def test_an_end_told_off_its_way_in_one_picture_is_hidden(off_widths):
    """Either may be wrong, what this picture tells or what those about it do."""
    told = told_in_the_middle(off_in_the_middle(off_widths))
    assert told.status is Status.END_HIDDEN
    assert told.occluded[0] == 0 < told.occluded[1]


def test_an_end_told_near_its_way_stays_where_it_is_told():
    assert is_told_as_it_was(off_in_the_middle(0.6))


def test_an_end_that_the_outline_shows_stays_where_it_is_told():
    """A stroke, or a leap: what is seen is not doubted."""
    assert is_told_as_it_was(off_in_the_middle(2.0, seen_sd_widths=0.0))


def test_an_end_that_the_outline_shows_is_not_doubted_where_the_other_lies_on_the_body():
    frames = off_in_the_middle(0.0)
    frames[MIDDLE].observation.points[0] += np.array([0.0, 2 * WIDTH])
    assert is_told_as_it_was(frames)


def test_an_end_that_is_as_unsure_as_it_is_off_stays_where_it_is_told():
    assert is_told_as_it_was(off_in_the_middle(0.9, seen_sd_widths=0.4))


def test_an_end_stays_where_it_is_told_where_nothing_is_told_of_it_after():
    frames = off_in_the_middle()
    for frame in frames[MIDDLE + 1 :]:
        frame.observation = Observation(Status.NO_WORM)
    assert is_told_as_it_was(frames)


def test_an_end_stays_where_it_is_told_where_it_may_have_gone_anywhere_meanwhile():
    """Pictures without the worm, for most of a second, and one amid them that shows it."""
    frames = off_in_the_middle(3.0)
    for k in set(gap_of(21)) - {MIDDLE}:
        frames[k].observation = Observation(Status.NO_WORM)
    assert is_told_as_it_was(frames)


def test_an_end_stays_where_it_is_told_where_those_about_it_contradict_each_other():
    frames = off_in_the_middle()
    for k in (MIDDLE - 3, MIDDLE + 2):
        frames[k].observation = with_end_off(k, 0.9, seen_sd_widths=0.01)
    assert is_told_as_it_was(frames)


@pytest.mark.parametrize("off_end", [0, 1])
def test_only_the_end_that_is_off_its_way_is_hidden(off_end):
    def either(k):
        seen = with_end_off(k)
        return seen if off_end else seen.reversed()

    frames = film([MIDDLE], either)
    if not off_end:
        for frame in frames[:MIDDLE] + frames[MIDDLE + 1 :]:
            frame.observation = frame.observation.reversed()
    occluded = told_in_the_middle(frames).occluded
    assert occluded[1 - off_end] == 0 < occluded[off_end]


@given(st.integers(1, FRAMES - 2))
def test_a_frame_is_told_once_those_about_it_are_known(at):
    frames = film([at], with_end_off)
    gaps = BriefGaps(BriefGapSettings())
    before = gaps.tell(frames, gaps.ready(frames[: at + 1], at + 1, frames[at].stamp_ns))
    assert len(before) <= at
    rest = gaps.tell(frames[len(before) :], FRAMES - len(before))
    at_once = BriefGaps(BriefGapSettings()).tell(frames, FRAMES)
    for one, other in zip([*before, *rest], at_once, strict=True):
        assert np.array_equal(one.points, other.points)
        assert one.status is other.status
