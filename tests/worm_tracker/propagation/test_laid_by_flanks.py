"""Of one shade an end told wrong on the body is laid where the outline shows it."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import path_along, search_in
from drawn_folds import DARKENING, LEVEL, Drawn, rounded_widths

from worm_tracker.propagation.laid_by_flanks import with_ends_by_flanks

WIDTH = 14.0
COMES_OUT = [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (3.4, 0.0)]
"""A body whose last end crosses its own strand and ends little beyond it."""
STAYS_CLEAR = [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (0.1, 0.0)]
"""A body whose last end heads for its own strand, and ends before that."""
RING = [(2 * np.pi * 3.0 - 0.3, 1 / 3.0)]
"""A body that goes round until its ends meet."""
SEEN_PX = (2.0, 8.0)
"""How surely the ends were followed: the last one, on the body, hardly."""


def search_of(arcs, last_widths=0.0, darker=False):
    """Return the search for a body told so much shorter or longer at its last end, and it there."""
    drawn = Drawn.of(arcs, WIDTH, darker=darker)
    true = drawn.at(np.linspace(0.0, drawn.length, 800))
    told = drawn.at(np.linspace(0.0, drawn.length + last_widths * WIDTH, 800))
    widths = rounded_widths(np.linspace(0.0, drawn.length, 65), WIDTH)
    path = path_along(told, WIDTH)
    search = search_in(drawn.signal, true, path, widths, LEVEL, DARKENING, darker)
    found = replace(search.scored(path, search.model.widths), end_sd_px=SEEN_PX)
    return search, found, true


@pytest.mark.parametrize("longer_widths", [-1.5, -1.2, -1.0])
def test_an_end_told_too_short_is_laid_where_it_is_seen(longer_widths):
    search, found, true = search_of(COMES_OUT, longer_widths)
    anew = with_ends_by_flanks(search, found)
    assert abs(found.path.curve[-1] - true[-1]) > 0.99 * WIDTH
    assert abs(anew.path.curve[-1] - true[-1]) < 0.3 * WIDTH
    assert abs(anew.path.curve[0] - found.path.curve[0]) < 1e-6
    assert anew.flanks_sd_px[0] == np.inf, "it lies by itself: that is not asked"
    assert anew.flanks_sd_px[1] < 0.35 * WIDTH
    assert anew.end_sd_px[0] == SEEN_PX[0]
    assert anew.end_sd_px[1] < SEEN_PX[1], "it is followed as surely as it is seen there"


def test_an_end_that_would_come_clear_of_the_body_is_left_to_other_means():
    """A fold was told as an open worm of 0.8 of its length, its end at the hairpin's bend."""
    search, found, true = search_of(STAYS_CLEAR, 1.4)
    assert abs(found.path.curve[-1] - true[-1]) > 1.1 * WIDTH
    anew = with_ends_by_flanks(search, found)
    assert anew.path is found.path
    assert anew.flanks_sd_px == (np.inf, np.inf)


def test_where_overlaps_are_darker_they_tell_more():
    search, found, _ = search_of(COMES_OUT, -1.2, darker=True)
    assert with_ends_by_flanks(search, found) is found


def test_an_end_beside_the_other_one_is_not_asked():
    """What is seen of one may be the other."""
    search, found, _ = search_of(RING)
    anew = with_ends_by_flanks(search, found)
    assert anew.flanks_sd_px == (np.inf, np.inf)
    assert anew.end_sd_px == SEEN_PX
    assert anew.path is found.path
