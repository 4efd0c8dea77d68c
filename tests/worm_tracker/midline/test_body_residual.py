"""A true body leaves nothing unexplained; a false one leaves as much as it is false."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_folds import BENDS, DARKENING, HEADINGS, LEVEL, WIDTHS, Drawn, as_rows, loops
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_erosion, binary_opening, distance_transform_edt, label

from worm_tracker.midline.body_residual import (
    BodyResidualSettings,
    ObjectMasks,
    dark_places,
    px2_near,
    unexplained,
)
from worm_tracker.midline.strand_drawing import drawn_strands

SETTINGS = BodyResidualSettings()
STRAIGHT = [(10.0, 0.0)]
ROUND_TO_ITSELF = [(4.0, 0.0), (7.5, 0.6)]
"""A loop that leads back to just before the body's own flank."""
ACROSS, ON_TOP, SHORT_OF_ITSELF = 5.0, 2.6, 1.0
"""Widths from there: right across, to a tip that lies within the flank, to a tip in the loop."""


def round_and_on(widths, width, **look):
    return Drawn.of([*ROUND_TO_ITSELF, (widths, 0.0)], width, 0.3, **look)


def compared(drawn, points, widths, by_darkness=True):
    """Return what a body leaves of a picture."""
    dark = dark_places(drawn.signal, LEVEL, DARKENING, SETTINGS) if by_darkness else None
    seen = ObjectMasks(drawn.mask, dark, drawn.width, SETTINGS)
    return unexplained(seen, points, widths)


def rim_widths(width):
    return max(SETTINGS.rim_widths, SETTINGS.least_rim_px / width)


def tolerance(width):
    """Return what rim and rounding to pixels take off a length, or add to it, in widths."""
    return rim_widths(width) + 2.75 / width


@given(arcs=BENDS | loops(), width=WIDTHS, heading=HEADINGS, darker=st.booleans())
@settings(max_examples=40)
def test_a_true_body_leaves_nothing_whatever_its_bends_and_crossings(arcs, width, heading, darker):
    drawn = Drawn.of(arcs, width, heading, darker=darker, noise=2.0)
    found = compared(drawn, *drawn.claimed(), by_darkness=darker)
    assert found.total == 0.0
    # The body's outline is drawn through whole pixels, half of one more at either side, and the
    # picture's is blurred and noisy: as much again.
    assert found.agreement > 1 / (1 + 2.25 / width)


@given(arcs=BENDS, width=WIDTHS, heading=HEADINGS, missing=st.floats(0.8, 3.0))
@settings(max_examples=25)
def test_of_a_body_cut_short_its_end_is_left_over(arcs, width, heading, missing):
    """By as much as it was cut: both ends are half circles of one radius."""
    drawn = Drawn.of(arcs, width, heading)
    points, widths = drawn.claimed(last_widths=missing)
    assume(drawn.layers.max() < 1.5)
    assume(abs(drawn.curve[0] - drawn.curve[-1]) > (missing + 2.0) * width)
    found = compared(drawn, points, widths)
    assert found.left_over == pytest.approx(missing, abs=tolerance(width))
    assert found.in_water == found.overlap == 0.0
    assert found.wants_near(points[-1:], width)
    assert not found.wants_near(points[:1], width)


@given(bend=st.floats(-0.2, 0.2), width=WIDTHS, heading=HEADINGS, beyond=st.floats(0.8, 3.0))
@settings(max_examples=25)
def test_of_a_body_too_long_its_end_is_in_the_water(bend, width, heading, beyond):
    """By as much as it is too long, and half a pixel at either side: whole pixels are drawn."""
    drawn = Drawn.of([(10.0, bend)], width, heading)
    for ends in ({"first_widths": -beyond}, {"last_widths": -beyond}):
        found = compared(drawn, *drawn.claimed(**ends))
        drawn_too_long = beyond * (1 + 1 / width)
        assert found.in_water == pytest.approx(drawn_too_long, abs=tolerance(width))
        assert found.left_over == found.overlap == 0.0
        assert not found.wants_near(drawn.claimed()[0], drawn.width)


@given(width=WIDTHS, aside=st.floats(0.0, 0.8))
@settings(max_examples=25)
def test_the_agreement_is_the_intersection_over_the_union(width, aside):
    """Two strips of one width, one of them aside by d widths, share (1 - d) / (1 + d) of all."""
    drawn = Drawn.of(STRAIGHT, width)
    points, widths = drawn.claimed()
    found = compared(drawn, points + np.array([0.0, aside * width]), widths)
    assert found.agreement == pytest.approx((1 - aside) / (1 + aside), abs=2.0 / width)


@pytest.mark.parametrize("width", [8.0, 12.0, 16.0])
def test_a_dark_crossing_under_one_strand_is_told_by_its_darkness_alone(width):
    """The tip lies within its own flank: the outline is that of a body without it."""
    drawn = round_and_on(ON_TOP, width)
    points, widths = drawn.claimed(last_widths=ON_TOP - SHORT_OF_ITSELF)
    assert compared(drawn, *drawn.claimed()).total == 0.0
    found = compared(drawn, points, widths)
    assert found.overlap > 0.5 * (1 - 2 * rim_widths(width)) ** 2  # of a square of one width
    assert found.in_water == 0.0
    blind = compared(drawn, points, widths, by_darkness=False)
    assert blind.overlap == 0.0
    dark = found.wanted & ~blind.wanted
    v, u = np.nonzero(dark)
    assert len(u) > 0.5 * width**2
    assert (drawn.layers[v, u] > 1.2).all()


