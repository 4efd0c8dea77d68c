"""Where points are between pictures follows from how they moved, and how unsure it is, too."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.waiting.smooth_motion import (
    SmoothMotionSettings,
    bridged,
    unsteadiness_of,
)

SETTINGS = SmoothMotionSettings()
numbers = st.floats(-20, 20)


def wandering(rng, unsteadiness, times_s, *, paths=1, step_s=1e-3):
    """Paths whose velocity wanders, in small steps: true places at some times, (n, paths, 2)."""
    count = round(times_s[-1] / step_s) + 1
    gains = rng.normal(0, np.sqrt(unsteadiness * step_s), (count, paths, 2))
    places = np.cumsum(np.cumsum(gains, axis=0) * step_s, axis=0)
    return places[np.round(times_s / step_s).astype(int)]


@given(
    st.lists(st.floats(0.01, 0.3), min_size=2, max_size=9),
    st.tuples(numbers, numbers),
    st.tuples(numbers, numbers),
    st.floats(-0.5, 3.0),
    st.floats(1.0, 1000.0),
)
def test_what_moves_straight_on_is_told_straight_on(spans_s, place, velocity, at_s, unsteadiness):
    times_s = np.cumsum(spans_s)
    points = np.array(place) + np.multiply.outer(times_s, np.array(velocity))
    sd = np.full((len(times_s), 1), 0.2)
    told, _, misfit = bridged(times_s, points[:, np.newaxis], sd, at_s, np.array([unsteadiness]))
    assert misfit < 1e-3
    assert told[0] == pytest.approx(np.array(place) + at_s * np.array(velocity), abs=1e-3)


@pytest.mark.parametrize("gap_s", [0.08, 0.3, 0.8])
@pytest.mark.parametrize("unsteadiness", [20.0, 400.0])
def test_errors_are_as_large_as_is_said(gap_s, unsteadiness):
    rng, beside = np.random.default_rng(5), np.arange(5) * 0.03
    times_s = np.concatenate([beside, beside[-1] + gap_s + beside])
    at_s, paths, noise = beside[-1] + 0.4 * gap_s, 2000, 0.15
    all_s = np.sort(np.append(times_s, at_s))
    true = wandering(rng, unsteadiness, all_s, paths=paths)
    asked = int(np.searchsorted(all_s, at_s))
    seen = np.delete(true, asked, axis=0) + rng.normal(0, noise, (len(times_s), paths, 2))
    sd = np.full((len(times_s), paths), noise)
    told, said, _ = bridged(times_s, seen, sd, at_s, np.full(paths, unsteadiness))
    assert np.std(told - true[asked]) == pytest.approx(said[0], rel=0.06)


def test_each_point_is_told_by_its_own_places_and_noise():
    rng, times_s = np.random.default_rng(1), np.array([0.0, 0.1, 0.3, 0.4])
    points, sd = rng.normal(0, 1, (4, 3, 2)), rng.uniform(0.1, 0.5, (4, 3))
    unsteadiness = np.array([5.0, 50.0, 500.0])
    together = bridged(times_s, points, sd, 0.2, unsteadiness)
    misfits = []
    for k in range(3):
        *alone, misfit = bridged(times_s, points[:, [k]], sd[:, [k]], 0.2, unsteadiness[[k]])
        for one, other in zip(alone, together[:2], strict=True):
            assert one[0] == pytest.approx(other[k])
        misfits.append(misfit)
    assert max(misfits) == pytest.approx(together[2])


def test_a_place_off_the_way_does_not_fit():
    times_s = np.array([0.0, 0.04, 0.08, 0.12, 0.3, 0.34, 0.38])
    points, sd = np.zeros((7, 1, 2)), np.full((7, 1), 0.15)
    points[:, 0, 0] = 2 * times_s
    points[3, 0, 1] = 0.9
    assert bridged(times_s, points, sd, 0.2, np.array([50.0]))[2] > 2


@pytest.mark.parametrize("frames_per_s", [12.5, 25.0, 40.0])
@pytest.mark.parametrize("unsteadiness", [10.0, 500.0])
def test_how_unsteadily_a_point_moves_is_seen(frames_per_s, unsteadiness):
    rng, times_s = np.random.default_rng(3), np.arange(0, 40, 1 / frames_per_s)
    seen = wandering(rng, unsteadiness, times_s, paths=20)
    found = unsteadiness_of(times_s, seen, replace(SETTINGS, weight=0.0))
    assert found.mean() == pytest.approx(unsteadiness, rel=0.15)


def test_without_pictures_enough_a_point_is_as_unsteady_as_most():
    times_s = np.array([0.0, 0.04, 0.9, 0.94])
    found = unsteadiness_of(times_s, np.zeros((4, 2, 2)), SETTINGS)
    assert found.tolist() == [SETTINGS.unsteadiness] * 2


def test_few_pictures_tell_less_than_many_of_how_steady_a_point_is():
    settings = replace(SETTINGS, unsteadiness=100.0)
    for spans_s, most in ((0.5, 100.0), (2.0, 70.0), (20.0, 20.0)):
        times_s = np.arange(0, spans_s, 0.04)
        found = unsteadiness_of(times_s, np.zeros((len(times_s), 1, 2)), settings)
        assert 0 < found[0] < most
