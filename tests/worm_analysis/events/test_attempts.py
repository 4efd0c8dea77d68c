"""Attempts at the exit by bodies that follow their heads round its corner."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from walked_tracks import BODY_WIDTH, GEOMETRY, R, Track, polar

from worm_analysis.analysis import Analysis
from worm_analysis.events.attempts import Attempts
from worm_analysis.events.exit_region import ExitCorridor
from worm_msgs_py import Attempt, Where

RATE_HZ, SPEED = 30, 2e-3
HALF_WIDTH = 0.5e-3
MOUTH = np.sqrt(R**2 - HALF_WIDTH**2)
SPACING = 2e-5


def way_along_wall_and_in(side, from_corner_m, beyond_m):
    """Points of the way of a head that slides to the exit's corner and rounds it, and depths."""
    off_wall = 5e-5
    corner = np.arcsin((HALF_WIDTH - 2 * off_wall) / R)
    angles = np.arange(corner + from_corner_m / R, corner, -SPACING / R)
    along = polar(np.full(len(angles), R - off_wall), side * angles)
    y = (HALF_WIDTH - 2 * off_wall) * side
    x = np.arange((R - off_wall) * np.cos(corner), MOUTH + beyond_m, SPACING)
    return np.vstack([along, np.column_stack([x, np.full(len(x), y)])])


def film(way, at_m, length_m):
    """States of a body that lies on the way behind its head, whose place on it is given."""
    at = np.round(at_m / SPACING).astype(int)
    body = round(length_m / SPACING)
    sums = np.vstack([np.zeros(2), np.cumsum(way, axis=0)])
    centroid = (sums[at + 1] - sums[at + 1 - body]) / body
    head, n = way[at], len(at)
    out = np.hypot(*head.T) > R
    track = Track(
        stamp_ns=np.round(np.arange(n) * 1e9 / RATE_HZ).astype(np.int64),
        head=head,
        centroid=centroid,
        tail=way[at + 1 - body],
        yaw=np.zeros(n),
        width=np.full(n, BODY_WIDTH),
        length=np.full(n, length_m),
        chamber=np.full(n, "chamber_a"),
        where=np.where(out, Where.PASSAGE, Where.CHAMBER_A),
    )
    return track, head, centroid


def attempts(track):
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    events = [event for state in track.states() for event in analysis.push(state)[1]]
    return [e for e in [*events, *analysis.finish()] if isinstance(e, Attempt)]


@pytest.mark.parametrize(("beside_m", "success"), [(5e-5, False), (-1e-5, True)])
def test_a_centroid_just_beside_the_passage_is_no_success(beside_m, success):
    """That of a long body in the passage and round its corner comes near to it slowly."""
    exit_, follow = ExitCorridor.of(GEOMETRY.chambers[0], 1.5e-3), Attempts(0.3)
    for row, x_m in enumerate([1e-3, 1.2e-2, -1e-3]):
        attempt = follow.push(
            "chamber_a", exit_, row * 10**8, (R + x_m, 0.0), (R + 1e-3, HALF_WIDTH + beside_m),
            0.02, 1.2e-4, error_m=1e-5, in_passage=False,
        )  # fmt: skip
        if attempt is not None:
            break
    assert attempt.success is success


lengths = st.floats(1.2e-2, 2.6e-2)
sides = st.sampled_from([-1, 1])


@settings(max_examples=40, deadline=None)
@given(sides, lengths, st.floats(0.05, 0.45))
def test_a_head_that_withdraws_has_failed_wherever_its_bent_body_lay(side, length, part):
    """The centroid of a body on the arc and in the passage may lie outside of both."""
    way = way_along_wall_and_in(side, length + 4e-3, 1.5e-2)
    begin, deepest = length + 1e-3, length + 4e-3 + part * length
    there = np.arange(begin, deepest, SPEED / RATE_HZ)
    track, head, _ = film(way, np.concatenate([there, there[::-1]]), length)
    (attempt,) = attempts(track)
    assert attempt.complete
    assert not attempt.success
    assert attempt.penetration_m == pytest.approx(head[:, 0].max() - MOUTH, abs=1e-5)


@settings(max_examples=40, deadline=None)
@given(sides, lengths)
def test_a_body_that_follows_its_head_into_the_passage_has_succeeded(side, length):
    way = way_along_wall_and_in(side, length + 4e-3, 3e-2)
    last = (len(way) - 2) * SPACING
    track, head, centroid = film(way, np.arange(length + 1e-3, last, SPEED / RATE_HZ), length)
    (attempt,) = attempts(track)
    assert attempt.success
    inside = (np.abs(centroid[:, 1]) <= HALF_WIDTH) & (np.hypot(*centroid.T) > R)
    at_end = np.searchsorted(track.stamp_ns, attempt.end_ns)
    assert abs(at_end - np.argmax(inside)) * SPEED / RATE_HZ < 4e-3, "give or take the margin"
    assert attempt.penetration_m == pytest.approx(head[at_end, 0] - MOUTH, abs=1e-4)


def test_the_centroid_of_a_bent_body_lies_beyond_the_circle_beside_the_passage():
    """The case that a rule of the radius alone would tell as a success."""
    way = way_along_wall_and_in(1, 2.4e-2, 1.5e-2)
    track, head, centroid = film(way, np.array([2.4e-2 + 8e-3]), 2e-2)
    assert np.hypot(*centroid[0]) > R
    assert centroid[0, 1] > 2e-3
    assert head[0, 0] - MOUTH > 5e-3
    assert len(track.stamp_ns) == 1
