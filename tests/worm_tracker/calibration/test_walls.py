"""Walls are seen on their own circles, also where other circles are given for them."""

import math
import re

import numpy as np
import pytest
from crawling_worm import SMALL_RIG, TWO_CHAMBERS, crawl, wall_path
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_model.simulator.rig import draw
from worm_tracker.calibration.calibrate import CalibrationSettings
from worm_tracker.calibration.circle_fit import FittedCircle
from worm_tracker.calibration.rig_monitor import RigMonitor, RigMonitorSettings
from worm_tracker.calibration.walls import WallSettings, seen_walls, walls_again
from worm_tracker.parameters import TrackerParameters

LENGTH, WIDTH = 110.0, 12.0
BODY = crawl(wall_path(SMALL_RIG, WIDTH), LENGTH, WIDTH, [2.2 * LENGTH])[0]
PICTURE = draw(SMALL_RIG, BODY, 0)
HOW = WallSettings(), CalibrationSettings()
MOST_PX = HOW[0].most_beside_px


def monitor(picture=PICTURE, **circles):
    return RigMonitor(picture, TrackerParameters(**circles), 0, RigMonitorSettings())


def given_circle(right_px=0.0, down_px=0.0, larger_px=0.0):
    u, v = SMALL_RIG.centre_px
    return {
        "centre_u_px": u + right_px,
        "centre_v_px": v + down_px,
        "radius_px": SMALL_RIG.radius_px + larger_px,
    }


@settings(max_examples=15, deadline=None)
@given(right_px=st.floats(-3.0, 3.0), down_px=st.floats(-3.0, 3.0), larger_px=st.floats(-2.5, 2.5))
def test_a_given_circle_off_its_wall_is_said_with_the_one_that_is_on_it(
    right_px, down_px, larger_px
):
    advice = monitor(**given_circle(right_px, down_px, larger_px)).advice
    off_px = math.hypot(right_px, down_px) + abs(larger_px)
    if abs(off_px - MOST_PX) > 0.3:
        assert bool(advice) == (off_px > MOST_PX)
    if advice:
        assert "\n" not in advice
        u, v, r = map(float, re.search(r"--circle-px (\S+) (\S+) (\S+)$", advice).groups())
        assert (u, v) == pytest.approx(SMALL_RIG.centre_px, abs=0.15)
        assert r == pytest.approx(SMALL_RIG.radius_px, rel=1e-3)
        assert monitor(centre_u_px=u, centre_v_px=v, radius_px=r).advice == ""


def test_of_two_given_circles_the_one_that_is_off_is_named():
    a, b = TWO_CHAMBERS.chambers
    circles = {
        "centre_u_px": a.centre_u_px,
        "centre_v_px": a.centre_v_px,
        "radius_px": a.radius_px,
        "centre_b_u_px": b.centre_u_px + 4.0,
        "centre_b_v_px": b.centre_v_px,
        "radius_b_px": b.radius_px,
    }
    body = crawl(wall_path(TWO_CHAMBERS, 6.0), 80.0, 6.0, [180.0])[0]
    advice = monitor(draw(TWO_CHAMBERS, body, 0), **circles).advice
    assert advice.startswith("--circle-b-px is off")
    assert "4.0 px" in advice


def test_a_circle_that_was_found_is_its_wall():
    rig = monitor()
    (wall,) = seen_walls(PICTURE, rig.assumed.chambers, TrackerParameters(), *HOW)
    (found,) = rig.assumed.chambers
    assert (wall.u, wall.v, wall.radius) == (
        found.centre_u_px,
        found.centre_v_px,
        found.radius_px,
    )
    assert rig.advice == ""


def test_no_wall_is_seen_where_a_circle_of_another_size_is_given():
    parameters = TrackerParameters(**given_circle(larger_px=0.05 * SMALL_RIG.radius_px))
    chambers = RigMonitor(PICTURE, parameters, 0, RigMonitorSettings()).assumed.chambers
    assert seen_walls(PICTURE, chambers, parameters, *HOW) == ()


def test_a_given_wall_that_has_gone_is_not_found_on_the_given_circle():
    parameters = TrackerParameters(**given_circle())
    walls = (FittedCircle(*SMALL_RIG.centre_px, SMALL_RIG.radius_px),)
    covered = np.full_like(PICTURE, 180)
    assert walls_again(covered, walls, parameters, 0, *HOW) == ()
    assert walls_again(PICTURE, walls, parameters, 0, *HOW) != ()
