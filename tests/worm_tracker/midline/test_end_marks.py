"""Marks tell where a pale end lies on another part, and whether the picture lacks some of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from marked_strands import LENGTH, WIDTH, alone, marks

from worm_tracker.midline.end_marks import (
    EndMarksSettings,
    SeenOnPath,
    log_odds_of_whole_end,
    more_by_marks,
)

SETTINGS = EndMarksSettings()
PER_WIDTH, DARKENING, LEVEL, MOST = 5, 0.5, 85.0, 2.4


def seen_with_end_at(true, rng, noise):
    """Return what is seen of a pale end that lies on another part, and its profile."""
    n = 200
    node = np.arange(n)
    own = np.interp(node, node[::3], rng.uniform(25.0, 60.0, len(node[::3])))
    own[:3] = 110.0, 120.0, 90.0  # a dark tip, as of a skin that was photographed
    below = np.interp(node, node[::7], rng.uniform(70.0, 120.0, len(node[::7])))
    there = np.where(node >= true, own[np.maximum(node - true, 0)], 0.0)
    signal = below + DARKENING * there + rng.normal(0.0, noise, n)
    profile = own[: round(SETTINGS.widths * PER_WIDTH)]
    expected = own[np.maximum(node - 30, 0)]
    none = np.zeros(n)
    return SeenOnPath(signal, below, expected, none.astype(bool), none), profile


def ends_at(seen, profile):
    more = more_by_marks(seen, profile, DARKENING, LEVEL, MOST, SETTINGS)
    return more, int(more.argmax())


@given(seed=st.integers(0, 2**31), true=st.integers(10, 60))
@settings(max_examples=40)
def test_a_pale_end_is_found_by_its_dark_tip_on_another_part(seed, true):
    _, at = ends_at(*seen_with_end_at(true, np.random.default_rng(seed), noise=2.0))
    assert abs(at - true) <= 1


@pytest.mark.parametrize("true", [15, 40])
def test_the_last_end_is_found_as_the_first_one_is_from_the_other_side(true):
    seen, profile = seen_with_end_at(true, np.random.default_rng(3), noise=2.0)
    twice = seen.turned().turned()
    assert ends_at(twice, profile)[1] == ends_at(seen, profile)[1]
    assert seen.turned().signal[-1 - true] == seen.signal[true]


def test_beside_the_edge_of_another_part_no_mark_speaks_for_an_end():
    seen, profile = seen_with_end_at(30, np.random.default_rng(5), noise=0.0)
    free, _ = ends_at(seen, profile)
    border = np.ones(len(seen.signal), bool)
    beside = SeenOnPath(seen.signal, seen.below, seen.own, border, seen.odds)
    assert (ends_at(beside, profile)[0] <= 0).all()
    assert free.max() > 0


def test_on_a_path_shorter_than_the_end_marks_tell_nothing():
    seen, profile = seen_with_end_at(30, np.random.default_rng(5), noise=0.0)
    short = SeenOnPath(
        *(each[:30] for each in (seen.signal, seen.below, seen.own)),
        seen.border[:30],
        seen.odds[:30],
    )
    assert not ends_at(short, profile)[0].any()


def whole(levels, cut_px, brighter=1.0, known=None):
    signal, line = alone(np.minimum(brighter * levels, 255), cut_px)
    known = levels if known is None else known
    return log_odds_of_whole_end(signal, line, known, LENGTH, WIDTH, SETTINGS)


def with_dark_tip(seed):
    levels = marks(np.random.default_rng(seed), pale_widths=8.0)
    levels[:4] = 80.0, 110.0, 100.0, 70.0
    return levels


@given(seed=st.integers(0, 2**31), cut=st.floats(1.5, 12.0), brighter=st.floats(0.8, 1.3))
@settings(max_examples=40)
def test_a_marked_end_is_whole_and_is_not_where_it_is_cut(seed, cut, brighter):
    levels = with_dark_tip(seed)
    assert whole(levels, 0.0, brighter) > 8.0
    assert whole(levels, cut * WIDTH, brighter) < 8.0


def test_an_end_without_marks_is_not_told_to_be_whole():
    even = np.full(121, 60.0)
    assert whole(even, 0.0) < 8.0
