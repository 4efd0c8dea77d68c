"""A bend that moves on along a body laid double is followed further than a slide takes it."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import search_after
from drawn_folds import DARKENING, LEVEL, Drawn, laid
from marked_skins import PLACES, shaded

from worm_tracker.midline.body_residual import ObjectMasks, dark_places
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.propagation.laid_anew import followed_body

WIDTH = 11.0
TIGHTEST = 1 / 0.3
"""Turn over a width: strands 0.6 widths apart lie on each other."""


def hairpin(moved_on_widths):
    """Return a body that turns back on itself, its bend so much further from its ends."""
    out, back = 14.0 + moved_on_widths, 18.0 + moved_on_widths
    return [(out, 0.0), (np.pi / TIGHTEST, TIGHTEST), (back, 0.0)]


def path_of(curve):
    length = float(abs(np.diff(curve)).sum())
    return BodyPath(evenly(curve, nodes_for(length, WIDTH)))


def search_in(drawn, last, darker=True):
    """Return the search for a body in its picture, from where it was said to lie."""
    search = search_after(path_of(drawn.curve), WIDTH, 1, loops_known=True)
    residual = search.settings.residual
    dark = dark_places(drawn.signal, LEVEL, DARKENING, residual) if darker else None
    model = replace(search.model, level=LEVEL, darkening=DARKENING if darker else 0.0)
    seen = ObjectMasks(drawn.mask, dark, WIDTH, residual)
    levels = np.full(65, LEVEL)
    return replace(search, signal=drawn.signal, seen=seen, levels=levels, model=model, last=last)


def followed(moved_on_widths, darker=True, **changes):
    """Return a hairpin, how it is searched for, and what is found from where its bend was."""
    drawn = Drawn.of(hairpin(moved_on_widths), WIDTH, darker=darker)
    at_start = drawn.curve[0] - laid(hairpin(0.0), WIDTH)[0]
    search = search_in(drawn, path_of(laid(hairpin(0.0), WIDTH) + at_start), darker)
    search = replace(search, settings=replace(search.settings, **changes))
    return drawn, search, followed_body(search)


def off_widths(drawn, found):
    """Return how far a body lies from the true one, widths, at the same part of the length."""
    true = np.array(evenly(drawn.curve, 200))
    return float(abs(evenly(found.path.curve, 200) - true).max()) / WIDTH


@pytest.mark.parametrize("moved_on_widths", [1.0, 2.0, 2.5])
def test_a_bend_that_moved_on_is_followed_to_where_it_is(moved_on_widths):
    drawn, search, found = followed(moved_on_widths)
    assert search.over_limits(found) <= 1
    assert off_widths(drawn, found) < 0.4


def test_a_single_slide_leaves_it_behind():
    drawn, search, found = followed(2.5, most_slides_again=0)
    assert search.over_limits(found) > search.settings.least_over_limits_slid_again
    assert off_widths(drawn, found) > 1


def test_where_overlaps_are_no_darker_a_body_is_slid_once():
    """One that is lost may lie along any strand there, and would be led on along it."""
    _, _, found = followed(2.5, darker=False)
    _, _, once = followed(2.5, darker=False, most_slides_again=0)
    assert np.array_equal(found.path.curve, once.path.curve)


def test_a_body_whose_skin_has_marks_is_slid_once():
    """Its marks are as dark as overlaps: in a photographed skin eight more frames were wrong."""
    drawn, search, _ = followed(2.5)
    marks = np.ones(PLACES)
    marked = replace(search, seen=replace(search.seen, shaded=shaded(drawn, marks, marks)))
    once = replace(marked, settings=replace(search.settings, most_slides_again=0))
    assert np.array_equal(followed_body(marked).path.curve, followed_body(once).path.curve)


def test_how_the_ends_went_is_kept():
    drawn = Drawn.of(hairpin(2.5), WIDTH)
    start = drawn.curve[0] - laid(hairpin(0.0), WIDTH)[0]
    last = replace(path_of(laid(hairpin(0.0), WIDTH) + start), ways=(1.0, -0.5))
    search = search_in(drawn, last)
    once = replace(search, settings=replace(search.settings, most_slides_again=0))
    assert followed_body(search).path.ways == followed_body(once).path.ways
