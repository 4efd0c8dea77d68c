"""What the tracker says of films whose truth is known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from crawling_worm import (
    FRAME_NS,
    LARGE_RIG,
    SMALL_RIG,
    arc,
    crawl,
    errors,
    film,
    radial_path,
    track,
    wall_path,
    wavy_path,
)

from worm_model.simulator.rig import Rig, draw, truth_of
from worm_msgs_py import Status, Where
from worm_msgs_py.errors import NoChamberFound, NotAPicture
from worm_tracker.detection.polarity import Polarity
from worm_tracker.following.follower_settings import FollowerSettings
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker, TrackerSettings

LENGTH, WIDTH = 110.0, 12.0
"""A stout worm in the small rig."""


def statuses(given):
    return [tracked.state.status for tracked in given]


def stout_worm(frames=50, step=2.0, rig=SMALL_RIG, path=wavy_path):
    line = path(rig) if path is wavy_path else path(rig, WIDTH)
    return crawl(line, LENGTH, WIDTH, LENGTH + step * np.arange(frames))


@pytest.mark.parametrize(
    ("path", "length", "width", "step"),
    [
        pytest.param(lambda rig: wall_path(rig, 16.0), 800.0, 16.0, 8.0, id="long, at the wall"),
        pytest.param(wavy_path, 800.0, 16.0, 8.0, id="long, winding"),
        pytest.param(lambda rig: wall_path(rig, 18.0), 110.0, 18.0, 3.0, id="stout, at the wall"),
    ],
)
def test_the_body_is_found_below_a_pixel(path, length, width, step):
    bodies = crawl(path(LARGE_RIG), length, width, length + step * np.arange(40))
    _, given = track(film(LARGE_RIG, bodies))
    found = errors(LARGE_RIG, bodies, given)
    assert found.tracked == 1.0
    assert found.right_head.mean() >= 0.95
    assert np.median(found.head) < 0.5
    assert np.median(found.tail) < 0.6
    assert np.median(found.centroid) < 0.3
    assert np.median(found.midline) < 0.5
    lengths = [tracked.state.length_px for tracked in given]
    assert np.median(lengths) == pytest.approx(length, rel=0.02)


def test_metric_coordinates_are_those_of_the_chambers_frame():
    bodies = stout_worm(30)
    tracker, given = track(film(SMALL_RIG, bodies))
    for body, tracked in zip(bodies, given, strict=True):
        state = tracked.state
        truth = truth_of(SMALL_RIG, body, state.frame, state.stamp_ns)
        assert state.frame_id == "chamber_a"
        assert state.where is Where.CHAMBER_A
        assert state.geometry == tracker.geometry.version == 1
        assert state.head.x_m * 1e3 == pytest.approx(truth.head_x_mm, abs=0.15)
        assert state.head.y_m * 1e3 == pytest.approx(truth.head_y_mm, abs=0.15)
        assert state.length_m * 1e3 == pytest.approx(truth.length_mm, rel=0.05)
        assert state.width_m * 1e3 == pytest.approx(truth.width_mm, rel=0.08)
        to_head = math.atan2(
            state.head.y_m - state.centroid.y_m, state.head.x_m - state.centroid.x_m
        )
        assert math.isclose(state.centroid.yaw_rad, to_head, abs_tol=1e-9)
        x, y = tracker.geometry.chambers[0].to_metres(tracked.midline.u_px, tracked.midline.v_px)
        np.testing.assert_allclose([x, y], [tracked.midline.x_m, tracked.midline.y_m])
        assert (tracked.midline.u_px[0], tracked.midline.v_px[0]) == pytest.approx(
            (state.head.u_px, state.head.v_px)
        )


def test_a_mirrored_film_flips_y_and_the_turns_and_nothing_else():
    pictures = film(SMALL_RIG, stout_worm(40))
    _, given = track(pictures)
    _, mirrored = track([np.ascontiguousarray(picture[::-1]) for picture in pictures])
    for one, other in zip(given, mirrored, strict=True):
        a, b = one.state, other.state
        assert (a.status, a.where, a.frame_id) == (b.status, b.where, b.frame_id)
        assert a.length_px == pytest.approx(b.length_px, abs=1.0)
        for name in ("head", "centroid", "tail"):
            p, q = getattr(a, name), getattr(b, name)
            assert p.u_px == pytest.approx(q.u_px, abs=0.5)
            assert p.v_px == pytest.approx(pictures[0].shape[0] - 1 - q.v_px, abs=0.5)
            assert p.x_m == pytest.approx(q.x_m, abs=3e-5)
            assert p.y_m == pytest.approx(-q.y_m, abs=3e-5)
            assert abs(math.sin(p.yaw_rad + q.yaw_rad)) < 0.1
            assert math.cos(p.yaw_rad + q.yaw_rad) > 0


def test_an_inverted_film_with_a_bright_worm_gives_the_same():
    pictures = film(SMALL_RIG, stout_worm(20))
    _, dark = track(pictures)
    _, bright = track([255 - picture for picture in pictures], polarity=Polarity.BRIGHT)
    assert [tracked.state for tracked in dark] == [tracked.state for tracked in bright]


def test_the_same_film_gives_the_same():
    pictures = film(SMALL_RIG, stout_worm(20))
    (_, one), (_, other) = track(pictures), track(pictures)
    assert repr([tracked.state for tracked in one]) == repr([tracked.state for tracked in other])


def test_a_worm_at_rest_from_the_first_frame_is_never_absorbed():
    (body,) = stout_worm(1, path=wall_path)
    pictures = [draw(SMALL_RIG, body, k) for k in range(24)]
    resting = [pictures[k % len(pictures)] for k in range(600)]
    moving = stout_worm(25, path=wall_path)
    _, given = track(resting + film(SMALL_RIG, moving))
    assert set(statuses(given)) == {Status.TRACKED}
    found = errors(SMALL_RIG, [body] * 600 + moving, given)
    assert found.head[500:600].max() < 1.5
    assert found.head[600:].max() < 1.5
    assert found.centroid.max() < 0.5


def test_flicker_does_not_move_the_worm():
    rng = np.random.default_rng(3)
    bodies = stout_worm(40)
    pictures = [
        np.clip(np.rint(picture * rng.uniform(0.8, 1.1)), 0, 255).astype(np.uint8)
        for picture in film(SMALL_RIG, bodies)
    ]
    _, given = track(pictures)
    found = errors(SMALL_RIG, bodies, given)
    assert found.tracked == 1.0
    assert np.median(found.head) < 0.6
    assert found.centroid.max() < 0.5


def test_every_picture_gives_one_state_however_bad_it_is():
    bodies = stout_worm(40)
    pictures = film(SMALL_RIG, bodies)
    bad = {
        5: np.zeros_like(pictures[0]),
        9: np.full_like(pictures[0], 255),
        13: np.empty((0, 0), np.uint8),
        17: pictures[0][:-1],
    }
    for frame, picture in bad.items():
        pictures[frame] = picture
    tracker, given = track(pictures)
    for tracked in given:
        state = tracked.state
        if state.frame in bad:
            assert state.status is Status.BAD_IMAGE
            assert math.isnan(state.head.u_px)
            assert len(tracked.midline.u_px) == 0
        else:
            assert state.status is Status.TRACKED
    assert tracker.statuses == {Status.BAD_IMAGE: 4, Status.TRACKED: 36}


@pytest.mark.parametrize(
    ("spoil", "cure"),
    [
        pytest.param(lambda grey: None, "uint8", id="none"),
        pytest.param(lambda grey: grey.tolist(), "uint8", id="list"),
        pytest.param(lambda grey: np.stack([grey] * 3, axis=2), "COLOR_BGR2GRAY", id="colour"),
        pytest.param(lambda grey: grey / 255.0, "astype", id="float"),
        pytest.param(lambda grey: grey.astype(np.uint16) << 4, "astype", id="16 bits"),
        pytest.param(lambda grey: grey > 100, "astype", id="mask"),
    ],
)
def test_what_is_no_grey_picture_is_refused_with_the_cure_and_no_frame_is_taken(spoil, cure):
    bodies = stout_worm(6)
    pictures = film(SMALL_RIG, bodies)
    tracker = Tracker(TrackerParameters())
    given = []
    for number, picture in enumerate(pictures):
        with pytest.raises(NotAPicture, match=cure):
            tracker.push(spoil(picture), number)
        given += tracker.push(picture, number * 40_000_000)
    given += tracker.finish()
    assert statuses(given) == [Status.TRACKED] * len(pictures)


def test_each_frame_brings_the_rig_that_it_rests_on():
    tracker = Tracker()
    given = tracker.push(np.zeros((64, 64), np.uint8), 0)
    for number, picture in enumerate(film(SMALL_RIG, stout_worm(5)), start=1):
        given += tracker.push(picture, number * 40_000_000)
    given += tracker.finish()
    assert given[0].geometry is None
    assert {frame.geometry.version for frame in given[1:]} == {given[1].state.geometry}


def test_without_a_worm_there_is_none():
    _, given = track([draw(SMALL_RIG, None, k) for k in range(20)])
    assert set(statuses(given)) == {Status.NO_WORM}


def test_a_worm_that_comes_and_goes_is_found_again():
    bodies = stout_worm(60)
    pictures = film(SMALL_RIG, bodies)
    gone = range(25, 35)
    for frame in (0, 1, 2, *gone):
        pictures[frame] = draw(SMALL_RIG, None, frame)
    _, given = track(pictures)
    for tracked in given:
        away = tracked.state.frame in (0, 1, 2, *gone)
        assert tracked.state.status is (Status.NO_WORM if away else Status.TRACKED)
    seen = [k for k in range(60) if k not in (0, 1, 2, *gone)]
    found = errors(SMALL_RIG, [bodies[k] for k in seen], [given[k] for k in seen])
    assert found.right_head.mean() >= 0.95


def test_the_head_is_in_the_passage_once_it_is_beyond_the_wall():
    path = radial_path(SMALL_RIG)
    heads = np.arange(LENGTH, arc(path)[-1] - 60, 5.0)
    bodies = crawl(path, LENGTH, WIDTH, heads)
    _, given = track(film(SMALL_RIG, bodies))
    right = 0
    for body, tracked in zip(bodies, given, strict=True):
        state = tracked.state
        truth = truth_of(SMALL_RIG, body, state.frame, state.stamp_ns)
        right += state.where.label == truth.where
    assert right >= len(bodies) - 1
    assert given[-1].state.where is Where.PASSAGE


def test_a_worm_that_leaves_the_picture_touches_its_border():
    path = radial_path(SMALL_RIG)
    rig = replace(SMALL_RIG, width_px=460)
    out = [k for k, u in enumerate(path[:, 0]) if u > rig.width_px + 20]
    bodies = crawl(path, LENGTH, WIDTH, np.linspace(LENGTH, arc(path)[out[0]], 40))
    _, given = track(film(rig, bodies))
    last = given[-1].state
    assert last.status is Status.TOUCHES_BORDER
    assert math.isnan(last.head.u_px)
    assert 0 < last.centroid.u_px < rig.width_px
    assert given[0].state.status is Status.TRACKED


def test_no_frame_waits_longer_than_it_may_and_a_late_decision_reaches_back():
    (still,) = stout_worm(1)
    bodies = [still] * 30 + stout_worm(40)
    pictures = film(SMALL_RIG, bodies)
    _, given = track(pictures)
    assert given[0].state.head_certainty >= 0.95
    assert errors(SMALL_RIG, bodies, given).right_head.all()

    tracker = Tracker(TrackerParameters(hold_back_frames=10))
    for frame, picture in enumerate(pictures[:30]):
        tracker.push(picture, frame * FRAME_NS)
        assert tracker.held <= 10


def test_pictures_without_a_chamber_end_with_the_remedy():
    rng = np.random.default_rng(0)
    plain = [
        np.clip(200 + 3 * rng.standard_normal((256, 256)), 0, 255).astype(np.uint8)
        for _ in range(12)
    ]
    with pytest.raises(NoChamberFound, match="--no-chamber"):
        track(plain)
    with pytest.raises(NoChamberFound, match="--no-chamber"):
        track(plain[:2])


def test_a_chamber_may_come_late():
    bodies = stout_worm(12)
    pictures = film(SMALL_RIG, bodies)
    for frame in range(4):
        pictures[frame] = np.random.default_rng(frame).integers(60, 90, pictures[0].shape, np.uint8)
    _, given = track(pictures)
    assert statuses(given)[:4] == [Status.NO_CHAMBER] * 4
    assert set(statuses(given)[4:]) == {Status.TRACKED}


def test_without_a_rig_there_are_pixels_and_a_scale_only_if_given():
    bodies = stout_worm(25)
    bare = Rig(
        width_px=512,
        height_px=512,
        px_per_mm=80.0,  # the wall is far outside the picture
        centre_px=SMALL_RIG.centre_px,
        optics=SMALL_RIG.optics,
    )
    pictures = film(bare, bodies)
    _, given = track(pictures, no_chamber=True)
    found = errors(bare, bodies, given)
    assert found.tracked == 1.0
    assert np.median(found.head) < 0.6
    state = given[0].state
    assert (state.frame_id, state.where, state.geometry) == (
        "camera_optical_frame",
        Where.UNKNOWN,
        0,
    )
    assert math.isnan(state.head.x_m)
    assert math.isnan(state.length_m)
    _, scaled = track(pictures, no_chamber=True, px_per_mm=80.0)
    assert scaled[0].state.length_m == pytest.approx(state.length_px / 80e3)


def test_a_constant_of_a_stage_can_be_changed():
    """With a body that nothing agrees with well enough, no midline is believed."""
    strict = TrackerSettings(follower=FollowerSettings(least_agreement=1.01))
    tracker = Tracker(TrackerParameters(), strict)
    given = []
    for frame, picture in enumerate(film(SMALL_RIG, stout_worm(3))):
        given += tracker.push(picture, frame * FRAME_NS)
    given += tracker.finish()
    assert statuses(given) == [Status.COILED] * 3
