"""A body is traced through its object from its ends alone, as straight on as it can."""

import numpy as np
import pytest
from drawn_folds import Drawn
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.midline.traced_body import TracedBodySettings, traced_bodies

WIDTH = 12.0
SETTINGS = TracedBodySettings()
WAVE = [(5.0, 0.0), (8.0, 0.3), (8.0, -0.3), (5.0, 0.0)]
LOOP = [(9.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (9.0, 0.0)]
"""A body that goes round a loop and crosses itself squarely."""
SPIRAL = [(6.0, 0.0), (8.0 * np.pi, 1 / 5), (3.5 * np.pi, 1 / 4.4), (4.0, 1 / 1.6)]
"""Once round, along itself, and the end reaches into the loop."""


def traced_in(drawn, mask=None):
    mask = drawn.mask if mask is None else mask
    return traced_bodies(mask, drawn.width, drawn.length, SETTINGS)


def away_widths(line, drawn):
    """Return how far the traced body lies from the true one at most, in the nearer order."""
    true = drawn.at(np.linspace(0.0, drawn.length, 400))
    step = np.r_[0.0, np.cumsum(np.abs(np.diff(line)))]
    even = np.interp(np.linspace(0, step[-1], 400), step, line)
    return min(np.abs(even - way).max() for way in (true, true[::-1])) / drawn.width


@pytest.mark.parametrize("arcs", [WAVE, LOOP], ids=["open", "loop"])
@pytest.mark.parametrize("width", [8.0, 12.0, 20.0])
def test_from_either_end_a_body_is_traced_to_the_other(arcs, width):
    drawn = Drawn.of(arcs, width)
    found = traced_in(drawn)
    assert len(found) >= 2
    ends = np.array([drawn.curve[0], drawn.curve[-1]])
    for end in ends:
        line = min(found, key=lambda line: abs(line[0] - end))
        assert abs(line[0] - end) < 0.2 * width
        assert away_widths(line, drawn) < 0.5


def test_a_body_that_lies_along_itself_is_traced_round_and_on():
    drawn = Drawn.of(SPIRAL, WIDTH)
    assert min(away_widths(line, drawn) for line in traced_in(drawn)) < 0.5


@pytest.mark.parametrize("gap", [0.0, 1.4])
def test_a_hairpin_is_traced_round_whether_its_arms_touch_or_not(gap):
    turn = 2 / (1 + gap)  # of half a circle whose arms lie a width and the gap apart
    drawn = Drawn.of([(14.0, 0.0), (np.pi / turn, turn), (11.0, 0.0)], WIDTH)
    assert min(away_widths(line, drawn) for line in traced_in(drawn)) < 0.8


def test_a_mirrored_object_gives_mirrored_bodies():
    drawn = Drawn.of(LOOP, WIDTH)
    edge = drawn.mask.shape[1] - 1
    mirrored = [edge - line.conj() for line in traced_in(drawn, drawn.mask[:, ::-1].copy())]
    ends = drawn.curve[[0, -1]]
    for lines in (traced_in(drawn), mirrored):
        assert all(np.abs(line[0] - ends).min() < 0.3 * WIDTH for line in lines)
        assert min(away_widths(line, drawn) for line in lines) < 0.3


def test_what_is_far_shorter_than_the_worm_is_none():
    drawn = Drawn.of(WAVE, WIDTH)
    assert traced_bodies(drawn.mask, WIDTH, 2 * drawn.length, SETTINGS) == []
    assert traced_bodies(np.zeros((40, 40), np.uint8), WIDTH, drawn.length, SETTINGS) == []


turns = st.floats(-0.35, 0.35)


@given(st.lists(st.tuples(st.floats(3.0, 9.0), turns), min_size=2, max_size=5))
@settings(max_examples=60, deadline=None)
def test_every_body_lies_on_its_object_in_even_steps(arcs):
    drawn = Drawn.of([(4.0, 0.0), *arcs, (4.0, 0.0)], WIDTH)
    for line in traced_in(drawn):
        inner = line[1:]
        u, v = np.rint(inner.real).astype(int), np.rint(inner.imag).astype(int)
        near = [drawn.mask[v + dv, u + du] > 0 for dv in (-1, 0, 1) for du in (-1, 0, 1)]
        assert np.any(near, axis=0).all()
        steps = np.abs(np.diff(line)) / (SETTINGS.step_widths * WIDTH)
        assert steps.min() > 0.95
        assert steps.max() < 1.15
