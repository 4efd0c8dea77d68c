"""Strands are moved until their flanks lie on the outline, where another strand hides none."""

import numpy as np
import pytest
from drawn_folds import HEADINGS, LEVEL, Drawn, rounded_widths
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.flank_fit import (
    FlankFitSettings,
    StrandMoves,
    fitted_to_flanks,
)
from worm_tracker.midline.object_outline import Outline
from worm_tracker.midline.path import evenly, nodes_for

WIDTH = 14.0
STRAIGHT = [(20.0, 0.0)]
HAIRPIN = [(12.0, 0.0), (1.25, np.pi / 1.25), (8.0, 0.0)]
"""Its strands lie side by side, 0.8 widths apart, so that each hides a flank of the other."""


def disc(radius, size=121):
    """Return a disc's part of each pixel, grey levels, by nine points in a pixel."""
    at = (np.arange(3 * size) + 0.5) / 3 - 0.5 - size // 2
    inside = np.hypot(*np.meshgrid(at, at)) < radius
    part = inside.reshape(size, 3, size, 3).mean(axis=(1, 3))
    return np.rint(200 * part).astype(np.uint8)


def fitted(drawn, curve, place):
    """Return what a body costs that is fitted to a picture, and where it lies then."""
    outline = Outline.of(drawn.signal, LEVEL / 2)
    half = rounded_widths(complex_arc_length(curve), WIDTH) / 2
    moves = StrandMoves(end_widths=4.0, strand_sd_widths=0.3, end_sd_widths=0.3, iterations=6)
    return fitted_to_flanks(curve, half, outline, place, WIDTH, moves, FlankFitSettings())


def path_of(drawn):
    s = np.linspace(0.0, drawn.length, 800)
    return evenly(drawn.at(s), nodes_for(drawn.length, WIDTH))


@pytest.mark.parametrize("radius", [12.3, 30.0, 41.7])
def test_the_distance_from_a_discs_outline_is_that_from_its_middle_less_its_radius(radius):
    outline = Outline.of(disc(radius), 100.0)
    distance = outline.distance
    v, u = np.indices(distance.shape) - distance.shape[0] // 2
    true = np.hypot(u, v) - radius
    near = np.abs(true) < 8
    assert np.abs(distance - true)[near].max() < 0.5
    assert abs((distance - true)[near].mean()) < 0.1
    assert np.abs(np.abs(outline.pixels - (60 + 60j)) - radius).max() < 1.0
    assert len(outline.pixels) > 2 * np.pi * radius / 1.5


@given(heading=HEADINGS, aside=st.floats(-0.3, 0.3))
def test_a_strand_told_aside_is_moved_to_where_its_flanks_are(heading, aside):
    drawn = Drawn.of(STRAIGHT, WIDTH, heading, darker=False)
    true = path_of(drawn)
    place = complex(true[len(true) // 2])
    _, line = fitted(drawn, true + 1j * np.exp(1j * heading) * aside * WIDTH, place)
    near = np.abs(line - place) < 2.5 * WIDTH
    off = ((line - true) * np.exp(-1j * heading)).imag[near]
    assert np.abs(off).max() < 0.06 * WIDTH


@given(heading=HEADINGS)
def test_a_flank_that_another_strand_hides_moves_nothing(heading):
    drawn = Drawn.of(HAIRPIN, WIDTH, heading, darker=False)
    true = path_of(drawn)
    place = complex(true[-1])
    cost, line = fitted(drawn, true, place)
    near = np.abs(true - place) < 3 * WIDTH
    assert np.abs(line - true)[near].max() < 0.1 * WIDTH
    assert cost < 5.0


def test_what_of_an_object_lies_beyond_all_flanks_costs():
    drawn = Drawn.of(STRAIGHT, WIDTH, darker=False)
    true = path_of(drawn)
    whole, _ = fitted(drawn, true, complex(true[-1]))
    short, _ = fitted(drawn, true[:-8], complex(true[-1]))
    assert short > whole + 20.0
