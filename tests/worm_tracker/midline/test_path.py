"""A path keeps its curvature, however often its nodes are laid anew and beyond its ends."""

import numpy as np
import pytest

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.path import BodyPath, ContinuationSettings, continued, evenly, path_of


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
