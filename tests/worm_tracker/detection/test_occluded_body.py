"""A part of the worm is occluded: it is bridged and marked, or said to be missing, not guessed."""

import math

import numpy as np
import pytest

from worm_analysis.analysis import Analysis
from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

SCALE = 24.0


@pytest.fixture(scope="module", params=[("glare", 1, 90), ("moving_glare", 0, 100)], ids=str)
def film(request):
    """Return the frames given, their observables, and the truth of each."""
    scene, seed, frames = request.param
    tracker, analysis, given, truth = Tracker(TrackerParameters()), Analysis(), [], []
    for shot in SCENES[scene](Take(px_per_mm=SCALE, frames=frames, seed=seed)):
        given += tracker.push(shot.picture, shot.stamp_ns)
        truth.append(shot.truth)
    given += tracker.finish()
    return given, [analysis.push(tracked)[0] for tracked in given], truth


def of_status(film, *statuses):
    given, _, truth = film
    return [(t, true) for t, true in zip(given, truth, strict=True) if t.state.status in statuses]


def ends_off(tracked, true):
    """Return the errors of both ends, paired the likelier way."""
    real = [(true.head_u_px, true.head_v_px), (true.tail_u_px, true.tail_v_px)]
    state = tracked.state
    found = [(state.head.u_px, state.head.v_px), (state.tail.u_px, state.tail.v_px)]
    ways = (
        [math.dist(a, b) for a, b in zip(way, real, strict=True)] for way in (found, found[::-1])
    )
    return min(ways, key=lambda way: np.nansum(way) if np.isfinite(way).any() else math.inf)


def test_every_frame_is_tracked_bridged_or_says_that_an_end_is_hidden(film):
    given, _, _ = film
    kinds = {tracked.state.status for tracked in given}
    assert kinds <= {Status.TRACKED, Status.BRIDGED, Status.END_HIDDEN}
    assert Status.END_HIDDEN in kinds


def test_an_end_that_is_given_was_seen(film):
    """An end taken for the tip where glare cut the body off would be many pixels away from it."""
    off = np.array([ends_off(*pair) for pair in of_status(film, *Status)])
    off = off[np.isfinite(off)]
    assert len(off) > 120
    assert np.median(off) <= 0.5
    assert np.quantile(off, 0.95) <= 1.5
    assert off.max() < 0.5 * 0.4 * SCALE, "half a width"


def test_a_bridged_midline_follows_the_hidden_body(film):
    bridged = of_status(film, Status.BRIDGED)
    for tracked, true in bridged:
        line = np.stack([tracked.midline.u_px, tracked.midline.v_px], axis=1)
        assert len(line)
        assert np.isfinite(line).all()
        real = np.stack([true.midline_u_px, true.midline_v_px], axis=1)
        real = np.stack(
            [np.interp(np.linspace(0, 49, 500), np.arange(50), real[:, k]) for k in (0, 1)], axis=1
        )
        away = np.hypot(*(line[:, None] - real[None]).T).min(axis=0)
        assert np.sqrt((away**2).mean()) < 1.0
        assert away.max() < 0.4 * SCALE, "a width"


def test_the_centroid_counts_the_hidden_part(film):
    off = [
        math.dist(
            (tracked.state.centroid.u_px, tracked.state.centroid.v_px),
            (true.centroid_u_px, true.centroid_v_px),
        )
        for tracked, true in of_status(film, Status.TRACKED, Status.BRIDGED)
    ]
    assert np.median(off) <= 0.41
    assert np.quantile(off, 0.95) < 1.5


def test_nothing_is_decided_from_an_end_that_was_not_seen(film):
    given, observables, _ = film
    hidden = [
        (tracked, seen)
        for tracked, seen in zip(given, observables, strict=True)
        if tracked.state.status is Status.END_HIDDEN
    ]
    for tracked, seen in hidden:
        state = tracked.state
        assert math.isnan(state.length_px)
        unseen = np.isnan(tracked.midline.u_px)
        if len(unseen):
            assert math.isnan(state.head.u_px) == unseen[0]
            assert math.isnan(state.tail.u_px) == unseen[-1]
            assert unseen.any()
            assert not unseen[len(unseen) // 2]
        if math.isnan(state.head.u_px):
            assert seen.contact is None
            assert math.isnan(seen.theta_h_rad)
            assert math.isnan(seen.psi_b_rad)
        else:
            assert math.isfinite(seen.theta_h_rad) == (state.head_certainty >= 0.5)
