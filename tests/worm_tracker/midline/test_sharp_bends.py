"""A hairpin of a path goes to where the picture of it ends, and open bends stay where they are."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.path import evenly
from worm_tracker.midline.sharp_bends import SharpBendSettings, bends_at_edges

SETTINGS = SharpBendSettings()
LEVEL = 120.0
HEADINGS = st.floats(0.0, 6.28)


def hairpin(tip, axis, width, gap_widths):
    """Return two strands side by side that meet in a tip; `axis` is a unit vector towards it."""
    bend = axis * gap_widths * width / 2
    turn = np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 9)) * bend
    strand = tip - bend - axis * width * np.linspace(5, 0.3, 20)
    return np.r_[strand + 1j * bend, tip - bend + turn, strand[::-1] - 1j * bend]


def drawn(line, width, side=240):
    picture = np.zeros((side, side), np.uint8)
    points = np.rint(16 * np.c_[line.real, line.imag]).astype(np.int32)
    cv2.polylines(picture, [points], False, LEVEL, round(width), cv2.LINE_8, 4)
    return cv2.GaussianBlur(picture, (0, 0), 1.0)


def moved(picture, path, width):
    curve = evenly(path, 200)
    step = abs(curve[1] - curve[0])
    half, level = np.full(200, width / 2), np.full(200, LEVEL)
    return bends_at_edges(picture, curve, half, level, width, step, SETTINGS)


@given(heading=HEADINGS, ahead=st.floats(-0.4, 0.4))
@pytest.mark.parametrize("width", [9.0, 15.0, 21.0])
def test_a_hairpin_that_travelled_is_found_again(width, heading, ahead):
    axis, tip = np.exp(1j * heading), 120 + 120j
    picture = drawn(hairpin(tip, axis, width, 0.4), width)
    last = hairpin(tip + ahead * width * axis, axis, width, 0.4)
    found = moved(picture, last, width)
    reached = ((found - tip) * axis.conjugate()).real.max()
    assert abs(reached) < 0.05 * width + 1.0  # what is drawn is up to a pixel wider


@given(heading=HEADINGS)
def test_a_gentle_bend_stays(heading):
    angle = np.linspace(0, 2.5, 60)
    path = 120 + 120j + 60 * np.exp(1j * (angle + heading))
    picture = drawn(path, 15.0)
    curve = evenly(path, 200)
    assert np.array_equal(moved(picture, path, 15.0), curve)


def test_a_hairpin_over_another_part_stays():
    """Where the object goes on beyond it, no edge tells where the bend is."""
    path = hairpin(120 + 120j, 1 + 0j, 15.0, 0.4)
    picture = cv2.line(drawn(path, 15.0), (128, 20), (128, 220), LEVEL, 40)
    assert np.array_equal(moved(picture, path, 15.0), evenly(path, 200))


@pytest.mark.parametrize("ahead_px", [-6.0, 6.0])
def test_a_kink_with_water_within_it_goes_to_where_the_picture_ends(ahead_px):
    """Its sides are seen, but its outermost part is not in their cross-sections."""
    sides = 80 * np.exp(1j * np.array([0.8, -0.8]) + 1j * np.pi)
    kink = np.r_[sides[0], 0, sides[1]] + 130 + 120j
    path = evenly(np.interp(np.linspace(0, 2, 60), np.arange(3), kink), 200) + ahead_px
    found = moved(drawn(kink, 15.0), path, 15.0)
    assert found.real.max() == pytest.approx(130.0, abs=1.5)
