"""How far aside a body moves: by itself, whatever it slides."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.moved_aside import moved_aside_px

NODES, LENGTH, RADIUS = 65, 240.0, 60.0
STEP = LENGTH / (NODES - 1)
ALONG = 40.0
INNER = slice(12, -12)


def bent(slid_px=0.0, outwards_px=0.0):
    """A body on a circle, slid along it and moved out of it."""
    s = np.linspace(0, LENGTH, NODES) + slid_px
    angle, radius = s / RADIUS, RADIUS + outwards_px
    return np.stack([100 + radius * np.cos(angle), 100 + radius * np.sin(angle)], axis=1)


@given(st.floats(-30, 30), st.floats(-20, 20))
def test_a_body_that_slides_along_itself_is_as_far_aside_as_it_moved_out_of_its_way(slid, outwards):
    aside = moved_aside_px(bent(slid, outwards), bent(), ALONG)
    assert aside[INNER] == pytest.approx(abs(outwards), abs=0.5)  # of half a node


def test_a_loop_passed_the_other_way_round_lies_aside_though_it_covers_the_same():
    """At the loop's middle both ways meet."""
    angle = np.linspace(0, 2 * np.pi, 41)
    round_ = np.stack([100 + 30 * np.sin(angle), 100 - 30 * np.cos(angle)], axis=1)
    line = np.linspace([0, 70], [95, 70], 12)
    one = np.concatenate([line, round_, 200 - line[::-1] + [0, -60]])
    other = np.concatenate([line, round_[::-1], 200 - line[::-1] + [0, -60]])
    aside = moved_aside_px(one, other, 20.0)
    assert aside[:12].max() < 0.5
    assert aside[20:24].min() > 30
    assert aside[32] < 0.5


def test_what_is_not_told_of_one_of_both_is_not_asked_for():
    points, before = bent(), bent(outwards_px=5.0)
    points[10:15], before[30:40] = np.nan, np.nan
    aside = moved_aside_px(points, before, ALONG)
    assert np.flatnonzero(np.isnan(aside)).tolist() == [*range(10, 15), *range(30, 40)]
    assert aside[16:29] == pytest.approx(5.0, abs=0.2)
