"""A body that is slid along itself goes on as it went where the picture tells nothing."""

import numpy as np
import pytest

from worm_tracker.midline.curve import TRACKED_POINTS
from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.path_following import PathFollowingSettings, slide_along_path

WIDTH, LEVEL, LENGTH = 16.0, 80.0, 320.0


def first_end_after(way_widths):
    """Return how far the first end goes on, widths, where nothing in the picture tells."""
    signal = np.full((120, 900), LEVEL, np.uint8)
    signal[:, :450] = LEVEL / 2  # speaks neither for the body nor against it
    path = BodyPath(np.linspace(300.0, 300.0 + LENGTH, 161) + 60j, (way_widths * WIDTH, 0.0))
    widths, levels = np.full(TRACKED_POINTS, WIDTH), np.full(TRACKED_POINTS, LEVEL)
    body = ExpectedBody(widths, levels, LENGTH, 100 * LENGTH, 0.0)
    slid = slide_along_path(signal, path, (1.0, 1.0), body, 1, PathFollowingSettings())
    assert slid is not None
    return (300.0 - float(slid.path.curve[0].real)) / WIDTH


@pytest.mark.parametrize("way_widths", [-1.0, 0.0, 1.0])
def test_an_end_goes_on_as_it_went(way_widths):
    assert first_end_after(way_widths) == pytest.approx(way_widths, abs=0.2)