@pytest.mark.parametrize("width", [8.0, 12.0, 16.0])
def test_two_strands_where_it_is_not_dark_are_told(width):
    """A tip that stops at its own flank is not one that lies on it."""
    drawn = round_and_on(SHORT_OF_ITSELF, width)
    points, widths = drawn.claimed(last_widths=SHORT_OF_ITSELF - ON_TOP)
    assert compared(drawn, *drawn.claimed()).total == 0.0
    assert compared(drawn, points, widths).overlap > 0.2
    assert compared(drawn, points, widths, by_darkness=False).overlap == 0.0


@pytest.mark.parametrize("width", [14.0, 16.0, 20.0])
@pytest.mark.parametrize("darker", [True, False])
@pytest.mark.parametrize(("arm", "is_told"), [(1.5, False), (7.0, True)])
def test_strands_that_lie_beside_each_other_at_a_hairpin_may_be_dark_or_not(
    arm, is_told, darker, width
):
    """Farther along they lie on each other: where that is not dark the body is another one."""
    apart = 0.3
    turn = (0.5 * np.pi * apart, 2 / apart)
    drawn = Drawn.of([(arm, 0.0), turn, (arm, 0.0)], width, 0.4, darker=darker)
    found = compared(drawn, *drawn.claimed())
    assert (found.overlap > SETTINGS.most_overlap) == (is_told and not darker)


@given(arcs=BENDS | loops(), width=WIDTHS, heading=HEADINGS)
@settings(max_examples=25)
def test_strands_are_drawn_where_the_renderer_has_them(arcs, width, heading):
    drawn = Drawn.of(arcs, width, heading)
    points, widths = drawn.claimed()
    body, twice, *_ = drawn_strands(drawn.mask.shape, points, widths, width, SETTINGS.drawing)
    assert body[far_from(drawn.layers < 0.9, 1.0)].all()
    assert not body[far_from(drawn.layers > 0.1)].any()
    assert twice[far_from(drawn.layers < 1.9)].all()
    # Strands that only touch may share the pixels between them.
    assert not binary_erosion(twice)[far_from(drawn.layers > 1.1)].any()


def far_from(places, pixels=2.0):
    """Return the pixels that are farther from all of some places than that."""
    return distance_transform_edt(~places) > pixels


@given(arcs=loops(), width=WIDTHS)
@settings(max_examples=15)
def test_dark_places_are_those_of_two_layers(arcs, width):
    drawn = Drawn.of(arcs, width)
    dark = dark_places(drawn.signal, LEVEL, DARKENING, SETTINGS)
    assert dark[far_from(drawn.layers < 1.9)].all()
    assert not dark[far_from(drawn.layers > 1.1)].any()


def test_a_body_beyond_the_window_is_in_no_water_that_is_seen():
    drawn = Drawn.of(STRAIGHT, 10.0)
    points, widths = drawn.claimed()
    found = compared(drawn, points + np.array([1000.0, 0.0]), widths)
    assert found.in_water == 0.0
    assert found.agreement == 0.0
    assert found.left_over == pytest.approx(drawn.area / 100.0, rel=0.15)  # less a row of pixels
    assert as_rows(drawn.curve).min() > 0


@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.05, 0.6), grain=st.integers(1, 4))
@settings(max_examples=30)
def test_of_what_is_left_over_the_largest_piece_counts(seed, share, grain):
    """Pieces touch by their corners, too, and one may lie within another."""
    coarse = np.random.default_rng(seed).random((40, 40)) < share
    mask = np.zeros((200, 200), np.uint8)
    spots = np.kron(coarse, np.ones((grain, grain))) > 0
    mask[20 : 20 + len(spots), 20 : 20 + len(spots)][spots] = 255
    afar = np.stack([np.linspace(190.0, 197.0, 9), np.full(9, 195.0)], axis=1)
    found = unexplained(ObjectMasks(mask, None, 4.0, SETTINGS), afar, np.full(9, 2.0))
    specks_gone = binary_opening(mask > 0, np.ones((2, 2)))
    labels, _ = label(specks_gone, np.ones((3, 3)))
    largest = np.bincount(labels.ravel())[1:].max(initial=0)
    assert found.left_over == largest / 4.0**2


@given(width=st.floats(9.0, 20.0), heading=HEADINGS, darker=st.booleans())
@settings(max_examples=20, deadline=None)
def test_beside_an_end_that_is_bent_back_the_object_is_broader_than_a_body_that_ends_there(
    width, heading, darker
):
    """One that knows of the bend has nothing beside it."""
    bent = Drawn.of([(10.0, 0.0), (0.9, 3.5), (1.5, 0.0)], width, heading, darker=darker)
    points, widths = bent.claimed()
    cut = points[: round(10.45 / 12.4 * len(points))]
    reach = 2 * width
    known = px2_near(compared(bent, points, widths).beside, points[-1], reach)
    ends_there = px2_near(compared(bent, cut, widths[: len(cut)]).beside, cut[-1], reach)
    assert known < 0.15 * width**2
    assert ends_there > 0.3 * width**2


@given(width=st.floats(9.0, 20.0), heading=HEADINGS)
@settings(max_examples=20, deadline=None)
def test_dirt_on_a_body_is_nothing_that_it_leaves_over(width, heading):
    """A speck half on the body, and as dark as an overlap."""
    drawn = Drawn.of(STRAIGHT, width, heading)
    points, widths = drawn.claimed()
    at = points[len(points) // 2] + 0.6 * width * np.array([-np.sin(heading), np.cos(heading)])
    rows, columns = np.indices(drawn.mask.shape)
    speck = np.where(np.hypot(columns - at[0], rows - at[1]) < 0.7 * width, 255, 0).astype(np.uint8)
    seen = ObjectMasks(drawn.mask | speck, speck, width, SETTINGS)
    assert unexplained(seen, points, widths).over_limits(width, SETTINGS) > 1
    assert unexplained(replace(seen, dirt=speck), points, widths).total == 0
