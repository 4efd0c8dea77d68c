"""A folded pose much shorter or longer than a moment before is taken back; a stroke never is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_msgs_py.contract.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_tracker.waiting.sudden_lengths import SuddenLengths, SuddenLengthSettings

LENGTH_PX = 200.0
LINE = Midline(*(np.zeros(3) for _ in range(6)))


def pose(k, length_px, status=Status.FOLDED, frames_per_s=25):
    state = BodyState(
        k,
        round(1e9 * k / frames_per_s),
        status=status,
        head_certainty=1.0,
        head=Keypoint(0.0, 0.0),
        centroid=Keypoint(50.0, 0.0, yaw_rad=0.0),
        tail=Keypoint(100.0, 0.0),
        length_px=length_px,
        width_px=10.0,
    )
    return TrackedFrame(state, LINE, None)


def taken_back_in(frames):
    """Return the numbers of those whose pose is taken back; all are given, in their order."""
    lengths = SuddenLengths(SuddenLengthSettings())
    given_back = [told for frame in frames for told in lengths.push([frame])]
    assert [told.state.frame for told in given_back] == [frame.state.frame for frame in frames]
    return [told.state.frame for told in given_back if not told.state.status.has_pose]


def film(count=40, *, lengths_of=None, status=Status.FOLDED, frames_per_s=25):
    lengths_of = lengths_of or {}
    return [pose(k, lengths_of.get(k, 1.0) * LENGTH_PX, status, frames_per_s) for k in range(count)]


@pytest.mark.parametrize("part", [0.86, 1.16])
@pytest.mark.parametrize("run", [1, 5])
def test_a_folded_body_that_is_suddenly_of_another_length_is_taken_back(part, run):
    off = {20 + k: part for k in range(run)}
    assert taken_back_in(film(lengths_of=off)) == list(off)


def test_an_open_body_may_contract_as_it_likes():
    assert taken_back_in(film(lengths_of={20: 0.7, 21: 0.7}, status=Status.TRACKED)) == []


@given(amplitude=st.floats(0.0, 0.07), strokes_per_s=st.floats(0.1, 1.0))
def test_strokes_are_no_sudden_change(amplitude, strokes_per_s):
    t = np.arange(100) / 25
    lengths = 1 + amplitude * np.sin(2 * np.pi * strokes_per_s * t)
    assert taken_back_in(film(100, lengths_of=dict(enumerate(lengths)))) == []


def test_a_body_that_stays_contracted_is_told_again_after_a_moment():
    frames = film(60, lengths_of=dict.fromkeys(range(20, 60), 0.8))
    back = taken_back_in(frames)
    assert back[0] == 20
    assert 25 < back[-1] < 35


def test_what_was_told_long_ago_tells_nothing_of_a_length_now():
    early, late = film(10), film(3, lengths_of={0: 0.7, 1: 0.7, 2: 0.7})
    later = [pose(100 + k, frame.state.length_px) for k, frame in enumerate(late)]
    assert taken_back_in([*early, *later]) == []


def test_a_hidden_end_has_no_length_to_judge():
    frames = [*film(20), pose(20, np.nan), *[pose(k, LENGTH_PX) for k in range(21, 30)]]
    assert taken_back_in(frames) == []
