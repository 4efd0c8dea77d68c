"""A body whose loop covers the picture better the other way is laid so; no other one is."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import candidate, search_after
from drawn_by_discs import drawn_by_discs, finely
from drawn_folds import laid

from worm_tracker.midline.body_residual import ObjectMasks
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import loops_otherwise
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.laid_by_widths import with_loop_by_widths

WIDTH = 12.0
LOOP = laid([(6.0, 0.0), (1.5 * np.pi * 3.0, 1 / 3.0), (4.5, 0.0)], WIDTH)
PATH = BodyPath(evenly(LOOP - complex(LOOP.real.min(), LOOP.imag.min()) + 40 + 40j, 240))
TAPERING = WIDTH * np.interp(np.linspace(0, 1, 65), [0.0, 0.6, 1.0], [1.0, 1.0, 0.3])


def search_in(widths):
    """Return the search for a body of some widths in its picture."""
    search = search_after(PATH, WIDTH, 1, loops_known=True)
    points = as_points(PATH.curve)
    mask = drawn_by_discs((260, 260), points, finely(widths, len(points)))
    seen = ObjectMasks(mask, None, WIDTH, search.settings.residual)
    return replace(search, seen=seen, model=replace(search.model, widths=widths))


def turned(search):
    ((_, otherwise),) = loops_otherwise(PATH, WIDTH, search.settings.doubt, 0.85)
    return otherwise


def laid_anew(monkeypatch, search, found, left_over_widths2=0.0):
    """Return what is found where a body slides without a change, leaving so much over."""
    monkeypatch.setattr(CandidateSearch, "slid", lambda _, path: candidate(path, left_over_widths2))
    return with_loop_by_widths(search, found)


def test_a_loop_that_is_passed_against_its_widths_is_turned_round(monkeypatch):
    search = search_in(TAPERING)
    told = laid_anew(monkeypatch, search, candidate(turned(search)))
    assert told.was_exchanged
    assert np.abs(told.path.points - PATH.points).max() < WIDTH


def test_a_loop_that_is_passed_as_its_widths_say_stays(monkeypatch):
    found = candidate(PATH)
    assert laid_anew(monkeypatch, search_in(TAPERING), found) is found


def test_a_body_that_does_not_explain_its_picture_lies_elsewhere_and_is_left(monkeypatch):
    search = search_in(TAPERING)
    found = candidate(turned(search), left_over_widths2=0.5)
    assert laid_anew(monkeypatch, search, found) is found


@pytest.mark.parametrize(
    ("widths", "left_over_widths2"),
    [
        pytest.param(np.full(65, WIDTH), 0.0, id="a body of one width"),
        pytest.param(TAPERING, 0.5, id="something is left over then"),
    ],
)
def test_a_loop_is_not_turned_round_where_widths_do_not_tell(
    monkeypatch, widths, left_over_widths2
):
    search = search_in(widths)
    found = candidate(turned(search))
    assert laid_anew(monkeypatch, search, found, left_over_widths2) is found
