"""Where else an end of a body may lie: asked of its outline alone."""

import numpy as np
import pytest
from drawn_folds import Drawn, laid, rounded_widths
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.other_ends import (
    OtherEndsSettings,
    likelier_end,
    other_ends,
    sd_by_outline,
)
from worm_tracker.midline.path import evenly, nodes_for
from worm_tracker.midline.strand_drawing import StrandDrawingSettings

WIDTH = 14.0
DRAWING, SETTINGS = StrandDrawingSettings(), OtherEndsSettings()
MOST_SD_PX = 0.35 * WIDTH
"""What the tracker asks for to tell an end. A round one that turns about its middle looks the same,
its tip 0.4 widths aside: none is as sure by its outline as one that is followed in clear water."""
RING = [(8.0, 0.0), (2 * np.pi * 3.0 + 3.0, 1 / 3.0)]
"""A body that goes round once, and three widths on along where it was."""


def crossing(beyond_widths):
    """Return a body whose last end crosses its own strand and goes on so far beyond its middle."""
    return [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (2.5 + beyond_widths, 0.0)]


def path_from_last_end(drawn, cut_widths=0.0):
    s = np.linspace(drawn.length - cut_widths * WIDTH, 0.0, 800)
    return evenly(drawn.at(s), nodes_for(drawn.length, WIDTH))


def others_of(drawn, curve, mask=None):
    s = np.r_[0.0, np.cumsum(np.abs(np.diff(curve)))]
    half = rounded_widths(s, WIDTH) / 2
    mask = drawn.mask if mask is None else mask
    return other_ends(mask, curve, half, WIDTH, DRAWING, SETTINGS)


@given(heading=st.floats(0.0, 6.28), beyond=st.floats(1.6, 3.5))
def test_an_end_that_comes_out_beyond_its_own_strand_lies_nowhere_else(heading, beyond):
    drawn = Drawn.of(crossing(beyond), WIDTH, heading, darker=False)
    curve = path_from_last_end(drawn)
    others = others_of(drawn, curve)
    assert sd_by_outline(others, SETTINGS) < MOST_SD_PX
    assert likelier_end(others, curve, WIDTH, SETTINGS) is None


@given(heading=st.floats(0.0, 6.28))
def test_an_end_that_lies_within_its_own_strand_may_as_well_lie_elsewhere(heading):
    drawn = Drawn.of(RING, WIDTH, heading, darker=False)
    curve = path_from_last_end(drawn)
    assert sd_by_outline(others_of(drawn, curve), SETTINGS) > MOST_SD_PX


@pytest.mark.parametrize("cut_widths", [0.8, 1.5, 2.5])
@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0, 4.1])
def test_an_end_that_was_followed_short_is_found_where_it_comes_out(cut_widths, heading):
    drawn = Drawn.of(crossing(2.5), WIDTH, heading, darker=False)
    curve = path_from_last_end(drawn, cut_widths)
    found = likelier_end(others_of(drawn, curve), curve, WIDTH, SETTINGS)
    true = drawn.at(np.array([drawn.length]))[0]
    assert abs(curve[0] - true) > 0.7 * WIDTH
    assert abs(found[0] - true) < 0.35 * WIDTH
    assert abs(found[-1] - curve[-1]) < 1e-6, "the rest of it lies as it did"


def test_an_end_that_was_slid_to_within_a_third_of_a_width_stays_where_it_is():
    """Sliding finds it below a pixel; other ends are tried a quarter of a width apart."""
    drawn = Drawn.of(crossing(2.5), WIDTH, darker=False)
    curve = path_from_last_end(drawn, 0.33)
    assert likelier_end(others_of(drawn, curve), curve, WIDTH, SETTINGS) is None


@pytest.mark.parametrize("bend", [-0.8, 0.8])
def test_an_end_that_turned_aside_is_found_on_that_side(bend):
    straight, turned = [(20.0, 0.0)], [(17.5, 0.0), (2.5, bend)]
    drawn = Drawn.of(turned, WIDTH, darker=False)
    onwards = laid(straight, WIDTH)
    curve = evenly((onwards + drawn.curve[0] - onwards[0])[::-1], 120)
    found = likelier_end(others_of(drawn, curve), curve, WIDTH, SETTINGS)
    assert abs(curve[0] - drawn.curve[-1]) > WIDTH
    assert abs(found[0] - drawn.curve[-1]) < 0.35 * WIDTH


@given(heading=st.floats(0.0, 6.28), cut=st.floats(0.0, 2.0))
def test_a_mirrored_picture_has_the_ends_mirrored(heading, cut):
    drawn = Drawn.of(crossing(2.0), WIDTH, heading, darker=False)
    curve = path_from_last_end(drawn, cut)
    across = drawn.mask.shape[1] - 1
    one = others_of(drawn, curve)
    other = others_of(drawn, across - curve.conj(), drawn.mask[:, ::-1])
    assert other.told == pytest.approx(one.told, abs=0.02)
    by_bend = {(c, -b, length): x for c, b, length, x in shapes(other)}
    for cut_node, bend, length, left in shapes(one):
        assert by_bend[cut_node, bend, length] == pytest.approx(left, abs=0.05)


def shapes(others):
    return zip(others.cut, others.bend, others.length, others.unexplained, strict=True)


def test_an_end_as_long_as_the_body_is_not_laid_otherwise():
    """What is no longer than an end has no rest that could stay."""
    drawn = Drawn.of([(6.0, 0.0)], WIDTH)
    curve = evenly(path_from_last_end(drawn), 5)
    others = others_of(drawn, curve)
    assert likelier_end(others, curve, WIDTH, SETTINGS) is None
    assert sd_by_outline(others, SETTINGS) == np.inf


def test_an_end_beyond_the_picture_is_compared_with_no_worm():
    drawn = Drawn.of([(20.0, 0.0)], WIDTH, darker=False)
    curve = path_from_last_end(drawn)
    inside = others_of(drawn, curve)
    others = others_of(drawn, curve, drawn.mask[:, : int(curve[0].real - 2 * WIDTH)])
    assert np.isfinite(others.unexplained).all()
    sd, sd_inside = (sd_by_outline(each, SETTINGS) for each in (others, inside))
    assert sd > 2 * sd_inside
