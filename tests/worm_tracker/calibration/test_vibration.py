"""A rig that vibrates stays where it is: its pictures are shifted back, and its worm followed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from crawling_worm import FRAME_NS, SMALL_RIG, crawl, errors, track, wall_path
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_model.simulator.rig import draw
from worm_msgs_py import Status
from worm_tracker.calibration.calibrate import CalibrationSettings, calibrate
from worm_tracker.calibration.motion_detector import MotionDetector, MotionDetectorSettings
from worm_tracker.calibration.vibration import Vibration, VibrationSettings, shifted
from worm_tracker.parameters import TrackerParameters

LENGTH, WIDTH, SECOND_NS = 110.0, 12.0, 1_000_000_000
BODY = crawl(wall_path(SMALL_RIG, WIDTH), LENGTH, WIDTH, [2.2 * LENGTH])[0]
GIVEN = {
    "centre_u_px": SMALL_RIG.centre_px[0],
    "centre_v_px": SMALL_RIG.centre_px[1],
    "radius_px": SMALL_RIG.radius_px,
}


def moved(rig, right_px, down_px):
    return replace(rig, centre_px=(rig.centre_px[0] + right_px, rig.centre_px[1] + down_px))


def walls_of(picture):
    geometry = calibrate(picture, TrackerParameters(), 0, CalibrationSettings())
    return MotionDetector(picture, geometry, MotionDetectorSettings())


@settings(max_examples=15, deadline=None)
@given(right_px=st.floats(-2.5, 2.5), down_px=st.floats(-2.5, 2.5))
def test_walls_tell_how_far_a_rig_is_shifted_though_the_worm_lies_along_one(right_px, down_px):
    walls = walls_of(draw(SMALL_RIG, BODY, 0))
    shift = walls.shift(draw(moved(SMALL_RIG, right_px, down_px), BODY, 1))
    assert shift == pytest.approx([right_px, down_px], abs=0.1)


@given(right_px=st.integers(-3, 3), down_px=st.integers(-3, 3))
def test_a_picture_that_is_shifted_by_whole_pixels_is_the_same_there(right_px, down_px):
    picture = np.random.default_rng(1).integers(0, 255, (40, 50)).astype(np.uint8)
    inner = np.s_[3 + down_px : 37 + down_px, 3 + right_px : 47 + right_px]
    assert np.array_equal(
        shifted(picture, np.array([right_px, down_px], float))[inner], picture[3:37, 3:47]
    )


@pytest.mark.parametrize(
    ("moves_px", "apart_s", "vibrates"),
    [
        pytest.param([(0.5, 0.0), (-0.6, 0.1), (0.4, -0.2)], 0.3, True, id="to and fro"),
        pytest.param([(0.5, 0.0), (0.6, 0.1), (0.4, -0.2)], 0.3, False, id="a drift"),
        pytest.param([(0.5, 0.0), (-0.6, 0.1)], 0.3, False, id="there and back once"),
        pytest.param([(0.5, 0.0), (-6.0, 1.0), (0.4, -0.2)], 0.3, False, id="a bump among them"),
        pytest.param([(0.5, 0.0), (-0.6, 0.1), (0.4, -0.2)], 20.0, False, id="in long times"),
    ],
)
def test_a_rig_vibrates_where_small_moves_lead_back_soon(moves_px, apart_s, vibrates):
    vibration = Vibration(VibrationSettings())
    for k, move_px in enumerate(moves_px):
        vibration.note_move(round(k * apart_s * SECOND_NS), np.array(move_px))
    assert vibration.is_on is vibrates


def vibrating_film(rigs):
    """Return pictures and bodies of a worm that crawls along the wall, the rig where it is."""
    heads = LENGTH + 0.9 * SMALL_RIG.radius_px + 2.0 * np.arange(len(rigs))
    path = wall_path(SMALL_RIG, WIDTH)
    still = crawl(path, LENGTH, WIDTH, heads)
    start = np.array(SMALL_RIG.centre_px)
    bodies = [
        replace(body, points_px=body.points_px + np.array(rig.centre_px) - start)
        for body, rig in zip(still, rigs, strict=True)
    ]
    return [
        draw(rig, body, k) for k, (rig, body) in enumerate(zip(rigs, bodies, strict=True))
    ], bodies


@pytest.mark.parametrize("circle", [{}, GIVEN], ids=["found", "given"])
def test_the_worm_of_a_rig_that_vibrates_is_told_where_it_is_in_the_chamber(circle):
    """Found anew each time, its wall was taken for a part of the worm, and folds were lost."""
    rng = np.random.default_rng(3)
    rigs = [moved(SMALL_RIG, *rng.normal(0.0, 0.6, 2)) for _ in range(90)]
    pictures, bodies = vibrating_film([SMALL_RIG, *rigs[1:]])
    tracker, given_ = track(pictures, **circle)
    changes = [change for change in tracker.changes if change.motion is not None]
    assert 3 <= len(changes) <= 4, "then it is known to vibrate"
    assert "to and fro" in changes[-1].why
    after = changes[-1].geometry.stamp_ns // FRAME_NS
    assert {tracked.state.status for tracked in given_[after:]} == {Status.TRACKED}
    assert errors(SMALL_RIG, bodies[after:], given_[after:]).right_head.all()
    for rig, body, tracked in list(zip(rigs, bodies, given_, strict=True))[after:]:
        x_m, y_m = rig.chambers[0].to_metres(*map(float, body.points_px[0]))
        off_m = math.hypot(tracked.state.head.x_m - x_m, tracked.state.head.y_m - y_m)
        assert off_m * rig.px_per_mm * 1e3 < 1.2


def test_a_rig_that_comes_to_rest_elsewhere_is_found_there():
    rng = np.random.default_rng(4)
    rest = moved(SMALL_RIG, 0.9, -0.7)
    rigs = [SMALL_RIG, *(moved(SMALL_RIG, *rng.normal(0.0, 0.6, 2)) for _ in range(40))]
    pictures, _ = vibrating_film([*rigs, *[rest] * 75])
    tracker, _ = track(pictures)
    found, true = tracker.geometry.chambers[0], rest.chambers[0]
    assert found.centre_u_px == pytest.approx(true.centre_u_px, abs=0.15)
    assert found.centre_v_px == pytest.approx(true.centre_v_px, abs=0.15)
