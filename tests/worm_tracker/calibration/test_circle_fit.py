"""A wall that is known is found again where it was, and not where it is no more."""

import numpy as np
import pytest
from crawling_worm import LARGE_RIG, SMALL_RIG, crawl, wall_path

from worm_model.simulator.rig import draw
from worm_tracker.calibration.circle_fit import (
    CircleFitSettings,
    FittedCircle,
    fit_circle,
    refit_circle,
)

SETTINGS = CircleFitSettings()


def circle(rig, right_px=0.0, wider_px=0.0):
    u, v = rig.centre_px
    return FittedCircle(u + right_px, v, rig.radius_px + wider_px)


@pytest.mark.parametrize("rig", [SMALL_RIG, LARGE_RIG])
@pytest.mark.parametrize("off_px", [(0.0, 0.0), (0.8, 0.0), (0.0, -0.8)])
def test_a_wall_is_found_again_as_by_a_search(rig, off_px):
    worm = crawl(wall_path(rig, 12.0), 110.0, 12.0, 110.0 + 0.9 * rig.radius_px + np.arange(1))[0]
    picture = draw(rig, worm, 0)
    found = refit_circle(picture, circle(rig, *off_px), SETTINGS)
    searched = fit_circle(picture, rig.centre_px, SETTINGS)
    assert np.hypot(found.u - searched.u, found.v - searched.v) < 0.02
    assert abs(found.radius - searched.radius) < 0.02


def test_a_wall_that_is_elsewhere_is_not_found():
    picture = draw(SMALL_RIG, None, 0)
    assert refit_circle(picture, circle(SMALL_RIG, right_px=60.0), SETTINGS) is None
