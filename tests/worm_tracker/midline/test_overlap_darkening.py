"""How dark overlaps are is told by a marked body that was followed into them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from marked_strands import LENGTH, NODES, WIDTH, laid_back, marks

from worm_tracker.midline.overlap_darkening import (
    OverlapDarkeningSettings,
    level_below,
    overlap_darkening,
)
from worm_tracker.midline.self_cover import SelfCoverSettings


def told(levels, turns_at, darkening, known=None):
    signal, line = laid_back(levels, turns_at, darkening)
    widths = np.full(NODES, WIDTH)
    known = levels if known is None else known
    return overlap_darkening(signal, line, widths, known, WIDTH, OverlapDarkeningSettings())


@given(seed=st.integers(0, 2**31), darkening=st.floats(0.0, 0.8), turns_at=st.floats(0.55, 0.85))
@settings(max_examples=25)
def test_what_the_second_layer_adds_is_found_whatever_the_marks(seed, darkening, turns_at):
    levels = marks(np.random.default_rng(seed))
    assert told(levels, turns_at * LENGTH, darkening) == pytest.approx(darkening, abs=0.06)


@given(seed=st.integers(0, 2**31))
@settings(max_examples=10)
def test_a_level_known_a_tenth_too_low_is_no_overlap_where_overlaps_are_no_darker(seed):
    levels = marks(np.random.default_rng(seed))
    assert told(levels, 0.7 * LENGTH, 0.0, known=0.9 * levels) < 0.2


@pytest.mark.parametrize("turns_at", [0.99, 0.965])
def test_a_body_that_hardly_lies_on_itself_tells_nothing(turns_at):
    assert told(marks(np.random.default_rng(1)), turns_at * LENGTH, 0.5) is None


def test_the_part_below_is_the_nearest_that_is_not_the_same_and_is_there():
    line = np.r_[np.arange(0.0, 100.0), np.arange(98.0, -1.0, -1.0)] + 0j
    level = np.arange(float(len(line))) + 1
    covered = np.ones(len(line), bool)
    cover = SelfCoverSettings()
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == level[48]
    level[45:52] = 0.0  # the body is not there
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == level[44]
    covered[150] = False
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == 0.0
