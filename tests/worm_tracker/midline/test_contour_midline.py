"""A first midline runs within the body, however its two sides differ in length."""

import cv2
import pytest
from drawn_folds import HEADINGS, Drawn, as_rows
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from worm_tracker.midline.contour_midline import ContourMidlineSettings, contour_midline

S_BEND = [(7.0, 0.0), (2.0, -0.7), (1.0, 0.0), (5.0, 0.72), (5.0, 0.0)]
"""Behind its sharp bend the outer side is three widths longer than the inner one."""
GENTLE = [(6.0, 0.0), (5.0, 0.2), (5.0, -0.25), (6.0, 0.0)]
HOOK = [(8.0, 0.0), (3.0, 0.9), (3.0, 0.0)]


def off_axis_widths(arcs, width, heading, mirrored):
    """Return how far the points of a first midline lie beside the true one, ends left out."""
    arcs = [(length, -turn if mirrored else turn) for length, turn in arcs]
    drawn = Drawn.of(arcs, width, heading)
    outlines, _ = cv2.findContours(drawn.mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    contour = max(outlines, key=cv2.contourArea)[:, 0]
    found = contour_midline(contour, width, None, ContourMidlineSettings())
    assert found is not None
    within = found.points[4:-4]
    return cKDTree(as_rows(drawn.curve)).query(within)[0].max() / width


@pytest.mark.parametrize("arcs", [S_BEND, GENTLE, HOOK], ids=["s", "gentle", "hook"])
@given(width=st.floats(8.0, 24.0), heading=HEADINGS, mirrored=st.booleans())
@settings(max_examples=20, deadline=None)
def test_behind_a_sharp_bend_it_still_runs_in_the_bodys_middle(arcs, width, heading, mirrored):
    """Nearer than what the cross-sections put right."""
    assert off_axis_widths(arcs, width, heading, mirrored) < 0.3
