"""The rig is watched: a bump is seen, said and followed; a hidden exit is found when it shows."""

import math
from dataclasses import replace

import numpy as np
import pytest
from crawling_worm import (
    FRAME_NS,
    LARGE_RIG,
    SMALL_RIG,
    TWO_CHAMBERS,
    arc,
    around,
    crawl,
    errors,
    film,
    radial_path,
    track,
    wall_path,
    wavy_path,
)

from worm_model.simulator.rig import draw
from worm_msgs_py import Status
from worm_tracker.calibration import walls
from worm_tracker.calibration.motion_detector import MotionDetector
from worm_tracker.calibration.rig_monitor import RigMonitorSettings
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker, TrackerSettings

LENGTH, WIDTH = 110.0, 12.0


def moved(rig, right_px, down_px, turn_deg):
    """Return the rig elsewhere in the picture, turned counter-clockwise about chamber a."""
    centre = (rig.centre_px[0] + right_px, rig.centre_px[1] + down_px)
    return replace(rig, centre_px=centre, exit_rad=rig.exit_rad + np.radians(turn_deg))


def bumped_film(rig, after, at, frames, *, length=LENGTH, width=WIDTH, step=2.0):
    """Return pictures, bodies and the rig of each frame; the worm touches the wall."""
    # It starts beyond the exit, which it would hide.
    heads = length + 0.9 * rig.radius_px + step * np.arange(frames)
    before_, after_ = (crawl(wall_path(r, width), length, width, heads) for r in (rig, after))
    bodies = before_[:at] + after_[at:]
    rigs = [rig] * at + [after] * (frames - at)
    pictures = [draw(r, body, k) for k, (r, body) in enumerate(zip(rigs, bodies, strict=True))]
    return pictures, bodies


def assert_same(found, true):
    """The bars of a calibration: centre 0.15 px, radius 0.1 %, exit 0.3 degrees."""
    off = np.hypot(found.centre_u_px - true.centre_u_px, found.centre_v_px - true.centre_v_px)
    assert off <= 0.15
    assert abs(found.radius_px / true.radius_px - 1) <= 1e-3
    turn = np.angle(np.exp(1j * (found.exit_rad - true.exit_rad)))
    assert abs(np.degrees(turn)) <= 0.3
    assert abs(found.exit_width_m - true.exit_width_m) * true.px_per_m < 1.0


@pytest.mark.parametrize(
    ("right", "down", "turn_deg"),
    [
        pytest.param(-4.0, 1.4, 0.0, id="four pixels aside"),
        pytest.param(0.4, 0.5, 0.0, id="less than a pixel"),
        pytest.param(0.0, 0.0, 1.0, id="turned about the centre"),
        pytest.param(7.0, -13.0, -3.0, id="far, and turned"),
    ],
)
def test_a_bump_is_seen_at_once_and_followed(right, down, turn_deg):
    after = moved(SMALL_RIG, right, down, turn_deg)
    pictures, bodies = bumped_film(SMALL_RIG, after, at=25, frames=45)
    tracker, given = track(pictures)
    (change,) = tracker.changes
    assert (change.geometry.version, change.geometry.stamp_ns) == (2, 25 * FRAME_NS)
    assert "moved" in change.why
    assert_same(tracker.geometry.chambers[0], after.chambers[0])
    assert [tracked.state.geometry for tracked in given] == [1] * 25 + [2] * 20
    assert {tracked.state.status for tracked in given} == {Status.TRACKED}
    found = errors(SMALL_RIG, bodies, given)
    assert found.right_head.all()
    assert np.median(found.head[25:]) < 0.5
    assert found.head[25:].max() < 1.5
    # The metric head is right too: it rests on the new centre.
    for body, tracked in zip(bodies[25:], given[25:], strict=True):
        x, y = after.chambers[0].to_metres(*map(float, body.points_px[0]))
        off_m = math.hypot(tracked.state.head.x_m - x, tracked.state.head.y_m - y)
        assert off_m * after.px_per_mm * 1e3 < 1.6


