"""What is glare is white over many pixels: noise makes single ones white in bright water."""

import cv2
import numpy as np
import pytest

from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Status
from worm_tracker.detection.glare import glare_in, glare_limit
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

BRIGHT, NOISE, OVER_CLEAR = 228, 8.0, 20


def noisy(picture, seed):
    """Return a picture with noise as of a camera in too little light."""
    noise = np.random.default_rng(seed).normal(0.0, NOISE, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


def limit_of(shape):
    return glare_limit(np.full(shape, BRIGHT, np.uint8), OVER_CLEAR)


@pytest.mark.parametrize("seed", range(5))
def test_noise_in_bright_water_is_no_glare(seed):
    picture = noisy(np.full((600, 600), BRIGHT), seed)
    limit = limit_of(picture.shape)
    assert (picture > limit).sum() > 500
    assert not glare_in(picture, limit).any()


@pytest.mark.parametrize("radius_px", [3, 8, 30])
def test_a_spot_is_glare_where_it_is(radius_px):
    spot = np.zeros((120, 120), np.uint8)
    cv2.circle(spot, (60, 60), radius_px, 1, cv2.FILLED)
    seen = (
        glare_in(
            np.where(spot > 0, 255, noisy(np.full(spot.shape, 200), 0)).astype(np.uint8),
            limit_of(spot.shape),
        )
        > 0
    )
    assert not (seen & (spot == 0)).any()
    assert seen.sum() == spot.sum()


def test_a_worm_in_bright_water_is_followed_through_noise():
    """Each white pixel was glare, which may hide the worm, and made the water about it brighter."""
    tracker, given = Tracker(TrackerParameters()), []
    for frame, shot in enumerate(SCENES["there_and_back"](Take(px_per_mm=30.0, frames=30))):
        brighter = shot.picture * (BRIGHT / np.quantile(shot.picture, 0.9))
        given += tracker.push(noisy(brighter, frame), shot.stamp_ns)
    given += tracker.finish()
    assert {each.state.status for each in given} == {Status.TRACKED}
