"""A first midline runs within the body, however its two sides differ in length."""

import cv2
import numpy as np
import pytest
from drawn_folds import HEADINGS, Drawn, as_rows
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from worm_tracker.midline.contour_midline import (
    ContourMidlineSettings,
    contour_midline,
    ends_of_contour,
    first_contour_midline,
)
from worm_tracker.midline.curve import length_of

S_BEND = [(7.0, 0.0), (2.0, -0.7), (1.0, 0.0), (5.0, 0.72), (5.0, 0.0)]
"""Behind its sharp bend the outer side is three widths longer than the inner one."""
GENTLE = [(6.0, 0.0), (5.0, 0.2), (5.0, -0.25), (6.0, 0.0)]
HOOK = [(8.0, 0.0), (3.0, 0.9), (3.0, 0.0)]


HAIRPIN = [(20.0, 0.0), (1.5, 2.0), (2.0, 0.0), (17.0, -0.04)]
"""Its strands touch at the turn: there it is nearly twice as thick as the body is wide."""


def contour_of(drawn):
    """Return the outline of what was drawn."""
    outlines, _ = cv2.findContours(drawn.mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return max(outlines, key=cv2.contourArea)[:, 0]


def off_axis_widths(arcs, width, heading, mirrored):
    """Return how far the points of a first midline lie beside the true one, ends left out."""
    arcs = [(length, -turn if mirrored else turn) for length, turn in arcs]
    drawn = Drawn.of(arcs, width, heading)
    found = contour_midline(contour_of(drawn), width, None, ContourMidlineSettings())
    assert found is not None
    within = found.points[4:-4]
    return cKDTree(as_rows(drawn.curve)).query(within)[0].max() / width


@pytest.mark.parametrize("arcs", [S_BEND, GENTLE, HOOK], ids=["s", "gentle", "hook"])
@given(width=st.floats(8.0, 24.0), heading=HEADINGS, mirrored=st.booleans())
@settings(max_examples=20, deadline=None)
def test_behind_a_sharp_bend_it_still_runs_in_the_bodys_middle(arcs, width, heading, mirrored):
    """Nearer than what the cross-sections put right."""
    assert off_axis_widths(arcs, width, heading, mirrored) < 0.3


@pytest.mark.parametrize("width", [9.0, 12.0, 16.0, 20.0, 24.0])
def test_a_body_that_touches_itself_is_measured_by_its_own_width(width):
    """By its object's thickest part its turn is cut short."""
    headings, settings = np.arange(0.1, 6.3, 0.4), ContourMidlineSettings()
    drawn = [Drawn.of(HAIRPIN, width, heading) for heading in headings]
    by_thickness, found = (
        [length_of(find(contour_of(one), 1.8 * width, None, settings).points) for one in drawn]
        for find in (contour_midline, first_contour_midline)
    )
    true = [np.abs(np.diff(one.curve)).sum() for one in drawn]
    assert 0.96 < np.mean(found) / np.mean(true) < 1.0
    assert np.mean(found) > np.mean(by_thickness) + 0.002 * np.mean(true)


@pytest.mark.parametrize("mirrored", [False, True])
@given(angle=st.floats(0.0, 6.28))
@settings(max_examples=20, deadline=None)
def test_an_end_that_reaches_into_a_hole_is_an_end_of_its_contour(mirrored, angle):
    """A ring from which a body reaches inwards; nothing of the ring itself is an end."""
    width, middle, radius = 12, 120 + 120j, 80.0
    way = np.exp(1j * angle)
    tip, root = middle + 20.0 * way, middle + radius * way
    mask = np.zeros((240, 240), np.uint8)
    cv2.circle(mask, (120, 120), round(radius), 255, width)
    spur = np.rint(16 * np.array([[tip.real, tip.imag], [root.real, root.imag]])).astype(np.int32)
    cv2.polylines(mask, [spur], False, 255, width, cv2.LINE_8, 4)
    mask = mask[:, ::-1].copy() if mirrored else mask
    if mirrored:
        tip, way = 239 - tip.conjugate(), -way.conjugate()
    contours, tree = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    settings = ContourMidlineSettings()
    for contour, (_, _, _, parent) in zip(contours, tree[0], strict=True):
        ends = ends_of_contour(contour[:, 0], width, settings, is_hole=parent >= 0)
        if parent < 0:
            assert ends == []
            continue
        sharpest, inwards = ends[0]
        assert abs(sharpest - tip) < width  # its cap reaches half a width beyond the line
        assert (inwards / way).real > 0.9
