"""Dirt under a worm that lay on it before it was known of: it is no part of the worm."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Status
from worm_tracker.detection.blobs import BlobSettings, around_all, find_blobs, whole_picture
from worm_tracker.detection.debris import DebrisSettings
from worm_tracker.detection.detection import Detection, SignalView
from worm_tracker.detection.dirt import LastPicture, dark_beside, specks
from worm_tracker.tracker import Tracker

SHAPE, LEVEL = (120, 160), 100
FIRST_OF_FOLD, FRAMES, SCALE = 60, 110, 30.0


def worm_and_speck(speck, radius=4):
    signal = np.zeros(SHAPE, np.uint8)
    cv2.line(signal, (30, 60), (130, 60), LEVEL, 9)
    cv2.circle(signal, speck, radius, LEVEL, -1)
    return signal


def beside(signal):
    window = whole_picture(SHAPE)
    worm = find_blobs(signal, LEVEL / 2, window, BlobSettings())[0]
    last = LastPicture(signal, 1.0, worm, LEVEL / 2)
    return dark_beside(signal, window, last, DebrisSettings())


@given(u=st.integers(20, 140), v=st.integers(15, 35) | st.integers(85, 105))
def test_a_speck_that_is_seen_beside_the_worm_is_dirt_and_the_worm_is_not(u, v):
    dirt = beside(worm_and_speck((u, v))) > 0
    speck = np.zeros(SHAPE, np.uint8)
    cv2.circle(speck, (u, v), 4, 1, -1)
    assert dirt[speck > 0].all()
    far = cv2.dilate(speck, np.ones((9, 9), np.uint8)) == 0
    assert not dirt[far].any()


def test_what_the_worm_touches_may_be_a_part_of_it():
    assert not beside(worm_and_speck((80, 68))).any()


def test_a_hair_is_no_speck():
    dirt = np.zeros(SHAPE, np.uint8)
    cv2.line(dirt, (5, 5), (150, 40), 255, 3)
    assert specks(dirt, 200.0) is None
    cv2.circle(dirt, (40, 90), 5, 255, -1)
    found = specks(dirt, 200.0)
    assert found is not None
    assert found[90, 40]
    assert not found[:60].any()


@given(
    v0=st.integers(0, 30),
    u0=st.integers(0, 30),
    height=st.integers(5, 60),
    width=st.integers(5, 60),
    far=st.tuples(st.integers(0, 20), st.integers(0, 20)),
)
def test_dirt_lies_in_an_objects_window_where_it_lies_in_the_picture(v0, u0, height, width, far):
    here = slice(v0 + far[0], v0 + far[0] + height), slice(u0 + far[1], u0 + far[1] + width)
    all_of_it = around_all([here, (slice(v0, v0 + 1), slice(u0, u0 + 1))])
    picture = np.arange(SHAPE[0] * SHAPE[1]).reshape(SHAPE).astype(np.uint8)
    signal = np.zeros((height, width), np.uint8)
    blob = find_blobs(worm_and_speck((80, 20)), LEVEL / 2, whole_picture(SHAPE), BlobSettings())[0]
    view = SignalView(here, signal, signal, LEVEL / 2, 1.0, BlobSettings())
    found = Detection(view, blob).with_dirt(picture[all_of_it], all_of_it)
    np.testing.assert_array_equal(found.dirt_in_window, picture[here])


@pytest.fixture(scope="module")
def fold():
    """Return a worm that lies across itself at first, and crawls out of it."""
    return list(SCENES["crossing"](Take(frames=FRAMES, px_per_mm=SCALE)))[FIRST_OF_FOLD:]


def on_speck(picture, at, radius):
    """Return a picture in which a speck lets a third of the light through."""
    drawn = np.zeros(picture.shape, np.float32)
    cv2.circle(drawn, [round(16 * x) for x in at], 16 * radius, 1.0, -1, cv2.LINE_AA, 4)
    return np.rint(picture * (1 - 0.65 * cv2.GaussianBlur(drawn, (0, 0), 1.0))).astype(np.uint8)


def test_a_fold_on_a_speck_is_told_once_the_worm_has_left_it(fold):
    """The speck is dark under one strand, as an overlap would be: nothing tells them apart yet."""
    first = fold[0].truth
    under = first.midline_u_px[40], first.midline_v_px[40]
    tracker, frames = Tracker(), []
    for shot in fold:
        frames += tracker.push(on_speck(shot.picture, under, 6), shot.stamp_ns)
    frames += tracker.finish()
    assert {frame.state.status for frame in frames} == {Status.FOLDED, Status.TRACKED}
    for frame, shot in zip(frames, fold, strict=True):
        line = np.stack([frame.midline.u_px, frame.midline.v_px], axis=1)
        true = np.stack([shot.truth.midline_u_px, shot.truth.midline_v_px], axis=1)
        at, even = np.linspace(0, 1, len(line)), np.linspace(0, 1, len(true))
        there = np.stack([np.interp(even, at, line[:, k]) for k in (0, 1)], axis=1)
        off = min(np.hypot(*(there - way).T).max() for way in (true, true[::-1]))
        assert off < 0.4 * SCALE, "within the body's width"