def test_a_megapixel_rig_is_found_again_by_a_hundredth_of_a_pixel():
    after = moved(LARGE_RIG, 3.1, -2.2, 0.4)
    pictures, bodies = bumped_film(
        LARGE_RIG, after, at=12, frames=20, length=800.0, width=16.0, step=8.0
    )
    tracker, given = track(pictures)
    assert [change.geometry.stamp_ns for change in tracker.changes] == [12 * FRAME_NS]
    found, true = tracker.geometry.chambers[0], after.chambers[0]
    off = np.hypot(found.centre_u_px - true.centre_u_px, found.centre_v_px - true.centre_v_px)
    assert off < 0.03
    assert_same(found, true)
    assert errors(LARGE_RIG, bodies, given).head.max() < 1.5


def test_a_slow_drift_is_followed():
    rigs = [moved(SMALL_RIG, 0.05 * k, -0.03 * k, 0.0) for k in range(60)]
    heads = LENGTH + 2.0 * np.arange(60)
    bodies = [
        crawl(wall_path(rig, WIDTH), LENGTH, WIDTH, [head])[0]
        for rig, head in zip(rigs, heads, strict=True)
    ]
    tracker, given = track(
        [draw(r, b, k) for k, (r, b) in enumerate(zip(rigs, bodies, strict=True))]
    )
    found = errors(SMALL_RIG, bodies, given)
    assert found.tracked == 1.0
    assert np.median(found.head) < 0.5
    assert len(tracker.changes) >= 3
    last, true = tracker.geometry.chambers[0], rigs[-1].chambers[0]
    off = np.hypot(last.centre_u_px - true.centre_u_px, last.centre_v_px - true.centre_v_px)
    assert off < 0.6  # what a drift may amount to before it is told from noise


@pytest.mark.parametrize("path", [wall_path, wavy_path])
def test_nothing_is_said_of_a_rig_that_stays(path):
    line = path(SMALL_RIG) if path is wavy_path else path(SMALL_RIG, WIDTH)
    bodies = crawl(line, LENGTH, WIDTH, LENGTH + 180.0 + 6.0 * np.arange(80))
    rng = np.random.default_rng(1)
    pictures = [
        np.clip(np.rint(picture * rng.uniform(0.85, 1.1)), 0, 255).astype(np.uint8)
        for picture in film(SMALL_RIG, bodies)
    ]
    tracker, _ = track(pictures)
    assert tracker.changes == []
    assert tracker.geometry.version == 1


def test_a_worm_along_half_of_the_wall_is_no_bump():
    length = 1.2 * np.pi * SMALL_RIG.radius_px
    bodies = crawl(wall_path(SMALL_RIG, 8.0, depth=0.0), length, 8.0, length + 15.0 * np.arange(30))
    tracker, _ = track(film(SMALL_RIG, bodies))
    assert all(change.motion is None for change in tracker.changes)


def test_both_chambers_move_together():
    rig = TWO_CHAMBERS
    after = moved(rig, 2.4, 3.3, 0.4)
    pictures, bodies = bumped_film(rig, after, at=14, frames=24, length=80.0, width=6.0)
    tracker, given = track(pictures)
    assert [change.geometry.stamp_ns for change in tracker.changes] == [14 * FRAME_NS]
    for found, true in zip(tracker.geometry.chambers, after.chambers, strict=True):
        assert_same(found, true)
    assert errors(rig, bodies, given).head.max() < 1.5


def circle_beside(rig, right_px=0.0, larger_px=0.0):
    u, v = rig.centre_px
    return {"centre_u_px": u + right_px, "centre_v_px": v, "radius_px": rig.radius_px + larger_px}


@pytest.mark.parametrize(
    ("right", "down", "turn_deg"),
    [
        pytest.param(0.4, 0.5, 0.0, id="less than a pixel"),
        pytest.param(7.0, -13.0, -3.0, id="far, and turned"),
    ],
)
@pytest.mark.parametrize(
    ("right_px", "larger_px"),
    [pytest.param(0.0, 0.0, id="on the wall"), pytest.param(1.2, 2.5, id="beside it")],
)
def test_a_given_circle_is_bumped_as_far_as_its_wall(right, down, turn_deg, right_px, larger_px):
    after = moved(SMALL_RIG, right, down, turn_deg)
    pictures, bodies = bumped_film(SMALL_RIG, after, at=25, frames=45)
    tracker, states = track(pictures, **circle_beside(SMALL_RIG, right_px, larger_px))
    (bump,) = (change for change in tracker.changes if change.motion is not None)
    assert bump.geometry.stamp_ns == 25 * FRAME_NS
    found, asked = tracker.geometry.chambers[0], circle_beside(after, right_px, larger_px)
    off = found.centre_u_px - asked["centre_u_px"], found.centre_v_px - asked["centre_v_px"]
    assert np.hypot(*off) <= 0.15
    assert found.radius_px == asked["radius_px"]
    turn = np.angle(np.exp(1j * (found.exit_rad - after.exit_rad)))
    assert abs(np.degrees(turn)) <= 0.3 + np.degrees(right_px / SMALL_RIG.radius_px)
    assert errors(SMALL_RIG, bodies, states).head[25:].max() < 1.5


