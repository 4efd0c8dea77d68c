"""A worm moves head-first, mostly: what its motion tells is held against real animals."""

from itertools import pairwise
from math import exp
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.head_tail.forward_motion import ForwardMotionSettings, together, with_motion

SETTINGS = ForwardMotionSettings()
LARVA = Path(__file__).parents[3] / "bags" / "source" / "larva_track.csv.gz"
ways = st.floats(-3, 3)


@given(odds=st.floats(-12, 12), way=ways)
def test_a_way_there_and_back_again_tells_nothing(odds, way):
    there = with_motion(odds, way, SETTINGS)
    assert with_motion(there, -way, SETTINGS) == pytest.approx(odds, abs=1e-9)


@given(odds=st.floats(-12, 12), way=ways)
def test_the_other_end_is_told_the_contrary(odds, way):
    assert with_motion(-odds, -way, SETTINGS) == pytest.approx(-with_motion(odds, way, SETTINGS))


@given(odds=st.floats(-12, 12), ways=st.lists(ways, min_size=1, max_size=5))
def test_steps_tell_as_much_as_the_way_that_they_make(odds, ways):
    by_steps = odds
    for way in ways:
        by_steps = with_motion(by_steps, way, SETTINGS)
    assert by_steps == pytest.approx(with_motion(odds, sum(ways), SETTINGS), abs=1e-9)


@given(one=ways, other=ways)
def test_two_motions_tell_as_much_as_one_of_both_ways(one, other):
    apart = with_motion(0.0, one, SETTINGS), with_motion(0.0, other, SETTINGS)
    at_once = with_motion(0.0, one + other, SETTINGS)
    assert together(*apart, SETTINGS) == pytest.approx(at_once, abs=1e-9)


def forward_lengths():
    """Return how far a real larva moved head-first in each frame, in lengths."""
    track = np.genfromtxt(LARVA, delimiter=",")
    spine = track[:, 1:25].reshape(-1, 12, 2)[:, ::-1].copy()  # kept tail first
    for before, now in pairwise(spine):  # the source takes one end for the other now and then
        if np.abs(now[::-1] - before).sum() < np.abs(now - before).sum():
            now[:] = now[::-1].copy()
    line = spine[..., 0] + 1j * spine[..., 1]
    length = np.median(np.abs(np.diff(line, axis=1)).sum(axis=1))
    tangent = np.gradient(line, axis=1)
    tangent /= np.abs(tangent)
    moved = -((line[1:] - line[:-1]) * tangent[:-1].conj()).real
    return moved.mean(axis=1) / length


def part_tail_first(lengths, moved):
    """Return how often a way of so many lengths, from anywhere in a track, was tail-first."""
    outcomes = []
    for start in range(0, len(moved), 10):
        way = np.cumsum(moved[start:])
        beyond = np.flatnonzero(np.abs(way) >= lengths)
        if len(beyond):
            outcomes.append(way[beyond[0]] < 0)
    assert len(outcomes) > 50
    return np.mean(outcomes)


@pytest.mark.parametrize("lengths", [0.1, 0.2, 0.3, 0.5, 0.7])
def test_a_real_larva_moves_tail_first_no_oftener_than_told(lengths):
    moved = forward_lengths()
    moved = moved[np.isfinite(moved)]
    told = 1 / (1 + exp(with_motion(0.0, lengths, SETTINGS)))
    assert part_tail_first(lengths, moved) <= told
