"""An end of a body with marks is laid where its skin is seen, and doubted where it is not."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import path_along, search_in
from flank_ends import with_last_end_moved
from skinned_ends import DARKENING, LEVEL, WIDTH, body_in_skin, marks_along

from worm_tracker.midline.body_shade import BodyShade, ShadedObject
from worm_tracker.propagation.laid_by_skin import with_ends_by_skin

START, ASIDE = 1.0, 0.6
SURE, UNSURE = 0.1 * WIDTH, 0.8 * WIDTH


def marked_search(marks, pale=False, longer_widths=1.2, sd=UNSURE, known=1.0):
    """Return the search for a body in a skin with such marks, its last end moved; that body; truth.

    What is known of its skin is so much darker than it is.
    """
    line, widths, signal, mean = body_in_skin(START, ASIDE, marks)
    last = path_along(with_last_end_moved(line, WIDTH, longer_widths), WIDTH)
    search = search_in(signal, line, last, widths, LEVEL, DARKENING)
    shade = BodyShade(known * mean, np.zeros_like(mean), 50)
    shaded = ShadedObject(signal, shade, DARKENING)
    levels = LEVEL * marks if pale else search.model.levels
    model = replace(search.model, levels=levels, level=LEVEL)
    search = replace(search, seen=replace(search.seen, shaded=shaded), model=model)
    found = search.scored(last, model.widths)
    return search, replace(found, end_sd_px=(0.0, sd)), line


@pytest.mark.parametrize("longer_widths", [-1.5, 1.2])
def test_an_unsure_end_is_laid_where_its_skin_is_seen(longer_widths):
    search, found, line = marked_search(marks_along(4), longer_widths=longer_widths)
    anew = with_ends_by_skin(search, found)
    assert abs(found.path.curve[-1] - line[-1]) > 1.1 * WIDTH
    assert abs(anew.path.curve[-1] - line[-1]) < 0.5 * WIDTH
    assert anew.end_sd_px[1] < found.end_sd_px[1]


def test_a_pale_end_is_not_asked():
    """It adds so little to what it lies on that it would be led away."""
    search, found, _ = marked_search(marks_along(4, pale_end=0.5), pale=True)
    assert search.model.pale_ends[1]
    assert with_ends_by_skin(search, found) is found


def test_a_skin_is_read_from_whichever_end_is_asked():
    search, found, _ = marked_search(marks_along(4), pale=False)
    shade, model = search.seen.shaded.shade.turned_round(), search.model
    turned = replace(
        search,
        seen=replace(search.seen, shaded=replace(search.seen.shaded, shade=shade)),
        model=replace(model, widths=model.widths[::-1], levels=model.levels[::-1]),
    )
    other = replace(turned.scored(found.path.turned_round(), turned.model.widths))
    other = replace(other, end_sd_px=found.end_sd_px[::-1])
    one, back = with_ends_by_skin(search, found), with_ends_by_skin(turned, other)
    assert back.path.curve[::-1] == pytest.approx(one.path.curve)
    assert back.end_sd_px[::-1] == pytest.approx(one.end_sd_px)


@pytest.mark.parametrize("longer_widths", [-1.5, 1.2])
def test_an_end_that_was_thought_to_be_sure_is_laid_where_it_is_seen(longer_widths):
    search, found, line = marked_search(marks_along(4), longer_widths=longer_widths, sd=SURE)
    anew = with_ends_by_skin(search, found)
    assert abs(found.path.curve[-1] - line[-1]) > 1.1 * WIDTH
    assert abs(anew.path.curve[-1] - line[-1]) < 0.5 * WIDTH


def test_a_sure_end_that_is_seen_where_it_lies_stays():
    search, found, _ = marked_search(marks_along(4), longer_widths=0.0, sd=SURE)
    assert with_ends_by_skin(search, found) is found


@pytest.mark.parametrize("sd", [SURE, UNSURE])
def test_an_end_whose_skin_is_seen_nowhere_is_unsure(sd):
    search, found, _ = marked_search(marks_along(4), longer_widths=1.2, sd=sd, known=0.5)
    anew = with_ends_by_skin(search, found)
    assert anew.path is found.path
    assert anew.end_sd_px[1] >= WIDTH


def test_an_end_in_clear_water_is_not_asked():
    search, found, line = marked_search(marks_along(4), longer_widths=0.0, known=0.5)
    outside = search.scored(path_along(line[: len(line) // 2], WIDTH), search.model.widths)
    assert with_ends_by_skin(search, outside) is outside
    assert with_ends_by_skin(search, found) is not found


def test_where_overlaps_are_no_darker_or_nothing_is_marked_no_end_is_asked():
    search, found, _ = marked_search(marks_along(4))
    for seen in (replace(search.seen, dark=None), replace(search.seen, shaded=None)):
        assert with_ends_by_skin(replace(search, seen=seen), found) is found
