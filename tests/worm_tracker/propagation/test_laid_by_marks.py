"""A body that was lost, or whose loop is in doubt, passes its loops as its marks say."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import candidate, search_after
from drawn_folds import laid
from marked_skins import drawn_along, marks_from, shaded

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import loops_otherwise
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.laid_by_marks import with_loops_by_marks

WIDTH = 12.0
LOOP = [(8.0, 0.0), (1.5 * np.pi * 3.0, 1 / 3.0), (8.0, 0.0)]
MARKS = marks_from(8)
BODY = drawn_along(laid(LOOP, WIDTH), WIDTH)
PATH = BodyPath(evenly(BODY.curve, 240))


def search_with(marks, **body):
    """Return the search for a body with a skin in a picture of one with such marks."""
    search = search_after(PATH, WIDTH, 1, loops_known=True)
    seen = replace(search.seen, shaded=shaded(BODY, marks, MARKS))
    return replace(search, seen=seen, body=replace(search.body, **body))


def turned_path(search):
    ((_, otherwise),) = loops_otherwise(PATH, WIDTH, search.settings.doubt, 0.85)
    return otherwise


def laid_anew(monkeypatch, search, found, left_over_widths2=0.0):
    """Return what is found where a body slides without a change, leaving so much over."""
    monkeypatch.setattr(CandidateSearch, "slid", lambda _, path: candidate(path, left_over_widths2))
    return with_loops_by_marks(search, found)


DOUBTS = [
    pytest.param({"doubt_by_bends": (0.3, 0.7)}, id="a loop in doubt"),
    pytest.param({"frames_unexplained": 3}, id="lost before"),
    pytest.param({"was_turned": True}, id="turned round before"),
]


@pytest.mark.parametrize("body", DOUBTS)
def test_a_loop_that_is_passed_against_its_marks_is_turned_round(monkeypatch, body):
    search = search_with(MARKS, **body)
    told = laid_anew(monkeypatch, search, candidate(turned_path(search)))
    assert told.was_exchanged
    assert np.abs(told.path.points - PATH.points).max() < WIDTH


@pytest.mark.parametrize("body", DOUBTS)
def test_a_loop_that_is_passed_as_its_marks_say_stays(monkeypatch, body):
    found = candidate(PATH)
    assert laid_anew(monkeypatch, search_with(MARKS, **body), found) is found


@pytest.mark.parametrize(
    ("marks", "body", "left_over_widths2"),
    [
        pytest.param(MARKS, {}, 0.0, id="nothing is in doubt"),
        pytest.param(np.ones(65), {"was_turned": True}, 0.0, id="no marks are seen"),
        pytest.param(marks_from(9), {"was_turned": True}, 0.0, id="other marks are seen"),
        pytest.param(MARKS, {"was_turned": True}, 0.1, id="more is left over then"),
    ],
)
def test_a_loop_is_not_turned_round_where_marks_do_not_tell(
    monkeypatch, marks, body, left_over_widths2
):
    search = search_with(marks, **body)
    found = candidate(turned_path(search))
    assert laid_anew(monkeypatch, search, found, left_over_widths2) is found


def test_marks_tell_of_a_loop_in_doubt_in_their_own_picture_only():
    """What the next picture's bends leave in doubt is in doubt there."""
    search = search_with(MARKS, was_turned=True)
    told = search.in_picture(candidate(PATH))
    assert told.loops_known
    assert told.doubt_by_bends is not None
    unmarked = replace(search, seen=replace(search.seen, shaded=None), body=told)
    assert not unmarked.in_picture(candidate(PATH)).loops_known


@pytest.mark.parametrize(("turned", "sign"), [(False, 1.0), (True, -1.0)])
def test_marks_tell_which_end_of_a_body_is_which_where_its_widths_do_not(turned, sign):
    path = PATH.turned_round() if turned else PATH
    search = search_with(MARKS)
    assert search.order_score(candidate(path)) == sign
    found = search.turned_round(candidate(path))
    assert np.abs(found.path.points - PATH.points).max() < 0.1 * WIDTH
    assert found.turned_round is False, "so it lay in the picture before, too"
