"""An end is found where the picture tells it, and is as unsure as the picture leaves it."""

from math import hypot

import numpy as np
import pytest
from drawn_folds import DARKENING, HEADINGS, LEVEL, NODES_PER_WIDTH, WIDTHS, Drawn
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.midline.body_ends import BodyEnd, BodyEndsSettings, find_ends
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.path_following import (
    ExpectedBody,
    PathFollowingSettings,
    slide_along_path,
)

SETTINGS = BodyEndsSettings()
WIDTH, STEP = 10.0, 2.0
BEYOND, LENGTH = 4 * WIDTH, 15 * WIDTH
NODES = int((2 * BEYOND + LENGTH) / STEP) + 1
LENGTH_SD = 0.04 * LENGTH


def seen(first, last, hidden=(), odds=5.0):
    """Return the odds along a path of a body between two places; none where it is hidden."""
    at = STEP * np.arange(NODES)
    told = np.where((at >= first) & (at <= last), odds, -odds)
    for begin, end in hidden:
        told[(at >= begin) & (at <= end)] = 0.0
    return told


def found(odds, expected, last_sd=(0.0, 0.0), frames=1, length=LENGTH):
    was = BodyEnd(BEYOND, last_sd[0]), BodyEnd(BEYOND + LENGTH, last_sd[1])
    return find_ends(
        odds, STEP, WIDTH, expected, was, (length, LENGTH_SD * frames**0.5), frames, SETTINGS
    )


PLACES = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))
"""How far the two ends are from where they are expected, widths."""


@given(off=PLACES, slid=st.floats(-1.0, 1.0))
def test_ends_in_clear_water_are_where_it_begins(off, slid):
    expected = BEYOND + slid * WIDTH, BEYOND + LENGTH + slid * WIDTH
    true = expected[0] + off[0] * WIDTH, expected[1] + off[1] * WIDTH
    for end, at in zip(found(seen(*true), expected), true, strict=True):
        assert abs(end.at - at) <= STEP
        assert end.sd < 1.3 * STEP, "midway between two nodes either is as likely"


@given(off=PLACES, slid=st.floats(-1.0, 1.0), hidden=st.floats(0.0, 3.0))
def test_a_path_turned_round_has_its_ends_turned_round(off, slid, hidden):
    expected = BEYOND + slid * WIDTH, BEYOND + LENGTH + slid * WIDTH
    true = expected[0] + off[0] * WIDTH, expected[1] + off[1] * WIDTH
    total = STEP * (NODES - 1)
    odds = seen(*true, hidden=[(true[0] - hidden * WIDTH, true[0] + WIDTH)])
    ends = found(odds, expected)
    turned = found(odds[::-1], (total - expected[1], total - expected[0]))
    for end, other in zip(ends, turned[::-1], strict=True):
        assert end.at == pytest.approx(total - other.at, abs=STEP)
        assert end.sd == pytest.approx(other.sd, rel=0.2, abs=0.2 * STEP)


@given(slid=st.floats(-0.5, 0.5))
def test_an_end_that_nothing_tells_is_where_way_and_length_put_it(slid):
    expected = BEYOND + slid * WIDTH, BEYOND + LENGTH + slid * WIDTH
    odds = seen(*expected, hidden=[(0.0, expected[0] + 4 * WIDTH)])
    hidden, clear = found(odds, expected)
    assert abs(hidden.at - expected[0]) < 0.5 * WIDTH
    moved = SETTINGS.end_sd_widths * WIDTH
    by_both = 1 / hypot(1 / moved, 1 / LENGTH_SD)
    assert hidden.sd == pytest.approx(by_both, rel=0.25)
    assert clear.sd < STEP < hidden.sd


@pytest.mark.parametrize("frames", [1, 4, 9])
def test_a_hidden_end_is_less_sure_the_longer_it_was_not_seen(frames):
    expected = BEYOND, BEYOND + LENGTH
    odds = seen(*expected, hidden=[(0.0, expected[0] + 10 * WIDTH)])
    sds = [found(odds, expected, frames=n)[0].sd for n in (frames, frames + 3)]
    assert sds[1] > 1.1 * sds[0]
    unsure = found(odds, expected, last_sd=(WIDTH, 0.0), frames=frames)
    assert unsure[0].sd > found(odds, expected, frames=frames)[0].sd


