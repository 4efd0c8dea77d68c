"""An end told too short or too long on its own flank is laid where the picture shows it."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import path_along, search_in
from flank_ends import DARKENING, LEVEL, along_itself, signal_of, with_last_end_moved

from worm_tracker.propagation.laid_by_signal import with_ends_by_signal

WIDTH = 14.0
START, ASIDE = 1.0, 0.6
LINE, WIDTHS = along_itself(WIDTH, START, ASIDE)


def path_of(line):
    return path_along(line, WIDTH)


def search_from(path, darker=True):
    """Return the search for the body, from where it was said to lie."""
    signal = signal_of(LINE, WIDTHS)
    return search_in(signal, LINE, path, WIDTHS, LEVEL, DARKENING, darker)


def off_widths(found):
    return abs(found.path.curve[-1] - LINE[-1]) / WIDTH


@pytest.mark.parametrize("longer_widths", [-1.2, 1.2, 1.5])
def test_an_end_told_too_short_or_too_long_is_laid_where_it_is_seen(longer_widths):
    path = path_of(with_last_end_moved(LINE, WIDTH, longer_widths))
    search = search_from(path)
    found = search.scored(path, search.model.widths)
    assert off_widths(found) > 1.1
    anew = with_ends_by_signal(search, found)
    assert off_widths(anew) < 0.6
    # The other end stays, but for the round half of a width that is drawn beyond it.
    assert abs(anew.path.curve[0] - LINE[0]) < 0.6 * WIDTH


def test_a_body_whose_end_is_moved_stays_one_whose_strands_were_exchanged():
    """What is between them may be passed the other way: its loops are not known by that."""
    path = path_of(with_last_end_moved(LINE, WIDTH, 1.5))
    search = search_from(path)
    found = search.scored(path, search.model.widths)
    found = replace(found, was_exchanged=True, straighter=0.3)
    anew = with_ends_by_signal(search, found)
    assert anew is not found
    assert anew.was_exchanged
    assert anew.straighter == 0.3


def test_an_end_that_lies_where_it_is_seen_stays():
    path = path_of(LINE)
    search = search_from(path)
    found = search.scored(path, search.model.widths)
    assert with_ends_by_signal(search, found) is found


def test_where_overlaps_are_no_darker_nothing_is_moved():
    path = path_of(with_last_end_moved(LINE, WIDTH, -2.0))
    search = search_from(path, darker=False)
    found = search.scored(path, search.model.widths)
    assert with_ends_by_signal(search, found) is found


def test_an_end_on_the_body_that_is_not_explained_is_told_as_hidden():
    path = path_of(with_last_end_moved(LINE, WIDTH, -2.0))
    search = search_from(path)
    told = search.in_picture(search.scored(path, search.model.widths))
    assert told.end_sd_px[1] >= WIDTH


def told_unsurely(longer_widths=0.0, pale=False):
    """Return the search, and the body with its last end so far on, of which little is known."""
    path = path_of(with_last_end_moved(LINE, WIDTH, longer_widths))
    search = search_from(path)
    levels = search.model.levels.copy()
    if pale:
        levels[-12:] *= 0.4
    search = replace(search, model=replace(search.model, levels=levels))
    found = replace(search.scored(path, search.model.widths), end_sd_px=(0.0, WIDTH))
    return search, found


def test_an_end_hardly_known_is_told_as_surely_as_the_picture_about_it_tells():
    search, found = told_unsurely()
    anew = with_ends_by_signal(search, found)
    assert off_widths(anew) < 0.5
    assert anew.end_sd_px[1] < 0.42 * WIDTH
    assert anew.end_sd_px[0] == 0.0, "the other one stays as sure"


@pytest.mark.parametrize("longer_widths", [-0.9, 0.9])
def test_an_end_hardly_known_is_moved_where_it_is_seen_though_little_is_left_over(longer_widths):
    search, found = told_unsurely(longer_widths)
    anew = with_ends_by_signal(search, replace(found, was_exchanged=True, straighter=0.3))
    assert off_widths(found) > 0.8
    assert off_widths(anew) < 0.5
    assert anew.was_exchanged
    assert anew.straighter == 0.3


def test_a_pale_end_is_not_asked_as_it_would_be_drawn_too_dark():
    search, found = told_unsurely(pale=True)
    assert search.model.pale_ends == (False, True)
    assert with_ends_by_signal(search, found).end_sd_px == found.end_sd_px


def test_an_end_that_is_sure_is_not_asked():
    search, found = told_unsurely()
    sure, unsure = (replace(found, end_sd_px=(0.0, sd * WIDTH)) for sd in (0.29, 0.31))
    assert with_ends_by_signal(search, sure) is sure
    assert with_ends_by_signal(search, unsure).end_sd_px[1] < 0.29 * WIDTH


def test_an_end_beside_the_other_one_is_not_asked():
    """Either may be taken for the other: a head and a tail side by side were exchanged."""
    search, found = told_unsurely()
    apart_widths = abs(found.path.curve[0] - found.path.curve[-1]) / WIDTH
    settings, known = search.settings, found.end_sd_px
    compared = settings.by_signal.compared
    fits = replace(compared.likeliest, most_cost=np.inf, most_cost_moved=np.inf)
    for more, is_asked in ((-0.1, True), (0.1, False)):
        reach = replace(compared, reach_widths=apart_widths + more, likeliest=fits)
        by_signal = replace(settings.by_signal, compared=reach)
        near = replace(search, settings=replace(settings, by_signal=by_signal))
        assert (with_ends_by_signal(near, found).end_sd_px != known) == is_asked


@pytest.mark.parametrize("longer_widths", [0.0, -1.2, 1.2])
def test_an_end_of_a_skin_with_marks_is_not_asked_of_grey_levels(longer_widths):
    """Marks look like what is darker or paler beside an end: other rules ask them themselves."""
    search, found = told_unsurely(longer_widths)
    assert with_ends_by_signal(search, found) is not found
    levels = search.model.levels * (1 + 0.1 * (-1.0) ** np.arange(len(search.model.levels)))
    marked = replace(search, model=replace(search.model, levels=levels))
    assert marked.model.is_marked
    assert with_ends_by_signal(marked, found) is found


def test_a_picture_that_tells_nothing_leaves_an_end_as_sure_as_it_was_followed():
    search, found = told_unsurely()
    found = replace(found, end_sd_px=(0.0, 0.31 * WIDTH))
    height, across = search.signal.shape
    checks = 1 + 0.4 * np.kron(np.indices((20, 20)).sum(axis=0) % 2 - 0.5, np.ones((9, 9)))
    patchy = (search.signal * checks[:height, :across]).clip(0, 255).astype(np.uint8)
    anew = with_ends_by_signal(replace(search, signal=patchy), found)
    assert anew.end_sd_px == found.end_sd_px
