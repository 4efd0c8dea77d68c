"""What the follower makes of an object that is more than the worm, or less than is seen of it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_by_discs import drawn_by_discs

from worm_msgs_py import Status
from worm_tracker.detection.blobs import BlobSettings, whole_picture
from worm_tracker.detection.detection import Detection, Occlusion, SignalView
from worm_tracker.following.follower import Follower
from worm_tracker.following.follower_settings import FollowerSettings
from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.path import path_of
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import PastDetection
from worm_tracker.worm_track import LastBodies, PropagatedBody, WormTrack

WIDTH, LENGTH, SHAPE = 12.0, 200.0, (120, 260)
FIRST, LAST = (30, 60), (230, 60)


def straight_body():
    """Return the midline of a worm that lies straight in the middle of the picture."""
    points = np.c_[np.linspace(FIRST[0], LAST[0], 65), np.full(65, 60.0)]
    widths, levels = np.full(65, WIDTH), np.full(65, 100.0)
    area = LENGTH * WIDTH
    return RefinedMidline(points, widths, widths, levels, 100.0, 1.0, area, 130.0, 60.0)


def object_of(signal):
    """Return the detection of what is drawn in a picture."""
    view = SignalView(whole_picture(SHAPE), signal, signal, 50.0, 1.0, BlobSettings())
    return Detection(view, view.blobs()[0])


def worm_with(hanging_on_px2):
    """Return a worm with something round, of some area, that touches its flank; and it alone."""
    worm = np.zeros(SHAPE, np.uint8)
    cv2.line(worm, FIRST, LAST, 100, round(WIDTH))
    both = worm.copy()
    radius = round(np.sqrt(hanging_on_px2 / np.pi))
    cv2.circle(both, (130, 60 + round(WIDTH / 2) + radius), radius, 100, -1)
    return object_of(both), object_of(worm)


def follower_that_knows_the_worm(frames_unresolved):
    track, found = WormTrack(), straight_body()
    model = BodyModel.of(found, LENGTH * WIDTH, 1.0, BodyModelSettings())
    track.learn(replace(model, frames=600, is_settled=True))
    track.frames_unresolved = frames_unresolved
    return Follower(track, SHAPE, FollowerSettings())


@pytest.mark.parametrize(
    ("widths2", "frames_unresolved", "is_part"),
    [
        pytest.param(0.8, 40, False, id="a speck beside a worm that comes out of a fold"),
        pytest.param(2.0, 40, True, id="an end that comes out of a fold"),
        pytest.param(2.0, 0, False, id="debris beside an open worm"),
    ],
)
def test_what_hangs_on_to_a_worm_after_a_fold_may_be_its_end(widths2, frames_unresolved, is_part):
    whole, view = worm_with(widths2 * WIDTH**2)
    follower = follower_that_knows_the_worm(frames_unresolved)
    assert follower._is_part(straight_body(), whole, view) is is_part


@pytest.mark.parametrize(
    "follower",
    [
        pytest.param(follower_that_knows_the_worm(frames_unresolved=0), id="the worm is known"),
        pytest.param(
            Follower(WormTrack(), SHAPE, FollowerSettings()), id="the film begins, maybe in a fold"
        ),
    ],
)
def test_a_thin_tail_that_was_cut_off_is_a_part_of_the_worm(follower):
    worm = np.zeros(SHAPE, np.uint8)
    cv2.line(worm, FIRST, LAST, 100, round(WIDTH))
    whole = worm.copy()
    cv2.line(whole, LAST, (LAST[0] + 4 * round(WIDTH), LAST[1]), 100, round(0.4 * WIDTH))
    found = straight_body()
    caps = np.array([[-WIDTH / 2, 0.0], [WIDTH / 2, 0.0]])  # its ends are round
    points = found.points + np.linspace(caps[0], caps[1], len(found.points))
    found = replace(found, points=points)
    assert follower._is_part(found, object_of(whole), object_of(worm))
    assert not follower._is_part(found, object_of(worm), object_of(worm))


@pytest.mark.parametrize(
    ("in_doubt", "status"),
    [
        pytest.param((0, 0), Status.BRIDGED, id="all is known"),
        pytest.param((20, 40), Status.COILED, id="a loop in doubt"),
    ],
)
def test_a_fold_under_glare_with_a_loop_in_doubt_waits_for_a_later_frame(
    monkeypatch, in_doubt, status
):
    detection, _ = worm_with(0.0)
    ends = np.array([FIRST, LAST], float)
    detection = replace(detection, occlusion=Occlusion(ends, (False, False)))
    found = straight_body()
    seen = Observation(
        Status.LOOP_IN_DOUBT if any(in_doubt) else Status.FOLDED,
        130.0,
        60.0,
        found.points,
        found.widths,
        1.0,
        WIDTH,
        in_doubt=in_doubt,
    )
    monkeypatch.setattr(Follower, "_observe", lambda *_: (seen, None))
    told = follower_that_knows_the_worm(0).push(detection)
    assert told.status is status
    assert (told.unresolved is not None) is (status is Status.COILED)


def tapered(points, widths, blunt):
    """Return a straight worm whose ends taper, the last one not where it is bent onto itself."""
    taper = np.clip(np.linspace(0.0, LENGTH / WIDTH, 65) / 1.6, 0.15, 1.0)
    both = widths * taper * taper[::-1]
    drawn = widths * taper if blunt else both
    signal = drawn_by_discs(SHAPE, points, drawn, level=100)
    return both, object_of(cv2.GaussianBlur(signal, (0, 0), 0.8))


@pytest.mark.parametrize("blunt", [False, True])
@pytest.mark.parametrize("way", ["there", "back"])
def test_a_followed_body_is_not_told_open_where_its_object_is_broad_at_an_end(
    monkeypatch, blunt, way
):
    """It covers the object; what sticks out beside its tapered end is as thin as an edge."""
    body = straight_body()
    widths, seen = tapered(body.points, body.widths, blunt)
    follower = follower_that_knows_the_worm(frames_unresolved=0)
    track = follower._track
    track.learn(replace(track.model, widths=widths, length=LENGTH))
    followed = PropagatedBody(path_of(body.points, None, WIDTH), 0.97, 0.97)
    track.bodies = LastBodies(body.points, body.points, followed)
    monkeypatch.setattr(follower, "_contour_body", lambda _: None)
    if way == "there":
        told = follower.push(seen)
    else:
        opened = Observation(Status.TRACKED, 130.0, 60.0, body.points, widths, 1.0, WIDTH)
        (told,) = follower.resolve_back(opened, [PastDetection(seen, 1)])
    assert told.shows_pose is not blunt
    assert told.status is (Status.END_HIDDEN if blunt else Status.TRACKED)
    if blunt:
        assert told.broad_ends == (False, True)
        assert told.occluded[1] > 0
    assert np.hypot(*(told.points - body.points).T).max() < WIDTH
