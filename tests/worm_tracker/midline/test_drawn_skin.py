"""A body drawn in its skin dims each pixel by what each of its parts keeps of the light."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.body_shade import ACROSS
from worm_tracker.midline.drawn_skin import SkinnedBody, dim_by_body

SIDE, HALF = 80, 6.0
MIDDLE = 39.5 * (1 + 1j)
WHOLE = (False, False)
HEADINGS = st.floats(0.0, 2 * np.pi)


def through_body(line, absorbed, cut=WHOLE, half=HALF, through=None):
    """Return the light that a body of one width lets through, (SIDE, SIDE)."""
    through = np.ones((SIDE, SIDE)) if through is None else through
    kept = np.broadcast_to(np.atleast_2d(absorbed).T, (len(line), len(ACROSS)))
    dim_by_body(through, np.asarray(line), np.full(len(line), half), kept, cut)
    return through


def bar(heading, half_length=25.0):
    return MIDDLE + np.exp(1j * heading) * np.arange(-half_length, half_length + 1)


@given(heading=HEADINGS, kept=st.floats(0.1, 0.9))
def test_a_straight_body_keeps_its_part_of_the_light_of_its_own_area(heading, kept):
    taken = 1 - through_body(bar(heading), kept)
    area = 50 * 2 * HALF + np.pi * HALF**2  # its ends are round
    assert taken.sum() == pytest.approx(kept * area, rel=0.02)
    assert taken.max() == pytest.approx(kept)


@given(heading=HEADINGS, one=st.floats(0.1, 0.9), other=st.floats(0.1, 0.9))
def test_where_two_parts_cross_each_dims_what_the_other_lets_through(heading, one, other):
    first, last = bar(heading), bar(heading + np.pi / 2)
    turn = last[0] + 500 * np.exp(1j * np.linspace(0, 1, 200))  # round by a way out of the window
    line = np.concatenate([first, first[-1] + 500 + turn - turn[0], last])
    kept = np.where(np.arange(len(line)) < len(first) + len(turn) // 2, one, other)
    through = through_body(line, kept)
    assert through[39, 39] == pytest.approx((1 - one) * (1 - other))


@given(heading=HEADINGS, at=st.integers(10, 40))
def test_a_body_drawn_in_two_parts_that_are_cut_where_they_join_is_the_whole_body(heading, at):
    line = MIDDLE + 20 * np.exp(1j * (heading + np.linspace(0, 2.5, 51)))
    kept = np.linspace(0.3, 0.7, 51)
    whole = through_body(line, kept)
    part = through_body(line[: at + 2], kept[: at + 2], (False, True))
    parts = through_body(line[at - 1 :], kept[at - 1 :], (True, False), through=part)
    assert abs(parts - whole).max() < 0.1  # two halves of a pixel are dimmed one after the other


@given(heading=HEADINGS)
def test_a_skin_darker_on_one_side_is_darker_there_whichever_way_it_heads(heading):
    line, kept = bar(heading), np.broadcast_to(np.linspace(0.2, 0.6, len(ACROSS)), (51, 7))
    through = np.ones((SIDE, SIDE))
    dim_by_body(through, line, np.full(51, HALF), kept, WHOLE)
    to_the_right = 1j * np.exp(1j * heading)  # v points down
    right, left = (MIDDLE + side * 3 * to_the_right for side in (1, -1))
    dark, pale = (through[round(p.imag), round(p.real)] for p in (right, left))
    assert dark < pale


@given(u=st.floats(-1e7, 1e7) | st.just(np.nan), v=st.floats(-1e7, 1e7))
def test_what_lies_out_of_the_window_dims_nothing(u, v):
    line = bar(0.0) + complex(u, v)
    outside = not (-60 < u < 120 and -60 < v < 120)
    assert not outside or (through_body(line, 0.5) == 1).all()


@given(darkening=st.floats(0.0, 2.0), level=st.floats(20.0, 150.0))
def test_two_layers_are_as_dark_as_overlaps_are_known_to_be(darkening, level):
    mean = np.full((65, len(ACROSS)), level)
    body = SkinnedBody(bar(0.0), np.full(65, 2 * HALF), mean, level, darkening)
    kept = body.absorbed(np.array([0.0, 0.5, 1.0]))[1, 3]
    two = body.blackest * (1 - (1 - kept) ** 2)
    assert two == pytest.approx(level * (1 + min(darkening, 0.95)), rel=0.03)
