"""Each place of a skin has its own shade, so that what is seen tells which way it is passed."""

import numpy as np
import pytest
from drawn_folds import laid
from marked_skins import PLACES, drawn_along, marks_from, shaded

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import loops_otherwise
from worm_tracker.midline.strand_meetings import StrandExchangeSettings
from worm_tracker.midline.way_by_marks import MarksOnPath, WayByMarksSettings, marked_loops

WIDTH = 12.0
SETTINGS = WayByMarksSettings()
EXCHANGE = StrandExchangeSettings(most_apart_widths=1.0)
LOOP = [(8.0, 0.0), (1.5 * np.pi * 3.0, 1 / 3.0), (8.0, 0.0)]
UNCERTAIN = SETTINGS.least_log_odds
MARKS = marks_from(8)


def twisted():
    """Return a body whose legs cross each other twice before the loop that joins them."""
    x = np.linspace(0.0, 16.0, 200)
    leg = x + 1.3j * np.cos(2 * np.pi * x / 16)
    end = 1.3 / 3.0
    angle = np.linspace(np.pi - np.arcsin(end), -np.pi + np.arcsin(end), 120)
    loop = 16.0 + 3.0 * np.sqrt(1 - end**2) + 3.0 * np.exp(1j * angle)
    curve = WIDTH * np.r_[leg, loop[1:-1], leg[::-1].conj()]
    return evenly(curve, 700) + 6 * WIDTH * (1 + 1j)


def path_of_drawn(body):
    return BodyPath(evenly(body.curve, 240))


def marks_on(seen, path):
    return MarksOnPath.on(seen, path, np.full(len(path.curve), WIDTH), WIDTH, SETTINGS)


def loops_on(seen, path):
    return marked_loops(marks_on(seen, path), path, WIDTH, EXCHANGE, 0.85)


def test_marks_tell_that_a_loop_is_passed_as_it_lies_and_against_the_other_way_round():
    body = drawn_along(laid(LOOP, WIDTH), WIDTH)
    seen, path = shaded(body, MARKS, MARKS), path_of_drawn(body)
    (loop,) = loops_on(seen, path)
    assert loop.log_odds > 2 * UNCERTAIN
    (turned,) = loops_on(seen, loop.otherwise)
    assert turned.log_odds < -2 * UNCERTAIN


def test_marks_tell_which_end_of_a_body_is_which_and_the_opposite_of_it_turned_round():
    body = drawn_along(laid(LOOP, WIDTH), WIDTH)
    seen, path = shaded(body, MARKS, MARKS), path_of_drawn(body)
    odds = marks_on(seen, path).log_odds()
    assert odds > 2 * UNCERTAIN
    assert marks_on(seen, path.turned_round()).log_odds() == pytest.approx(-odds, rel=0.05)


@pytest.mark.parametrize(
    ("marks", "known"),
    [
        pytest.param(np.ones(PLACES), np.ones(PLACES), id="a skin without marks"),
        pytest.param(MARKS, np.ones(PLACES), id="marks that are not known"),
        pytest.param(MARKS + MARKS[::-1], MARKS + MARKS[::-1], id="marks alike from both ends"),
    ],
)
def test_what_agrees_with_neither_way_tells_none(marks, known):
    body = drawn_along(laid(LOOP, WIDTH), WIDTH)
    path = path_of_drawn(body)
    seen = shaded(body, marks, known)
    assert abs(marks_on(seen, path).log_odds()) < UNCERTAIN
    assert all(abs(loop.log_odds) < UNCERTAIN for loop in loops_on(seen, path))


def test_hardly_ever_does_another_skin_than_the_known_one_tell():
    body = drawn_along(laid(LOOP, WIDTH), WIDTH)
    path, told = path_of_drawn(body), []
    for seed in range(100, 130):
        seen = shaded(body, marks_from(seed), MARKS)
        (loop,) = loops_on(seen, path)
        told += [abs(marks_on(seen, path).log_odds()) > UNCERTAIN, abs(loop.log_odds) > UNCERTAIN]
    assert np.mean(told) < 0.1


def test_a_place_under_another_strand_tells_nothing():
    """The strands lie on each other all along, so that no place of the body is seen alone."""
    there = np.linspace(0.0, 20.0, 300) * WIDTH
    curve = np.r_[there, there[::-1] + 0.1j]
    path = BodyPath(evenly(curve + 6 * WIDTH * (1 + 1j), 240))
    seen = shaded(drawn_along(laid(LOOP, WIDTH), WIDTH), MARKS, MARKS)
    marks = marks_on(seen, path)
    near_the_bend = 3.0 / 40.0
    assert not marks.told[: round(240 * (0.5 - near_the_bend))].any()
    assert marks.log_odds(0.0, 0.5 - near_the_bend) == 0.0


def test_where_strands_cross_that_meet_twice_is_told_by_what_lies_between():
    """The loop beyond is passed alike, whichever of the two places they cross at."""
    body = drawn_along(twisted(), WIDTH)
    seen, path = shaded(body, MARKS, MARKS), path_of_drawn(body)
    assert all(loop.log_odds > UNCERTAIN for loop in loops_on(seen, path))
    outer, inner = sorted(
        loops_otherwise(path, WIDTH, EXCHANGE, 0.85), key=lambda each: each[0].first
    )[:2]
    assert outer[0].first < inner[0].first < inner[0].last < outer[0].last
    again = sorted(loops_otherwise(outer[1], WIDTH, EXCHANGE, 0.85), key=lambda each: each[0].first)
    swapped = again[1][1]
    by_marks = {loop.loop.last - loop.loop.first: loop.log_odds for loop in loops_on(seen, swapped)}
    assert by_marks[max(by_marks)] < -UNCERTAIN, "the strands are exchanged between the places"
    assert by_marks[min(by_marks)] > -UNCERTAIN, "the loop beyond is passed as it was"


def test_a_loop_is_laid_otherwise_between_its_strands_alone():
    body = drawn_along(laid(LOOP, WIDTH), WIDTH)
    path = path_of_drawn(body)
    ((loop, otherwise),) = loops_otherwise(path, WIDTH, EXCHANGE, 0.85)
    before, after = path.points, otherwise.points
    first, last = round(64 * loop.first), round(64 * loop.last)
    assert np.abs(before[: first - 1] - after[: first - 1]).max() < 0.5 * WIDTH
    assert np.abs(before[last + 2 :] - after[last + 2 :]).max() < 0.5 * WIDTH
    inside = slice(first + 4, last - 3)
    assert np.abs(before[inside][::-1] - after[inside]).max() < WIDTH