def test_a_given_circle_without_a_wall_stays_where_it_is():
    water = np.full((SMALL_RIG.height_px, SMALL_RIG.width_px), 180, np.uint8)
    bodies = crawl(wavy_path(SMALL_RIG), LENGTH, WIDTH, LENGTH + 2.0 * np.arange(20))
    pictures = []
    for frame, picture in enumerate(film(SMALL_RIG, bodies)):
        rows, columns = np.indices(water.shape)
        u, v = SMALL_RIG.centre_px
        is_inside = np.hypot(columns - u, rows - v) < 0.9 * SMALL_RIG.radius_px
        pictures.append(np.roll(np.where(is_inside, picture, water), 3 * (frame > 9), axis=1))
    tracker, states = track(pictures, **circle_beside(SMALL_RIG))
    assert tracker.changes == []
    assert tracker.geometry.chambers[0].centre_u_px == SMALL_RIG.centre_px[0]
    assert {tracked.state.status for tracked in states} == {Status.TRACKED}


def out_of_the_exit(frames=80, width=WIDTH, rig=SMALL_RIG):
    """Return a worm that lies in the exit at first and then backs off into the chamber."""
    path = radial_path(rig)
    wall = np.argmax(np.hypot(*(path - rig.centre_px).T) > rig.radius_px)
    start = arc(path)[wall] + 45.0
    heads = np.concatenate([np.full(8, start), np.linspace(start, 2.2 * LENGTH, frames - 8)])
    return crawl(path, LENGTH, width, heads)


def test_an_exit_that_the_worm_hides_is_measured_once_it_shows():
    bodies = out_of_the_exit()
    tracker = Tracker(TrackerParameters())
    versions = []
    given = []
    for frame, picture in enumerate(film(SMALL_RIG, bodies)):
        given += tracker.push(picture, frame * FRAME_NS)
        versions.append(tracker.geometry)
    given += tracker.finish()
    first, last = versions[0], versions[-1]
    assert math.isnan(first.chambers[0].exit_width_m)
    assert (first.version, last.version) == (1, 2)
    assert "exit" in tracker.changes[0].why
    assert last.stamp_ns == tracker.changes[0].geometry.stamp_ns > 8 * FRAME_NS
    assert_same(last.chambers[0], SMALL_RIG.chambers[0])
    assert [tracked.state.frame for tracked in given] == list(range(len(bodies)))
    found = errors(SMALL_RIG, bodies, given)
    assert found.tracked == 1.0
    assert np.median(found.head) < 0.5
    places = set()
    for tracked in given:
        # It backs off: until it turns round its tail may well be taken for the head.
        head = (tracked.state.head.u_px, tracked.state.head.v_px)
        if abs(np.hypot(*np.subtract(head, SMALL_RIG.centre_px)) - 200.0) > 7.0:
            assert tracked.state.where is SMALL_RIG.where(*head)
            places.add(tracked.state.where)
    assert places


def test_a_hidden_exit_is_measured_later_where_the_circle_is_given_too():
    tracker, _ = track(film(SMALL_RIG, out_of_the_exit()), **circle_beside(SMALL_RIG))
    assert [change.motion for change in tracker.changes] == [None]
    assert_same(tracker.geometry.chambers[0], SMALL_RIG.chambers[0])


def test_a_worm_that_fills_the_exit_does_not_hide_it_for_ever():
    rig = replace(SMALL_RIG, exit_width_mm=0.5)
    bodies = out_of_the_exit(width=9.0, rig=rig)
    tracker, given = track(film(rig, bodies))
    assert_same(tracker.geometry.chambers[0], rig.chambers[0])
    assert given[-1].state.status is Status.TRACKED


def exit_off_sd(found, true):
    """Return by how many of its standard deviations the width of an exit is off."""
    return abs(found.exit_width_m - true.exit_width_m) / found.exit_width_sd_m


