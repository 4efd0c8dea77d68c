"""How dark overlaps are is told by a marked body that was followed into them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from marked_strands import LENGTH, NODES, WIDTH, alone, laid_back, marks
from skinned_ends import DARKENING, LEVEL, body_in_skin, marks_along

from worm_tracker.midline.body_shade import ACROSS
from worm_tracker.midline.drawn_skin import SkinnedBody
from worm_tracker.midline.overlap_darkening import OverlapDarkeningSettings, overlap_darkening

SETTINGS = OverlapDarkeningSettings()
MARKED = marks(np.random.default_rng(1))


def told(signal, line, levels):
    mean = np.repeat(levels[:, None], len(ACROSS), axis=1)
    body = SkinnedBody(line, np.full(NODES, WIDTH), mean, float(np.median(levels)), 0.0)
    return overlap_darkening(signal, body, WIDTH, SETTINGS)


@given(seed=st.integers(0, 2**31), darkening=st.floats(0.1, 0.8), turns_at=st.floats(0.55, 0.92))
@settings(max_examples=25)
def test_what_the_second_layer_adds_is_found_whatever_the_marks(seed, darkening, turns_at):
    levels = marks(np.random.default_rng(seed))
    signal, line = laid_back(levels, turns_at * LENGTH, darkening)
    assert told(signal, line, levels) == pytest.approx(darkening, abs=0.03)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("aside", [0.0, 0.3])
def test_so_it_is_in_a_skin_that_the_rig_has_drawn(seed, aside):
    line, widths, signal, mean = body_in_skin(0.5, aside, marks_along(seed))
    body = SkinnedBody(line, widths, mean, LEVEL, 0.0)
    darkening = overlap_darkening(signal, body, WIDTH, SETTINGS)
    assert darkening == pytest.approx(DARKENING, abs=0.06)


@given(seed=st.integers(0, 2**31))
@settings(max_examples=10)
def test_overlaps_that_are_no_darker_are_not_told_to_be(seed):
    levels = marks(np.random.default_rng(seed))
    darkening = told(*laid_back(levels, 0.7 * LENGTH, 0.0), levels)
    assert darkening is None or darkening < 0.1


@pytest.mark.parametrize("laid_apart", [0.7, 0.85, 1.0])
def test_strands_that_lie_side_by_side_and_are_laid_too_near_tell_nothing(laid_apart):
    signal, _ = laid_back(MARKED, 0.7 * LENGTH, 0.5, WIDTH)
    _, line = laid_back(MARKED, 0.7 * LENGTH, 0.5, laid_apart * WIDTH)
    assert told(signal, line, MARKED) is None


def test_a_body_that_lies_otherwise_tells_nothing():
    signal, _ = alone(MARKED)
    _, line = laid_back(MARKED, 0.7 * LENGTH, 0.5)
    assert told(signal, line, MARKED) is None


@pytest.mark.parametrize("turns_at", [0.99, 0.965])
def test_a_body_that_hardly_lies_on_itself_tells_nothing(turns_at):
    assert told(*laid_back(MARKED, turns_at * LENGTH, 0.5), MARKED) is None


def test_a_window_that_the_body_is_not_in_tells_nothing():
    _, line = laid_back(MARKED, 0.7 * LENGTH, 0.5)
    assert told(np.zeros((40, 40), np.uint8), line + 500, MARKED) is None


def test_an_end_that_is_laid_too_far_on_does_not_make_overlaps_paler():
    even = np.full(NODES, 80.0)
    signal, line = laid_back(even, 0.6 * LENGTH, 0.5)
    onwards = (line[-1] - line[-2]) * np.arange(1, round(1.3 * WIDTH / abs(line[-1] - line[-2])))
    too_long = np.concatenate([line, line[-1] + onwards])
    assert told(signal, too_long, even) == pytest.approx(0.5, abs=0.01)