def test_an_end_is_where_it_is_as_often_as_its_sd_says():
    """Ends that go as far as they are said to go, over parts of the body of any length."""
    rng = np.random.default_rng(7)
    moved = SETTINGS.end_sd_widths * WIDTH
    score = []
    for _ in range(600):
        expected = BEYOND, BEYOND + LENGTH
        true = np.array(expected) + rng.normal(0.0, moved, 2)
        wanted = true[1] - true[0] + rng.normal(0.0, LENGTH_SD)
        over = true[0] + rng.uniform(-2.0, 2.0) * WIDTH
        odds = seen(*true, hidden=[(over - rng.uniform(0.0, 2.0) * WIDTH, over + 2 * WIDTH)])
        first, last = found(odds, expected, length=wanted)
        score.append([(first.at - true[0]) / max(first.sd, STEP), (last.at - true[1]) / STEP])
    score = np.abs(np.array(score))
    assert (score[:, 0] < 2).mean() > 0.93
    assert (score[:, 0] < 1).mean() > 0.6
    assert score[:, 1].max() <= 1.0


def slid(drawn, path, ways=(0.0, 0.0), length=None, darkening=DARKENING):
    """Slide a body of one width along a path into a picture."""
    grid = np.ones(65)
    body = ExpectedBody(
        widths=drawn.width * grid,
        levels=LEVEL * grid,
        length=drawn.length if length is None else length,
        length_sd=0.04 * drawn.length,
        darkening=darkening,
    )
    nodes = nodes_for(float(np.abs(np.diff(path)).sum()), drawn.width)
    return slide_along_path(
        drawn.signal,
        BodyPath(evenly(path, nodes), ways),
        (0.0, 0.0),
        body,
        1,
        PathFollowingSettings(),
    )


def cut(drawn, first_widths, last_widths):
    """Return the true midline without so much of its ends."""
    first, last = (round(x * NODES_PER_WIDTH) for x in (first_widths, last_widths))
    return drawn.curve[first : len(drawn.curve) - last]


@given(bend=st.floats(-0.25, 0.25), width=WIDTHS, heading=HEADINGS, missing=PLACES)
@settings(max_examples=20)
def test_visible_ends_of_a_drawn_body_are_found_and_sure(bend, width, heading, missing):
    """From a path that lacks up to 0.8 widths at its ends; no end is expected beyond it."""
    drawn = Drawn.of([(16.0, bend)], width, heading, noise=2.0)
    body = slid(drawn, cut(drawn, *np.abs(missing)))
    for tip, true, end in zip(
        body.path.curve[[0, -1]], drawn.curve[[0, -1]], body.ends, strict=True
    ):
        assert abs(tip - true) < 0.1 * width
        assert end.sd < 0.2 * width


def round_to_itself(widths, width, darker):
    """Return a body that has slid by 0.3 widths round a loop to its own flank, and so far on."""
    drawn = Drawn.of([(6.0, 0.0), (7.5, 0.6), (widths, 0.0)], width, 0.3, darker=darker, noise=2.0)
    way = 0.3 * width
    darkening = DARKENING if darker else 0.0
    return drawn, slid(drawn, cut(drawn, 0.3, 0.0), (way, 0.0), darkening=darkening)


@pytest.mark.parametrize("darker", [False, True])
@pytest.mark.parametrize("width", [8.0, 12.0, 16.0])
def test_an_end_on_its_own_flank_is_found_and_less_sure(width, darker):
    """In clear water beyond it the end is as sure as the other one."""
    on_top, across = (round_to_itself(widths, width, darker) for widths in (2.0, 5.0))
    for drawn, body in (on_top, across):
        for tip, true in zip(body.path.curve[[0, -1]], drawn.curve[[0, -1]], strict=True):
            assert abs(tip - true) < 0.5 * width
    assert on_top[1].ends[1].sd > 1.5 * max(on_top[1].ends[0].sd, across[1].ends[1].sd)
    assert across[1].ends[1].sd < 0.2 * width
