"""What else is in the picture does not move the worm: light, flicker, bubbles, rest, the wall."""

import math
from itertools import pairwise

import numpy as np
import pytest

from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker


def followed(scene, frames=45, px_per_mm=30.0):
    """Return the tracker, its frames, and the truth of each."""
    tracker, given, truth = Tracker(TrackerParameters()), [], []
    for shot in SCENES[scene](Take(px_per_mm=px_per_mm, frames=frames)):
        given += tracker.push(shot.picture, shot.stamp_ns)
        truth.append(shot.truth)
    given += tracker.finish()
    return tracker, given, truth


def off(point, truth, name):
    return math.hypot(
        point.u_px - getattr(truth, f"{name}_u_px"), point.v_px - getattr(truth, f"{name}_v_px")
    )


def tip_errors(given, truth):
    """Return the error of the head, or of the tail where the ends are exchanged; no coiled ones."""
    errors = []
    for tracked, true in zip(given, truth, strict=True):
        state = tracked.state
        if state.status is Status.TRACKED:
            ways = (
                (off(state.head, true, "head"), off(state.tail, true, "tail")),
                (off(state.tail, true, "head"), off(state.head, true, "tail")),
            )
            errors.append(min(ways, key=sum)[0])
    return np.array(errors)


@pytest.mark.parametrize(
    ("scene", "head_px", "centroid_px"),
    [
        ("flicker", 0.5, 0.3),
        ("light_drift", 0.5, 0.3),
        ("uneven_light", 0.5, 0.3),
        ("bubbles", 0.5, 0.3),
        # The mirror image lies beside the body for half of its length, and darkens that flank.
        ("reflection", 0.5, 0.5),
        # The wall cuts off the head's outer flank: what is seen of its end lies farther in.
        ("along_the_wall", 1.0, 0.3),
    ],
)
def test_the_head_stays_below_a_pixel(scene, head_px, centroid_px):
    tracker, given, truth = followed(scene)
    heads = tip_errors(given, truth)
    # The walks begin in a coil, 0.3 s long, before anything is known of the worm.
    tracked = [each.state.status is Status.TRACKED for each in given]
    assert all(tracked[5:])
    assert np.median(heads) <= head_px
    assert np.quantile(heads, 0.95) <= 1.5
    centroids = [
        off(tracked.state.centroid, true, "centroid")
        for tracked, true in zip(given, truth, strict=True)
        if tracked.state.status is Status.TRACKED
    ]
    assert np.median(centroids) <= centroid_px
    assert all(change.motion is None for change in tracker.changes), "nothing was bumped"
    for tracked, true in zip(given, truth, strict=True):
        if tracked.state.status is Status.TRACKED:
            assert tracked.state.where.label == true.where


def test_a_lamp_that_grows_until_the_water_is_white_hides_no_worm():
    """White water is no glare: nothing is occluded in it, and the worm is as dark as ever."""
    take = Take(frames=60, px_per_mm=20.0)
    tracker, given, truth = Tracker(TrackerParameters()), [], []
    for frame in SCENES["at_the_wall"](take):
        gain = 1.0 + 0.3 * len(truth) / take.frames
        picture = np.minimum(np.rint(gain * frame.picture), 255).astype(np.uint8)
        given += tracker.push(picture, frame.stamp_ns)
        truth.append(frame.truth)
    given += tracker.finish()
    assert (picture == 255).mean() > 0.2, "the water is white"
    assert {tracked.state.status for tracked in given[5:]} == {Status.TRACKED}
    heads = tip_errors(given, truth)
    assert np.median(heads) < 0.5
    assert heads.max() < 2.0


def test_a_hair_on_the_worm_makes_it_no_longer():
    """It lies on the worm's way, and hangs on to it from the 20th frame on."""
    _, given, truth = followed("hair", frames=40)
    statuses = [tracked.state.status for tracked in given]
    assert statuses.count(Status.TRACKED) >= 38
    heads = tip_errors(given, truth)
    assert np.median(heads) < 0.5
    assert heads.max() < 3.0


def test_a_worm_that_rests_for_minutes_is_never_absorbed():
    _, given, truth = followed("resting", frames=100, px_per_mm=20.0)
    rest_s = (truth[79].stamp_ns - truth[0].stamp_ns) / 1e9
    assert rest_s > 150
    assert {tracked.state.status for tracked in given} == {Status.TRACKED}
    heads = tip_errors(given, truth)
    assert heads.max() <= 1.5
    lengths = [tracked.state.length_px for tracked in given]
    assert max(lengths) / min(lengths) < 1.02


def test_a_bumped_camera_loses_no_frame():
    tracker, given, _ = followed("bumped_camera", frames=30)
    assert [tracked.state.frame for tracked in given] == list(range(30))
    versions = [tracked.state.geometry for tracked in given]
    assert versions == sorted(versions)
    assert [b - a for a, b in pairwise(versions)].count(1) == len(tracker.changes) == 1
    assert tracker.changes[0].motion is not None
