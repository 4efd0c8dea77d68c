"""A strand goes to what is missing beside it, and the rest of the body stays where it is."""

import cv2
import numpy as np
import pytest

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_shift import StrandShiftSettings, shifted_strands

WIDTH, SIDE = 16.0, 300
SETTINGS = StrandShiftSettings()


def drawn(line, width=WIDTH):
    picture = np.zeros((SIDE, SIDE), np.uint8)
    points = np.rint(16 * np.c_[line.real, line.imag]).astype(np.int32)
    return cv2.polylines(picture, [points], False, 255, round(width), cv2.LINE_8, 4)


def u_turn(apart):
    """Return two strands, one below the other, joined by a wide turn at the right."""
    x = np.linspace(40, 220, 80)
    turn = 220 + 150j + apart / 2 * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 20))
    upper, lower = 150 - apart / 2, 150 + apart / 2
    return evenly(np.r_[x + 1j * upper, turn[1:-1], x[::-1] + 1j * lower], 300)


def bump(line, by):
    """Move the middle of the lower strand by some pixels."""
    moved = line.copy()
    lower = (line.imag > 150) & (line.real < 215)
    moved[lower] += 1j * by * np.exp(-(((line.real[lower] - 130) / 25) ** 2))
    return moved


@pytest.mark.parametrize("by", [5.0, -5.0])
def test_a_strand_is_moved_to_what_is_left_over_beside_it(by):
    true = u_turn(3.5 * WIDTH)
    found = bump(true, by)
    missing = cv2.bitwise_and(drawn(true), cv2.bitwise_not(drawn(found)))
    moved = shifted_strands(BodyPath(found), missing, WIDTH, SETTINGS)
    assert len(moved) == 1
    off = np.abs(moved[0].curve[:, None] - true).min(axis=1)
    assert np.abs(found[:, None] - true).min(axis=1).max() > 4.5
    assert off.max() < 2.5
    far = np.abs(found.real - 130) > 80
    assert np.abs(moved[0].curve[far][:, None] - true).min(axis=1).max() < 0.3


def test_either_of_two_strands_that_lie_on_each_other_may_be_the_one():
    true = u_turn(0.4 * WIDTH)
    both_at_one_edge = np.where(true.imag > 150, true - 0.35j * WIDTH, true)
    both_at_one_edge = evenly(both_at_one_edge, 300)
    missing = cv2.bitwise_and(drawn(true), cv2.bitwise_not(drawn(both_at_one_edge)))
    moved = shifted_strands(BodyPath(both_at_one_edge), missing, WIDTH, SETTINGS)
    left_over = [
        cv2.countNonZero(cv2.bitwise_and(missing, cv2.bitwise_not(drawn(path.curve))))
        for path in moved
    ]
    assert moved
    assert min(left_over) < 0.3 * cv2.countNonZero(missing)


def test_nothing_missing_moves_nothing():
    nothing = np.zeros((SIDE, SIDE), np.uint8)
    assert shifted_strands(BodyPath(u_turn(40.0)), nothing, WIDTH, SETTINGS) == []
