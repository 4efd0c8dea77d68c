"""A pose amid coils is taken back; one beside a fold that is understood never is."""

from math import isnan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_msgs_py.contract.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_tracker.waiting.lone_poses import LonePoses, LonePoseSettings

MANY = 256
LINE = Midline(*(np.zeros(3) for _ in range(6)))


def film(coiled, *, count=40, status=Status.FOLDED, frames_per_s=25):
    """A folded worm of which some frames do not tell how it lies."""
    frames = []
    for k in range(count):
        stamp_ns = round(1e9 * k / frames_per_s)
        known = {"head": Keypoint(100.0, 50.0), "tail": Keypoint(40.0, 50.0), "length_px": 90.0}
        state = BodyState(k, stamp_ns, status=status, head_certainty=1.0, **known)
        if k in coiled:
            state = BodyState(k, stamp_ns, status=Status.COILED)
        frames.append(TrackedFrame(state, LINE, None))
    return frames


def taken_back_in(frames, *, at_once=1):
    """Return the numbers of those whose pose is taken back; all are given, in their order."""
    lone_poses, told = LonePoses(LonePoseSettings()), []
    for first in range(0, len(frames), at_once):
        told += lone_poses.push(frames[first : first + at_once], MANY)
    told += lone_poses.push([], MANY, is_end=True)
    assert [frame.state.frame for frame in told] == [frame.state.frame for frame in frames]
    return [
        after.state.frame
        for before, after in zip(frames, told, strict=True)
        if before.state.status is not after.state.status
    ]


@pytest.mark.parametrize("poses", [[20], [20, 21], [18, 20, 22], [20, 21, 22, 23, 24]])
def test_poses_amid_coils_are_taken_back(poses):
    assert taken_back_in(film(set(range(10, 31)) - set(poses))) == poses


@pytest.mark.parametrize("status", [Status.TRACKED, Status.LOOP_IN_DOUBT, Status.END_HIDDEN])
def test_whatever_they_tell(status):
    assert taken_back_in(film({*range(10, 20), *range(21, 31)}, status=status)) == [20]


def test_what_is_taken_back_says_so():
    lone_poses = LonePoses(LonePoseSettings())
    frames = film({*range(10, 20), *range(21, 31)})
    told = lone_poses.push(frames, MANY)[20].state
    assert (told.status, told.head_certainty) == (Status.COILED, 0.5)
    assert isnan(told.head.u_px)


@pytest.mark.parametrize(
    "coiled",
    [
        pytest.param(range(10, 30), id="beside coils"),
        pytest.param({*range(10, 20), *range(26, 36)}, id="six in a row"),
        pytest.param(range(10, 40, 3), id="two of three"),
        pytest.param(range(10, 36), id="where the film ends"),
        pytest.param(range(1, 40), id="where the film begins"),
        pytest.param({12, 20, 21, 33}, id="a coil now and then"),
    ],
)
def test_poses_beside_others_stay(coiled):
    assert taken_back_in(film(coiled)) == []


@pytest.mark.parametrize(("frames_per_s", "taken_back"), [(5, []), (10, [20]), (50, [20])])
def test_a_moment_is_as_long_at_any_frame_rate(frames_per_s, taken_back):
    """Ten frames are coiled before the pose, and one after it: at 5 a second that is all."""
    coiled = {*range(10, 20), *(range(21, 31) if frames_per_s > 5 else ())}
    assert taken_back_in(film(coiled, frames_per_s=frames_per_s)) == taken_back


def test_frames_without_a_worm_are_no_coils():
    frames = film(range(0))
    for k in {*range(15, 20), *range(21, 25)}:
        frames[k] = TrackedFrame(BodyState(k, frames[k].state.stamp_ns, Status.NO_WORM), LINE, None)
    assert taken_back_in(frames) == []


def test_an_open_worm_is_told_at_once():
    lone_poses = LonePoses(LonePoseSettings())
    for frame in film(range(0), status=Status.TRACKED):
        assert lone_poses.push([frame], MANY) == [frame]
        assert len(lone_poses) == 0


def test_a_pose_behind_a_coil_waits_for_a_fifth_of_a_second():
    lone_poses, most = LonePoses(LonePoseSettings()), 0
    for frame in film([5]):
        lone_poses.push([frame], MANY)
        most = max(most, len(lone_poses))
    assert most == 6  # at 25 frames a second the sixth is the first beyond that


@pytest.mark.parametrize("most_held", [-2, 0, 3])
def test_no_more_frames_wait_than_may(most_held):
    """With `hold_back_frames` of 0 every frame is given at once, as it is."""
    lone_poses, told = LonePoses(LonePoseSettings()), []
    frames = film({*range(10, 20), *range(21, 31)})
    for frame in frames:
        told += lone_poses.push([frame], most_held)
        assert len(lone_poses) <= max(most_held, 0)
    assert told == frames[: len(told)]


@settings(max_examples=60, deadline=None)
@given(coiled=st.sets(st.integers(0, 39)), at_once=st.integers(1, 40))
def test_what_is_told_does_not_hang_on_how_many_frames_come_at_once(coiled, at_once):
    frames = film(coiled)
    assert taken_back_in(frames, at_once=at_once) == taken_back_in(frames)


@given(st.lists(st.integers(-200, 200), min_size=9, max_size=9))
def test_stamps_that_do_not_increase_lose_no_frame(jitter_ms):
    frames = [
        TrackedFrame(BodyState(k, round(1e6 * ms), Status.COILED if k % 2 else status), LINE, None)
        for k, (ms, status) in enumerate(zip(jitter_ms, 9 * [Status.FOLDED], strict=True))
    ]
    taken_back_in(frames)
