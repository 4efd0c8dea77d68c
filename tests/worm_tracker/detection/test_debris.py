"""Debris on, under and beside the worm moves neither tips nor centroid; no worm is debris."""

import math

import numpy as np
import pytest

from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.scenes import SCENES, Take
from worm_model.simulator.worm import Walker, midlines_mm, simulate_film
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker


def errors(scene, seed, frames, px_per_mm=20.0):
    """Return the errors of the nearer ends and of the centroid; every frame has to be tracked."""
    tracker, given, truth = Tracker(TrackerParameters()), [], []
    for shot in SCENES[scene](Take(px_per_mm=px_per_mm, frames=frames, seed=seed)):
        given += tracker.push(shot.picture, shot.stamp_ns)
        truth.append(shot.truth)
    given += tracker.finish()
    tips, centroids = [], []
    for tracked, true in zip(given, truth, strict=True):
        state = tracked.state
        assert state.status is Status.TRACKED
        real = [(true.head_u_px, true.head_v_px), (true.tail_u_px, true.tail_v_px)]
        found = [(state.head.u_px, state.head.v_px), (state.tail.u_px, state.tail.v_px)]
        ways = (found, found[::-1])
        tips.append(min([math.dist(a, b) for a, b in zip(way, real, strict=True)] for way in ways))
        centre = state.centroid
        centroids.append(
            math.dist((centre.u_px, centre.v_px), (true.centroid_u_px, true.centroid_v_px))
        )
    return np.array(tips), np.array(centroids)


@pytest.mark.parametrize(("scene", "seed"), [("bubbles", 1), ("bubbles", 4), ("debris", 2)])
def test_what_touches_the_worm_from_the_first_frame_is_cut_off(scene, seed):
    tips, centroids = errors(scene, seed, 60)
    assert np.median(tips) <= 0.5
    assert np.quantile(tips, 0.95) <= 1.5
    assert np.median(centroids) <= 0.3


RESTLESS = Walker(
    speed_mm_s=6.0, mean_slide_mm=0.5, mean_hop_mm=0.5, mean_excursion_mm=2.0,
    reversal_per_cycle=1.0, seed=6,
)  # fmt: skip


def test_the_corner_that_a_midline_cuts_is_not_taken_for_dirt():
    """Where it bends by more than a right angle within a width its midline lies off its middle."""
    steps = np.diff(list(midlines_mm(RESTLESS, 10.0, 1.5, 30.0)), axis=1) @ [1.0, 1.0j]
    assert np.abs(np.angle(steps[:, 1:] / steps[:, :-1])).max() > np.pi / 2
    rig = Rig(exit_width_mm=0.0, optics=Optics(noise=2.0, seed=0))
    tracker, given, lengths = Tracker(TrackerParameters()), [], []
    for frame in simulate_film(rig, RESTLESS, 1.5, 30.0):
        lengths.append(frame.truth.length_mm)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    found = np.array([tracked.state.length_m * 1e3 for tracked in given])
    seen = np.isfinite(found)
    assert seen.mean() > 0.8
    assert np.abs(found / np.array(lengths) - 1.0)[seen].max() < 0.12
