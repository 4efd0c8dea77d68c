"""From chamber to chamber through the passage: where the head is, and in whose frame."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
from crawling_worm import NOISY, arc, crawl, errors, film, track, wavy_path
from scipy.interpolate import CubicSpline

from worm_model.simulator.rig import Rig, draw, truth_of
from worm_msgs_py import Status
from worm_tracker.calibration.calibrate import calibrate
from worm_tracker.parameters import TrackerParameters

RIG = Rig(
    width_px=1009,
    height_px=284,
    px_per_mm=13.0,
    centre_px=(145.3, 142.6),
    exit_rad=np.radians(1.0),
    exit_width_mm=1.0,
    chamber_b=True,
    optics=NOISY,
)
LENGTH, WIDTH = 195.0, 5.5
CIRCLING = 0.6
"""Radius, over R, of the turn that the worm makes in a chamber."""


def there_and_back(rig, touch_px):
    """Return a path from chamber a through the passage into chamber b and back to a.

    In the passage it swings from wall to wall: the midline comes as near to a wall as `touch_px`.
    """
    a, b = rig.chambers
    far, _ = a.to_metres(b.centre_u_px, b.centre_v_px)
    radius = a.radius_m
    swing = a.exit_width_m / 2 - touch_px / a.px_per_m

    def turn(x, first_deg, last_deg):
        phi = np.radians(np.linspace(first_deg, last_deg, 16))
        return np.stack([x + CIRCLING * radius * np.cos(phi), CIRCLING * radius * np.sin(phi)], 1)

    def through(x_from, x_to):
        x = np.linspace(x_from, x_to, 16)
        return np.stack([x, swing * np.sin(1300 * x)], 1)

    points = np.concatenate(
        [
            turn(0.0, 120, 300),
            [[0.9 * radius, -0.1 * radius]],
            through(1.1 * radius, far - 1.1 * radius),
            turn(far, 230, 470),
            [[far - 0.9 * radius, -0.05 * radius]],
            through(far - 1.1 * radius, 1.1 * radius),
            turn(0.0, -60, -300),
        ]
    )
    smooth = CubicSpline(arc(points), points)(np.linspace(0, arc(points)[-1], 20000))
    return np.stack(a.to_pixels(smooth[:, 0], smooth[:, 1]), axis=1)


@pytest.fixture(scope="module")
def trip():
    path = there_and_back(RIG, WIDTH / 2)
    bodies = crawl(path, LENGTH, WIDTH, np.arange(LENGTH, arc(path)[-1], 11.0))
    tracker, given = track(film(RIG, bodies))
    return bodies, tracker, given


def test_the_worm_is_followed_through_the_passage_and_back(trip):
    bodies, _, given = trip
    found = errors(RIG, bodies, given)
    assert found.tracked == 1.0
    assert found.right_head.all()
    assert np.median(found.head) < 0.5
    assert np.quantile(found.head, 0.95) < 1.5
    assert np.median(found.midline) < 0.5
    assert np.median(found.centroid) < 0.3


def test_where_is_right_in_every_frame(trip):
    bodies, _, given = trip
    for body, tracked in zip(bodies, given, strict=True):
        head = body.points_px[0]
        edge = min(
            abs(np.hypot(*(head - (c.centre_u_px, c.centre_v_px))) - c.radius_px)
            for c in RIG.chambers
        )
        if edge > 1.5:  # the head tip's largest error: on the line itself it is either
            truth = truth_of(RIG, body, tracked.state.frame, tracked.state.stamp_ns)
            assert tracked.state.where.label == truth.where
    order = [place for place, _ in groupby(tracked.state.where.label for tracked in given)]
    assert order == ["chamber_a", "passage", "chamber_b", "passage", "chamber_a"]


def test_coordinates_are_in_the_frame_of_the_chamber_that_the_head_was_in_last(trip):
    _, tracker, given = trip
    places = [(tracked.state.where.label, tracked.state.frame_id) for tracked in given]
    assert [place for place, _ in groupby(places)] == [
        ("chamber_a", "chamber_a"),
        ("passage", "chamber_a"),
        ("chamber_b", "chamber_b"),
        ("passage", "chamber_b"),
        ("chamber_a", "chamber_a"),
    ]
    for tracked in given:
        head = tracked.state.head
        chamber = tracker.geometry.chamber(tracked.state.frame_id)
        assert (head.x_m, head.y_m) == pytest.approx(chamber.to_metres(head.u_px, head.v_px))
        if tracked.state.where.label == "passage":
            assert head.x_m > 0
            assert abs(head.y_m) < chamber.exit_width_m / 2


def test_each_x_axis_points_to_its_own_exit_and_the_passage_has_its_length(trip):
    _, tracker, _ = trip
    geometry = tracker.geometry
    for found, true in zip(geometry.chambers, RIG.chambers, strict=True):
        assert abs(np.angle(np.exp(1j * (found.exit_rad - true.exit_rad)))) < np.radians(0.3)
    assert geometry.passage_length_m == pytest.approx(35e-3, abs=2e-5)


def test_an_exit_that_the_worm_hides_is_told_from_the_other_end():
    a, _ = RIG.chambers
    rig = replace(RIG, exit_width_mm=0.5)
    x = np.linspace(0.4, 1.9, 200) * a.radius_m
    plugged = np.stack(a.to_pixels(x, 0 * x), axis=1)
    (body,) = crawl(plugged, arc(plugged)[-1] - 1, 6.6, [arc(plugged)[-1]])  # as wide as the exit
    found = calibrate(draw(rig, body, 0), TrackerParameters(), 0).chambers
    for chamber, true in zip(found, rig.chambers, strict=True):
        assert abs(np.angle(np.exp(1j * (chamber.exit_rad - true.exit_rad)))) < np.radians(0.3)
        assert chamber.exit_width_m == pytest.approx(0.5e-3, abs=1.0 / a.px_per_m)


def test_a_passage_that_ends_in_view_is_followed_to_its_end():
    rig = replace(RIG, chamber_b=False, passage_length_mm=25.0)
    bodies = crawl(wavy_path(rig), LENGTH, WIDTH, LENGTH + 8.0 * np.arange(25))
    _, given = track(film(rig, bodies))
    assert {tracked.state.status for tracked in given} == {Status.TRACKED}
    assert np.median(errors(rig, bodies, given).head) < 0.5