def before_the_exit(inside_px, beyond_px=0.0):
    """Return a path along the wall, so far inside it, and where on it the exit's middle lies."""
    phi = SMALL_RIG.exit_rad + np.linspace(-2.5, 2.5, 20000)
    path = around(SMALL_RIG, phi, np.full_like(phi, SMALL_RIG.radius_px - inside_px))
    return path, arc(path)[10000] + LENGTH / 2 + beyond_px


@pytest.mark.parametrize("inside_px", [12.0, 17.0, 26.0])
@pytest.mark.parametrize("beyond_px", [-60.0, 0.0, 40.0])
def test_no_worm_before_the_exit_makes_its_width_sure_and_wrong(inside_px, beyond_px):
    path, head = before_the_exit(inside_px, beyond_px)
    tracker = Tracker()
    tracker.push(film(SMALL_RIG, crawl(path, LENGTH, WIDTH, [head]))[0], 0)
    found = tracker.geometry.chambers[0]
    hidden = math.isnan(found.exit_width_m)
    assert hidden or exit_off_sd(found, SMALL_RIG.chambers[0]) < 4.0


def test_the_width_is_measured_once_the_worm_has_left_the_water_before_the_exit():
    path, head = before_the_exit(17.0)
    heads = head + np.concatenate([np.zeros(8), np.linspace(0.0, 150.0, 40)])
    tracker, _ = track(film(SMALL_RIG, crawl(path, LENGTH, WIDTH, heads)))
    (change,) = tracker.changes
    assert "found" in change.why
    assert exit_off_sd(tracker.geometry.chambers[0], SMALL_RIG.chambers[0]) < 4.0


def test_a_worm_in_the_exit_of_one_chamber_leaves_that_of_the_other_in_view():
    rig = replace(TWO_CHAMBERS, exit_width_mm=2.0)
    path = radial_path(rig)
    head = arc(path)[np.argmax(np.hypot(*(path - rig.centre_px).T) > rig.radius_px)] + 20.0
    tracker = Tracker()
    tracker.push(film(rig, crawl(path, 80.0, 6.0, [head]))[0], 0)
    for found, true in zip(tracker.geometry.chambers, rig.chambers, strict=True):
        assert exit_off_sd(found, true) < 4.0


@pytest.mark.parametrize("disturbed", [0, 3])
def test_a_width_that_one_picture_of_many_shows_otherwise_is_corrected(disturbed):
    path, head = before_the_exit(90.0)
    pictures = film(SMALL_RIG, crawl(path, LENGTH, WIDTH, head + 1.0 * np.arange(8)))
    # What is no worm lies before the exit: the wall's grey, on all the water that W rests on.
    _, shaded = before_the_exit(12.0)
    lies = crawl(before_the_exit(12.0)[0], 60.0, 10.0, [shaded - LENGTH / 2 + 30.0])
    with_it = np.minimum(pictures[disturbed], film(SMALL_RIG, lies)[0])
    pictures[disturbed] = with_it
    first, later = frames_of_two_looks(pictures)
    true = SMALL_RIG.chambers[0]
    assert (exit_off_sd(first.chambers[0], true) > 4.0) == (disturbed == 0)
    assert exit_off_sd(later.chambers[0], true) < 4.0
    assert later.version == (2 if disturbed == 0 else 1)


def frames_of_two_looks(pictures):
    """Return the geometry of the first frame and of the last, looked at in frames 0, 1, 3 and 7."""
    rig = RigMonitorSettings(first_retry_ns=FRAME_NS)
    tracker = Tracker(TrackerParameters(), TrackerSettings(rig=rig))
    tracker.push(pictures[0], 0)
    first = tracker.geometry
    for frame, picture in enumerate(pictures[1:], 1):
        tracker.push(picture, frame * FRAME_NS)
    return first, tracker.geometry


def test_an_alarm_of_a_rig_that_stands_still_costs_no_search(monkeypatch):
    pictures, _ = bumped_film(SMALL_RIG, SMALL_RIG, 0, 8)
    tracker = Tracker(TrackerParameters())
    tracker.push(pictures[0], 0)
    monkeypatch.setattr(MotionDetector, "moved", lambda *_: True)
    monkeypatch.setattr(walls, "fit_circle", lambda *_: pytest.fail("it is looked for"))
    for k, picture in enumerate(pictures[1:], start=1):
        tracker.push(picture, k * FRAME_NS)
    assert not tracker.changes
