"""A bend that moves on along a body laid double is followed further than a slide takes it.

And an end is laid otherwise only where grey levels do not show that it lies as it did.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from body_searches import path_along, search_in
from drawn_folds import DARKENING, LEVEL, Drawn, laid
from marked_skins import PLACES, shaded

from worm_tracker.midline.path import evenly
from worm_tracker.propagation import laid_anew
from worm_tracker.propagation.laid_anew import followed_body

WIDTH = 11.0
TIGHTEST = 1 / 0.3
"""Turn over a width: strands 0.6 widths apart lie on each other."""


def hairpin(moved_on_widths):
    """Return a body that turns back on itself, its bend so much further from its ends."""
    out, back = 14.0 + moved_on_widths, 18.0 + moved_on_widths
    return [(out, 0.0), (np.pi / TIGHTEST, TIGHTEST), (back, 0.0)]


def searched(moved_on_widths, darker=True, ways=(0.0, 0.0), **changes):
    """Return a drawn hairpin, and the search for it from where its bend was."""
    drawn = Drawn.of(hairpin(moved_on_widths), WIDTH, darker=darker)
    last = replace(path_along(drawn.curve[0] + laid(hairpin(0.0), WIDTH), WIDTH), ways=ways)
    widths = np.full(65, WIDTH)
    search = search_in(drawn.signal, drawn.curve, last, widths, LEVEL, DARKENING, darker)
    return drawn, replace(search, settings=replace(search.settings, **changes))


def off_widths(drawn, found):
    """Return how far a body lies from the true one, widths, at the same part of the length."""
    return abs(evenly(found.path.curve, 200) - evenly(drawn.curve, 200)).max() / WIDTH


@pytest.mark.parametrize("moved_on_widths", [2.0, 2.5])
def test_a_bend_that_moved_on_is_followed_to_where_it_is(moved_on_widths):
    drawn, search = searched(moved_on_widths)
    found = followed_body(search)
    assert search.over_limits(found) <= 1
    assert off_widths(drawn, found) < 0.4


def test_a_single_slide_leaves_it_behind():
    drawn, search = searched(2.5, most_slides_again=0)
    found = followed_body(search)
    assert search.over_limits(found) > search.settings.least_over_limits_slid_again
    assert off_widths(drawn, found) > 1


def slides_again(search):
    """Tell whether a body is another one by sliding it more than once."""
    once = replace(search, settings=replace(search.settings, most_slides_again=0))
    return not np.array_equal(followed_body(search).path.curve, followed_body(once).path.curve)


def test_where_overlaps_are_no_darker_a_body_is_slid_once():
    """One that is lost may lie along any strand there, and would be led on along it."""
    assert slides_again(searched(2.5)[1])
    assert not slides_again(searched(2.5, darker=False)[1])


@pytest.mark.parametrize(
    ("moved_on_widths", "again"),
    [pytest.param(1.75, False, id="by little"), pytest.param(2.5, True, id="by much")],
)
def test_a_body_whose_skin_has_marks_is_slid_again_where_it_leaves_much_over(
    moved_on_widths, again
):
    """Its marks are as dark as overlaps: in a photographed skin eight more frames were wrong."""
    drawn, search = searched(moved_on_widths)
    marks = np.ones(PLACES)
    marked = replace(search, seen=replace(search.seen, shaded=shaded(drawn, marks, marks)))
    assert slides_again(search)
    assert slides_again(marked) is again


def test_how_the_ends_went_is_kept():
    """It foretells where they lie in the next picture."""
    ways = [
        followed_body(searched(2.5, ways=(1.0, -0.5), most_slides_again=most)[1]).path.ways
        for most in (0, 4)
    ]
    assert ways[0] == ways[1]


def beside_itself(apart_widths, hooked):
    """Return a body whose last end lies beside its own strand, or, hooked, is bent onto it."""
    arcs = [(14.0, 0.0), (np.pi * apart_widths / 2, 2 / apart_widths), (6.0, 0.0)]
    straight = Drawn.of(arcs, WIDTH, heading=0.3, darker=False).curve
    beside = straight[:200][abs(straight[:200] - straight[-1]).argmin()]
    bent = np.concatenate([straight[:-12], np.linspace(straight[-12], beside, 12)[1:]])
    drawn = Drawn(bent if hooked else straight, WIDTH, darker=False)
    return drawn, path_along(straight, WIDTH), path_along(bent, WIDTH)


@pytest.mark.parametrize("apart_widths", [1.2, 1.25])
@pytest.mark.parametrize(
    ("hooked", "known_over_level", "is_laid_across"),
    [
        pytest.param(False, 1.0, False, id="the gap is seen"),
        pytest.param(True, 1.0, True, id="the end is seen across"),
        pytest.param(False, 1.6, True, id="the picture looks like neither"),
    ],
)
def test_an_end_is_not_laid_across_a_gap_that_is_seen(
    monkeypatch, apart_widths, hooked, known_over_level, is_laid_across
):
    """An outline that closes the gap is explained as well by either: the grey levels tell."""
    drawn, straight, bent = beside_itself(apart_widths, hooked)
    widths = np.full(65, WIDTH)
    search = search_in(drawn.signal, drawn.curve, straight, widths, LEVEL, 0.0, darker=False)
    closed = cv2.morphologyEx(search.seen.mask, cv2.MORPH_CLOSE, np.ones((9, 9), np.uint8))
    near = replace(search.settings, near_end_widths=1.6)
    levels = known_over_level * search.levels
    seen = replace(search.seen, mask=closed)
    search = replace(search, seen=seen, settings=near, levels=levels)
    monkeypatch.setattr(laid_anew, "likelier_end", lambda *_: bent.curve[::-1])
    as_it_was = search.scored(straight, widths)
    found = laid_anew._with_likelier_ends(search, as_it_was)
    assert (found is not as_it_was) is is_laid_across
    assert search.over_limits(search.scored(bent, widths)) <= 1
