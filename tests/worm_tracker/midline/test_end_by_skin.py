"""A skin with marks tells where an end lies along another strand, also a pale one."""

import numpy as np
import pytest
from flank_ends import along_itself, with_last_end_moved
from hypothesis import given, settings
from hypothesis import strategies as st
from skinned_ends import WIDTH, body_in_skin, from_its_end, marks_along

from worm_tracker.midline.end_by_skin import EndBySkinSettings, EndInSkin
from worm_tracker.midline.end_in_picture import with_end_aside
from worm_tracker.midline.likeliest_end import KnownEnd

SETTINGS = EndBySkinSettings()
MOST_SD_WIDTHS = 0.42
"""What the tracker asks for to tell an end where overlaps are darker."""
LENGTH = float(abs(np.diff(along_itself(WIDTH, 0.0, 0.6)[0])).sum())
ANGLES = st.floats(0.0, 2 * np.pi)


def from_last_end(line, longer_widths=0.0):
    return with_last_end_moved(line, WIDTH, longer_widths)[::-1][::2]


def in_skin(signal, curve, widths, mean):
    known = KnownEnd(complex(curve[0]), WIDTH, WIDTH, LENGTH, 5 * WIDTH)
    return EndInSkin.of(signal, from_its_end(curve, widths, mean), known, SETTINGS)


def end_of(signal, curve, widths, mean):
    return in_skin(signal, curve, widths, mean).likeliest()


@given(start=ANGLES, aside=st.floats(0.3, 0.9), seed=st.integers(0, 99))
@settings(max_examples=20)
def test_an_end_is_told_as_surely_as_it_lies_where_it_is_seen(start, aside, seed):
    line, widths, signal, mean = body_in_skin(start, aside, marks_along(seed))
    end = end_of(signal, from_last_end(line), widths, mean)
    tip = line[-1] if end.curve is None else end.curve[0]
    assert abs(tip - line[-1]) < max(0.5, 2.5 * end.sd_px / WIDTH) * WIDTH


@pytest.mark.parametrize(
    ("longer_widths", "pale_end"),
    [(-2.0, 1.0), (-1.2, 1.0), (1.2, 1.0), (2.0, 1.0), (-1.2, 0.6), (1.2, 0.6)],
)
@pytest.mark.parametrize("start", [0.7, 4.1])
def test_an_end_told_too_short_or_too_long_is_found_where_it_is_seen(
    longer_widths, pale_end, start
):
    line, widths, signal, mean = body_in_skin(start, 0.6, marks_along(3, pale_end))
    curve = from_last_end(line, longer_widths)
    end = end_of(signal, curve, widths, mean)
    assert abs(curve[0] - line[-1]) > 1.1 * WIDTH
    assert abs(end.curve[0] - line[-1]) < 0.5 * WIDTH
    assert end.sd_px < MOST_SD_WIDTHS * WIDTH


@pytest.mark.parametrize("aside_widths", [-0.4, 0.4])
@pytest.mark.parametrize("start", [0.0, 2.0])
def test_an_end_followed_aside_is_found_where_it_is_seen(aside_widths, start):
    line, widths, signal, mean = body_in_skin(start, 0.6, marks_along(5))
    curve = with_end_aside(from_last_end(line), aside_widths * WIDTH, 2.0 * WIDTH)
    end = end_of(signal, curve, widths, mean)
    along = (line[-1] - line[-20]) / abs(line[-1] - line[-20])
    assert abs(((end.curve[0] - line[-1]) / along).imag) < 0.2 * WIDTH


@pytest.mark.parametrize("seed", range(3))
def test_a_skin_that_is_not_this_one_moves_no_end(seed):
    """Another worm's marks, and much fainter ones, do not fit anywhere."""
    line, widths, signal, mean = body_in_skin(1.0, 0.6, marks_along(seed))
    curve = from_last_end(line, 1.2)
    end = end_of(signal, curve, widths, 0.45 * mean)
    assert end.curve is None
    assert end.sd_px == np.inf
    assert end_of(signal, curve, widths, mean).curve is not None, "its own skin tells it"


def test_an_end_beyond_the_picture_is_not_told():
    line, widths, signal, mean = body_in_skin(0.0, 0.6, marks_along(0))
    end = end_of(signal, from_last_end(line) + 5000, widths, mean)
    assert end.curve is None
    assert end.sd_px == np.inf


@given(start=ANGLES, aside=st.floats(0.3, 0.9), seed=st.integers(0, 99))
@settings(max_examples=20)
def test_an_end_costs_little_where_it_lies_and_much_where_it_does_not(start, aside, seed):
    line, widths, signal, mean = body_in_skin(start, aside, marks_along(seed))
    costs = [
        in_skin(signal, from_last_end(line, longer), widths, mean).cost for longer in (0, 1.5, -1.5)
    ]
    assert costs[0] < SETTINGS.most_cost_of_sure
    assert min(costs[1:]) > 1.5 * costs[0]
