"""A midline that bends sharply to both sides within a width or two makes an S, wherever it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.s_turns import s_shaped_part, s_turn_at_ends

WIDTH = 8.0


def line_with_turns(*turns_rad, spacing=8.0):
    """Return a straight line whose last part turns by so much after each eight pixels."""
    headings = np.cumsum([0.0, *turns_rad])
    legs = [100.0] + [spacing] * len(turns_rad)
    steps = [np.full(round(leg), np.exp(1j * h)) for leg, h in zip(legs, headings, strict=True)]
    return as_points(np.cumsum(np.concatenate(steps)))


@pytest.mark.parametrize("turned_round", [False, True])
@pytest.mark.parametrize("mirrored", [False, True])
def test_an_s_near_an_end_is_as_sharp_as_the_lesser_of_its_turns(turned_round, mirrored):
    points = line_with_turns(1.4, -0.9) * (1, -1 if mirrored else 1)
    points = points[::-1] if turned_round else points
    assert s_turn_at_ends(points, 8.0, 3.0) == pytest.approx(0.9, abs=0.05)


@pytest.mark.parametrize("turns_rad", [(), (1.4,), (1.0, 1.2), (-0.8, -0.8)])
def test_a_line_that_turns_one_way_near_its_ends_makes_no_s(turns_rad):
    assert s_turn_at_ends(line_with_turns(*turns_rad), 8.0, 3.0) <= 0.0 + 1e-9


def test_an_s_far_from_both_ends_does_not_count():
    straight_on = [0.0] * 4
    assert s_turn_at_ends(line_with_turns(1.4, -1.4, *straight_on), 8.0, 3.0) < 1e-9


def line_with_s(turn_rad, at, apart_widths, back=-1.0):
    """Return a straight line that turns at a part of its length, and back so many widths on."""
    count, length = 1200, 400.0
    headings = np.zeros(count)
    first = round(at * count)
    headings[first : first + round(apart_widths * WIDTH * count / length)] = turn_rad
    headings[first + round(apart_widths * WIDTH * count / length) :] = turn_rad * (1 + back)
    return as_points(np.cumsum(np.exp(1j * headings)) * length / count)


@given(
    turn_rad=st.floats(0.7, 1.4),
    at=st.floats(0.1, 0.85),
    apart_widths=st.floats(1.0, 1.4),
    mirrored=st.booleans(),
)
def test_an_s_is_found_where_it_is(turn_rad, at, apart_widths, mirrored):
    points = line_with_s(turn_rad, at, apart_widths) * (1, -1 if mirrored else 1)
    first, last = s_shaped_part(points, WIDTH, 0.6, 1.5)
    bends = at, at + apart_widths * WIDTH / 400
    assert first < bends[0] < bends[1] < last
    assert last - first < bends[1] - bends[0] + 3 * WIDTH / 400


@pytest.mark.parametrize(
    ("turn_rad", "apart_widths", "back"),
    [(0.5, 1.0, -1.0), (1.2, 3.0, -1.0), (1.2, 1.0, 0.5), (0.0, 1.0, 0.0)],
    ids=["blunt", "far apart", "one way", "straight"],
)
def test_a_line_that_bends_otherwise_makes_no_s(turn_rad, apart_widths, back):
    assert s_shaped_part(line_with_s(turn_rad, 0.5, apart_widths, back), WIDTH, 0.6, 1.5) is None


def test_of_several_all_are_given():
    further = line_with_s(1.0, 0.7, 1.2) + np.array([400.0, 0.0])
    points = np.concatenate([line_with_s(1.0, 0.3, 1.2), further])
    first, last = s_shaped_part(points, WIDTH, 0.6, 1.5)
    assert first < 0.16
    assert last > 0.84
