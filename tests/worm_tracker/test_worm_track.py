"""A bump of the camera takes all that is remembered of the worm along; nothing stays behind."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from crawling_worm import FRAME_NS, SMALL_RIG, crawl, wavy_path
from hypothesis import given
from hypothesis import strategies as st

from worm_model.simulator.rig import Body, draw
from worm_msgs_py import Status
from worm_tracker.detection.blobs import Blob
from worm_tracker.head_tail.identity import HeadTail, HeadTailSettings
from worm_tracker.midline.curve import as_points, transformed_points
from worm_tracker.midline.path import path_of
from worm_tracker.observation import Observation
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker
from worm_tracker.worm_track import PropagatedBody, WormTrack

LENGTH, WIDTH = 110.0, 12.0
REST = 12
"""Frames before the bump."""


def bumped_along_its_axis(bump_px):
    """Return pictures of a worm at rest whose camera is bumped along the worm's own axis."""
    (body,) = crawl(wavy_path(SMALL_RIG), LENGTH, WIDTH, [6.0 * LENGTH])
    along = body.points_px[0] - body.points_px[-1]
    shift = bump_px * along / np.hypot(*along)
    u, v = SMALL_RIG.centre_px
    rig = replace(SMALL_RIG, centre_px=(float(u + shift[0]), float(v + shift[1])))
    moved = Body.along(body.points_px + shift, WIDTH)
    before = [draw(SMALL_RIG, body, frame) for frame in range(REST)]
    return before + [draw(rig, moved, frame) for frame in range(REST, 2 * REST)]


@pytest.mark.parametrize("bump_px", [-8.0, 8.0])
def test_a_bump_is_no_crawling(bump_px):
    """Told as motion along the body it would count as a stride, and so decide the head."""
    certainties = []
    for bump in (0.0, bump_px):
        tracker, given = Tracker(TrackerParameters()), []
        for frame, picture in enumerate(bumped_along_its_axis(bump)):
            given += tracker.push(picture, frame * FRAME_NS)
        given += tracker.finish()
        assert len(tracker.changes) == bool(bump)
        assert {tracked.state.status for tracked in given} == {Status.TRACKED}
        certainties.append(given[-1].state.head_certainty)
    resting, bumped = certainties
    assert bumped == pytest.approx(resting, abs=0.01)


@given(
    turn=st.floats(-0.1, 0.1),
    right=st.floats(-30, 30),
    down=st.floats(-30, 30),
    step=st.floats(0, 3),
)
def test_the_log_odds_of_the_head_do_not_change_by_a_bump(turn, right, down, step):
    """The same bodies, in the coordinates before and after it."""
    c, s = np.cos(turn), np.sin(turn)
    motion = np.array([[c, s, right], [-s, c, down]])
    s = np.linspace(0, -100, 65)
    bodies = [np.stack([s + step * k, 8 * np.sin(s / 15)], axis=1) for k in range(12)]
    odds = []
    for bumped in (False, True):
        track = WormTrack()
        identity = HeadTail(track, HeadTailSettings())
        for k, points in enumerate(bodies):
            if bumped and k == 6:
                track.transform(motion)
            seen = transformed_points(points, motion) if bumped and k >= 6 else points
            identity.push(Observation(Status.TRACKED, points=seen, width=10.0))
        odds.append(identity.log_odds)
    assert odds[0] == pytest.approx(odds[1], abs=1e-9)


def test_every_place_that_is_remembered_moves():
    motion = np.array([[1.0, 0.0, 7.0], [0.0, 1.0, -3.0]])
    points = np.stack([np.linspace(10, 90, 65), np.full(65, 40.0)], axis=1)
    contour = np.array([[10, 35], [90, 35], [90, 45], [10, 45]], np.int32)
    track = WormTrack()
    propagated = PropagatedBody(path_of(points, None, 10.0), 0.9, 0.9)
    for _ in range(2):
        track.see(Blob(contour, 800.0, 0.0, 50.0, 40.0, (10, 35, 90, 45)), points, propagated)
    track.link(points)
    track.transform(motion)
    moved = points + np.array([7.0, -3.0])
    for place in (track.body, track.linked, track.bodies.last, track.bodies.before):
        np.testing.assert_allclose(place, moved)
    curve = as_points(track.bodies.propagated.path.curve)
    np.testing.assert_allclose(curve[[0, -1]], moved[[0, -1]])
    np.testing.assert_allclose(track.contour, contour + np.array([7, -3]))
    assert (track.blob.u, track.blob.v) == (57.0, 37.0)
    assert track.blob.box == (17, 32, 97, 42)


@pytest.mark.parametrize(
    ("folded_first", "frames", "in_part"),
    [
        pytest.param(20, 30, True, id="a fold, and few midlines since"),
        pytest.param(20, 200, False, id="a fold, long ago"),
        pytest.param(2, 30, False, id="open all but at once"),
    ],
)
def test_what_is_learned_of_a_worm_that_began_in_a_fold_may_be_a_part(
    folded_first, frames, in_part
):
    track = WormTrack()
    contour = np.array([[[0, 0]], [[9, 0]], [[9, 9]], [[0, 9]]], np.int32)
    blob = Blob(contour, 81.0, 0.0, 4.5, 4.5, (0, 0, 10, 10))
    for _ in range(folded_first):
        track.see(blob, None, None)
    model = SimpleNamespace(is_young=frames < 150, began_in_fold=track.was_folded_for_long)
    line = np.zeros((65, 2))
    track.learn(model)
    track.see(blob, line, None)
    assert track.prior.may_be_in_part is in_part
