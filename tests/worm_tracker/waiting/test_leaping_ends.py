"""A pose whose end leapt there and back is taken back; a worm's own motion never is."""

from dataclasses import replace
from math import isnan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_msgs_py.contract.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_tracker.waiting.leaping_ends import LeapingEnds, LeapingEndsSettings

WIDTH_PX = 20.0
MANY = 256
LINE = Midline(*(np.zeros(3) for _ in range(6)))


def film(count=40, *, off=(), off_widths=2.0, jolted=(), untold=(), frames_per_s=25):
    """A worm that crawls with strokes; its tail is off in some frames, all of it in others."""
    frames = []
    for k in range(count):
        t = k / frames_per_s
        head, tail = 400 + 30 * t + 12 * np.sin(5 * t), 100 + 30 * t - 12 * np.sin(5 * t)
        beside = 50 + off_widths * WIDTH_PX * (k in off)
        jolt = 60.0 * (k in jolted)
        state = BodyState(
            k,
            round(1e9 * t),
            status=Status.FOLDED,
            head_certainty=1.0,
            head=Keypoint(head, 50 + jolt),
            centroid=Keypoint((head + tail) / 2, 50 + jolt, yaw_rad=0.0),
            tail=Keypoint(tail, beside + jolt),
            length_px=300.0,
            width_px=WIDTH_PX,
        )
        if k in untold:
            state = BodyState(k, state.stamp_ns, status=Status.COILED)
        frames.append(TrackedFrame(state, LINE, None))
    return frames


def given_by(frames, *, at_once=1):
    leaping_ends = LeapingEnds(LeapingEndsSettings())
    told = []
    for first in range(0, len(frames), at_once):
        told += leaping_ends.push(frames[first : first + at_once], MANY)
    return told + leaping_ends.push([], MANY, is_end=True)


def taken_back_in(frames, **how):
    told = given_by(frames, **how)
    assert [frame.state.frame for frame in told] == list(range(len(frames)))
    return [
        after.state.frame
        for before, after in zip(frames, told, strict=True)
        if before.state.status.has_pose and not after.state.status.has_pose
    ]


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_poses_between_a_leap_and_a_leap_back_are_taken_back(count):
    off = range(15, 15 + count)
    assert taken_back_in(film(off=off)) == list(off)


def test_an_end_that_leaps_and_stays_was_found_again():
    assert taken_back_in(film(off=range(15, 24))) == []
    assert taken_back_in(film(off=range(15, 40))) == []


def test_what_is_taken_back_says_so():
    told = given_by(film(off=[15]))[15]
    assert told.state.status is Status.COILED
    assert (told.state.confidence, told.state.head_certainty) == (0.0, 0.5)
    assert isnan(told.state.head.u_px)
    assert isnan(told.state.tail.u_px)
    assert isnan(told.state.length_px)
    assert len(told.midline.u_px) == 0
    assert told.state.centroid.u_px > 0


def test_a_jolt_of_the_rig_is_no_leap():
    assert taken_back_in(film(jolted=[15, 16])) == []


def test_a_pose_beside_a_coil_is_taken_back_where_its_end_leaps_far():
    coil = range(10, 15)
    assert taken_back_in(film(untold=coil, off=[15])) == [15]
    assert taken_back_in(film(untold=coil, off=[9])) == [9]
    assert taken_back_in(film(untold=coil, off=[15], off_widths=1.2)) == []


def test_a_pose_between_coils_is_compared_with_none():
    assert taken_back_in(film(untold=[10, 11, 13, 14], off=[12])) == []


def test_a_worm_goes_farther_between_frames_that_are_farther_apart():
    assert taken_back_in(film(off=[15], frames_per_s=60)) == [15]
    assert taken_back_in(film(off=[15], frames_per_s=10)) == []


def test_exchanged_ends_are_no_leap():
    frames = film()
    for k in range(15, 18):
        state = frames[k].state
        exchanged = replace(state, head=state.tail, tail=state.head)
        frames[k] = replace(frames[k], state=exchanged)
    assert taken_back_in(frames) == []


def test_an_open_worm_is_told_at_once():
    leaping_ends = LeapingEnds(LeapingEndsSettings())
    for frame in film():
        assert leaping_ends.push([frame], MANY) == [frame]
        assert len(leaping_ends) == 0


def test_no_frame_waits_for_longer_than_a_leap_back_may_take():
    leaping_ends, most = LeapingEnds(LeapingEndsSettings()), 0
    for frame in film(off=range(15, 40), untold=[5]):
        leaping_ends.push([frame], MANY)
        most = max(most, len(leaping_ends))
    assert most == 8


@pytest.mark.parametrize("most_held", [-2, 0, 3])
def test_no_more_frames_wait_than_may(most_held):
    """With `hold_back_frames` of 0 every frame is given at once, as it is."""
    leaping_ends, told = LeapingEnds(LeapingEndsSettings()), []
    frames = film(off=range(15, 20), untold=[5])
    for frame in frames:
        told += leaping_ends.push([frame], most_held)
        assert len(leaping_ends) <= max(most_held, 0)
    numbers = [frame.state.frame for frame in told]
    assert numbers == list(range(len(told)))
    assert (told == frames) is (most_held <= 0)


@settings(max_examples=60, deadline=None)
@given(
    off=st.sets(st.integers(3, 36)),
    untold=st.sets(st.integers(3, 36)),
    at_once=st.integers(1, 40),
)
def test_what_is_told_does_not_hang_on_how_many_frames_come_at_once(off, untold, at_once):
    frames = film(off=off, untold=untold)
    assert taken_back_in(frames, at_once=at_once) == taken_back_in(frames)
