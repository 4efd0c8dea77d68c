"""An end that lies on two other strands is told from a place at which those two lie alone.

A body winds round a ring for two turns and more: each turn lies on the one before. Its picture is
that of light which passes one, two or three layers of it.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_erosion

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.drawn_signal import BodySignal
from worm_tracker.midline.end_residual import EndResidualSettings, end_over_limits
from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.path_following import PathFollowingSettings, slide_along_path
from worm_tracker.midline.self_cover import SelfCoverSettings, parts_over
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands

WIDTH, RADIUS_WIDTHS, LIGHT, LIGHT_PASSED = 14.0, 3.0, 200.0, 0.6
LEVEL = LIGHT * (1 - LIGHT_PASSED)
RADIUS, SIDE = RADIUS_WIDTHS * WIDTH, int((2 * RADIUS_WIDTHS + 8) * WIDTH)
MIDDLE = SIDE / 2 * (1 + 1j) + 0.3 + 0.4j
OVER_WIDTHS = st.floats(3.0, 8.0)


def wound(over_widths):
    """Return a body of two turns and so many widths more, in the middle of its picture."""
    turn = np.linspace(0.0, 4 * np.pi + over_widths / RADIUS_WIDTHS, 1200)
    return MIDDLE + RADIUS * np.exp(1j * turn)


def ring(over_widths):
    """Return how much of each pixel the ring covers, and in how many layers of the body."""
    v, u = np.mgrid[:SIDE, :SIDE]
    at = u + 1j * v - MIDDLE
    turn = np.angle(at) % (2 * np.pi)
    part = np.clip(WIDTH / 2 - np.abs(np.abs(at) - RADIUS) + 0.5, 0.0, 1.0)
    return part, 2 + (turn < over_widths / RADIUS_WIDTHS)


def signal_of(over_widths, seed=0):
    part, layers = ring(over_widths)
    noise = np.random.default_rng(seed).normal(0.0, 2.0, (SIDE, SIDE))
    signal = LIGHT * part * (1 - LIGHT_PASSED**layers) + noise
    return np.clip(np.rint(signal), 0, 255).astype(np.uint8)


def body_of(line):
    levels = np.full(len(line), LEVEL)
    return BodySignal(line, np.full(len(line), WIDTH), WIDTH, LEVEL, levels, LIGHT_PASSED)


@given(over_widths=OVER_WIDTHS)
@settings(max_examples=25)
def test_three_strands_are_drawn_where_three_lie(over_widths):
    line, widths = wound(over_widths), np.full(1200, WIDTH)
    drawn = drawn_strands((SIDE, SIDE), as_points(line), widths, WIDTH, StrandDrawingSettings())
    part, layers = ring(over_widths)
    layers = np.where(part > 0.5, layers, 0)
    for picture, least in ((drawn.body, 1), (drawn.layered, 2), (drawn.thrice, 3)):
        inside, outside = (
            binary_erosion(x, iterations=2) for x in (layers >= least, layers < least)
        )
        assert picture[inside].all()
        assert not picture[outside].any()


@given(over_widths=OVER_WIDTHS)
@settings(max_examples=25)
def test_as_many_parts_lie_over_a_body_as_it_has_turns_more(over_widths):
    line = wound(over_widths)
    step, half = float(np.abs(np.diff(line)).mean()), np.full(len(line), WIDTH / 2)
    over = parts_over(line[:, None], line, half, slice(None), step, 0.0, SelfCoverSettings())[:, 0]
    turn = np.linspace(0.0, 4 * np.pi + over_widths / RADIUS_WIDTHS, len(line)) % (2 * np.pi)
    inside = turn < (over_widths - 1) / RADIUS_WIDTHS
    outside = (turn > (over_widths + 1) / RADIUS_WIDTHS) & (turn < 2 * np.pi - 1 / RADIUS_WIDTHS)
    assert (over[inside] == 2).all()
    assert (over[outside] == 1).all()


@given(over_widths=OVER_WIDTHS)
@settings(max_examples=25)
def test_the_picture_is_explained_beside_the_end_where_it_is_alone(over_widths):
    signal = signal_of(over_widths)

    def over_limits(moved_widths):
        line = wound(over_widths + moved_widths)
        return end_over_limits(signal, body_of(line), complex(line[-1]), EndResidualSettings())

    assert over_limits(0.0) < 1
    assert over_limits(1.0) > 1
    assert over_limits(-1.0) > 1


@pytest.mark.parametrize("seed", range(8))
def test_the_end_is_found_where_the_third_layer_ends(seed):
    """The body was seen before, up to half a width shorter, and is told its length roughly."""
    rng = np.random.default_rng(seed)
    over_widths = rng.uniform(3.0, 8.0)
    before = wound(over_widths - rng.uniform(0.0, 0.5))
    length = float(np.abs(np.diff(wound(over_widths))).sum())
    body = ExpectedBody(np.full(50, WIDTH), np.full(50, LEVEL), length, 0.04 * length, LIGHT_PASSED)
    path = BodyPath(evenly(before, nodes_for(float(np.abs(np.diff(before)).sum()), WIDTH)))
    signal = signal_of(over_widths, seed)
    slid = slide_along_path(signal, path, (0.0, 0.0), body, 1, PathFollowingSettings())
    assert slid is not None
    assert abs(slid.path.curve[-1] - wound(over_widths)[-1]) < 0.35 * WIDTH
