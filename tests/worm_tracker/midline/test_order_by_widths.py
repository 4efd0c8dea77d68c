"""A body's widths tell which of its ends is which, wherever it lies and whatever hides a part."""

import numpy as np
import pytest
from drawn_by_discs import drawn_by_discs, finely
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.order_by_widths import OrderSettings, order_score, score_of_widths

SETTINGS = OrderSettings()
N = 65
TAPERED = 14.0 * np.clip(np.linspace(1.2, 0.4, N), 0.5, 1.0)
S = np.linspace(0.0, 1.0, N)


def curved(turn_rad, length=220.0):
    """Return a body that turns evenly by an angle in all, in the middle of a picture."""
    heading = turn_rad * S
    steps = length / (N - 1) * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    points = np.cumsum(steps, axis=0)
    return points - points.mean(axis=0) + 160.0


def seen(points, widths):
    return drawn_by_discs((320, 320), finely(points, 600), finely(widths, 600))


@given(turn_rad=st.floats(-6.0, 6.0))
def test_the_score_of_a_body_turned_round_is_the_contrary(turn_rad):
    points = curved(turn_rad)
    mask = seen(points, TAPERED)
    score = order_score(mask, points, TAPERED, SETTINGS)
    assert score > 2 * SETTINGS.least_score
    assert order_score(mask, points[::-1], TAPERED, SETTINGS) == pytest.approx(-score, abs=0.05)


@given(turn_rad=st.floats(-6.0, 6.0))
def test_a_body_as_wide_at_both_ends_tells_nothing(turn_rad):
    points, even = curved(turn_rad), np.full(N, 12.0)
    assert order_score(seen(points, even), points, even, SETTINGS) == 0.0


@given(turn_rad=st.floats(-6.0, 6.0))
def test_ends_that_have_changed_places_beside_a_loop_are_told_by_their_own_widths(turn_rad):
    """The loop's widths fit: asked as a whole the body tells the order of its loop."""
    points, loop = curved(turn_rad), (0.15, 0.85)
    middle = np.abs(S - 0.5) < 0.35
    as_seen = np.where(middle, TAPERED, TAPERED[::-1])
    mask = seen(points, as_seen)
    assert order_score(mask, points, TAPERED, SETTINGS) > 0.0
    assert order_score(mask, points, TAPERED, SETTINGS, loop) < -SETTINGS.least_score_of_part
    assert order_score(mask, points[::-1], TAPERED, SETTINGS, loop) > SETTINGS.least_score_of_part


@given(turn_rad=st.floats(-6.0, 6.0), first=st.floats(0.0, 0.4), last=st.floats(0.6, 1.0))
def test_what_is_left_of_a_body_tells_its_order_or_nothing(turn_rad, first, last):
    points = curved(turn_rad)
    mask = seen(points, TAPERED)
    score = order_score(mask, points, TAPERED, SETTINGS, (first, last))
    assert score >= 0.0
    assert order_score(mask, points, TAPERED, SETTINGS, (0.0, 1.0)) == 0.0


@given(turn_rad=st.floats(-3.0, 3.0), off_px=st.floats(-3.0, 3.0))
def test_a_midline_beside_the_axis_tells_the_same_order_or_none(turn_rad, off_px):
    points = curved(turn_rad)
    beside = points + np.array([0.0, off_px])
    assert order_score(seen(points, TAPERED), beside, TAPERED, SETTINGS) > 0.0


def test_a_body_elsewhere_tells_no_order():
    points = curved(0.0)
    mask = seen(points + np.array([0.0, 60.0]), TAPERED)
    assert abs(order_score(mask, points, TAPERED, SETTINGS)) < SETTINGS.least_score


@given(
    noise=st.lists(st.floats(-1.0, 1.0), min_size=N, max_size=N),
    shorter=st.floats(0.8, 1.2),
)
def test_measured_widths_tell_the_same_order_as_the_drawn_body(noise, shorter):
    """However noisy they are, and however a stroke makes all of them wider or narrower."""
    measured = shorter * TAPERED + np.array(noise)
    score = score_of_widths(measured, TAPERED, SETTINGS)
    assert score > SETTINGS.least_score
    assert score_of_widths(measured[::-1], TAPERED, SETTINGS) == pytest.approx(-score)


def test_measured_widths_of_a_body_as_wide_at_both_ends_tell_nothing():
    even = np.full(N, 12.0)
    assert score_of_widths(TAPERED, even, SETTINGS) == 0.0
