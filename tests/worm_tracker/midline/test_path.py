"""A path keeps its curvature, however often its nodes are laid anew and beyond its ends."""

import numpy as np
import pytest

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.path import (
    BodyPath,
    ContinuationSettings,
    continued,
    evenly,
    path_of,
    sharp_turns,
)


def test_a_path_does_not_shrink_however_often_its_nodes_are_laid_anew():
    """On a circle of two widths; straight pieces would cut half a pixel off it every time."""
    radius, width = 16.0, 8.0
    circle = radius * np.exp(1j * np.linspace(0, 4, 80))
    path = path_of(as_points(circle), None, width)
    for count in [60, 61] * 100:
        path = BodyPath(evenly(path.curve, count))
    assert np.abs(path.curve) == pytest.approx(radius, abs=0.02)
    assert path.length == pytest.approx(4 * radius, abs=0.05)


def test_a_path_is_continued_on_its_own_circle():
    radius, width = 16.0, 8.0
    path = path_of(as_points(radius * np.exp(1j * np.linspace(0, 4, 80))), None, width)
    assert np.abs(continued(path, 10, width, ContinuationSettings())) == pytest.approx(
        radius, abs=0.1
    )


@pytest.mark.parametrize(("turn_rad", "is_sharp"), [(0.5, False), (1.2, True), (2.5, True)])
def test_a_kink_is_a_sharp_turn_where_it_is_and_nowhere_else(turn_rad, is_sharp):
    width, leg = 8.0, np.linspace(0.0, 60.0, 33)
    line = np.concatenate([-leg[::-1], leg[1:] * np.exp(1j * turn_rad)])
    found = sharp_turns(as_points(line), width, 0.8)
    assert bool(len(found)) is is_sharp
    assert (np.hypot(*found.T) < width).all()


def test_a_circle_turns_by_a_width_over_its_radius_everywhere():
    radius, width = 10.0, 8.0
    circle = as_points(radius * np.exp(1j * np.linspace(0, 4, 80)))
    turn = width / radius
    assert len(sharp_turns(circle, width, 1.05 * turn)) == 0
    assert len(sharp_turns(circle, width, 0.9 * turn)) > 60
