"""What a fold hides, which is where a worm turns round, does not bias what is said of turning."""

from functools import cache

import numpy as np
import pytest
from folded_tracks import folded
from unbiased import assert_unbiased
from walked_tracks import GEOMETRY, R, track_from_polar

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_model.boundary_walk.direction_correlation import persistence_time_s
from worm_model.boundary_walk.parameters import WalkParameters

REVERSAL = 0.05
WALK = WalkParameters(speed_mm_s=2.0, mean_slide_mm=1.95, mean_hop_mm=1.46, reversal=REVERSAL)
TRUTH = {
    "reversal_per_cycle": REVERSAL,
    "t_per": persistence_time_s(WALK),
    "reversal_rate": REVERSAL * 2.0 / 3.41,
}
SEEDS = range(8)
NO_BRIDGES = 0.001


def analysed(track, **parameters):
    analysis = Analysis(AnalysisParameters(**parameters))
    analysis.set_geometry(GEOMETRY)
    for state in track.each_state():
        analysis.push(state)
    analysis.finish()
    return analysis


@cache
def trials(max_bridged_s):
    """Numbers of trials of which four reversals in five lie in a fold of two to five seconds."""
    found = []
    for seed in SEEDS:
        track, gone, _ = folded(seed, 1200.0, 8.0, reversal=REVERSAL, lost=0.8, dull_gaps=4)
        summary = analysed(track, max_bridged_s=max_bridged_s).summary()
        found.append(({quantity.name: quantity for quantity in summary}, gone))
    return found


@pytest.mark.parametrize("name", TRUTH)
def test_reversals_in_folds_are_counted_without_bias(name):
    answers = [numbers[name] for numbers, _ in trials(10.0)]
    assert_unbiased(answers, TRUTH[name], most_error=0.15)


@pytest.mark.parametrize("name", TRUTH)
def test_without_a_bridge_the_same_folds_do_bias(name):
    answers = [numbers[name] for numbers, _ in trials(NO_BRIDGES)]
    values = np.array([answer.value for answer in answers if answer.value is not None])
    ratio = values / TRUTH[name]
    assert np.all(ratio > 1.5 if name == "t_per" else ratio < 0.7)


def test_how_much_was_bridged_and_how_much_is_missing_are_numbers():
    for max_bridged_s, bridged, missing in ((10.0, 1, 0), (NO_BRIDGES, 0, 1)):
        for numbers, gone in trials(max_bridged_s):
            assert numbers["search_bridged"].value == pytest.approx(bridged * gone, abs=0.01)
            assert numbers["search_missing"].value == pytest.approx(missing * gone, abs=0.01)
            assert numbers["frames_untracked"].value == pytest.approx(gone)


def test_without_gaps_nothing_is_changed():
    track, gone, _ = folded(3, 300.0, 10.0, reversal=0.1, lost=0.0)
    assert gone == 0.0
    with_bridges, without = (analysed(track, max_bridged_s=s).sums() for s in (10.0, NO_BRIDGES))
    for name, sums in with_bridges.items():
        np.testing.assert_array_equal(sums, without[name])
    assert not with_bridges["reversal_rate_gaps"].any()
    assert not with_bridges["reversal_per_cycle_gaps"][0, :3].any()


def there_and_back(r_between, seconds):
    """A head that goes round, is at `r_between` at the exit for a while, and goes back."""
    t = np.arange(0.0, 20.0, 0.1)
    theta = np.interp(t, [0.0, 8.0, 8.0 + seconds, 20.0], [-1.6, 0.0, 0.0, -1.6])
    r = np.where((t > 8.0) & (t < 8.0 + seconds), r_between, 0.999 * R)
    track = track_from_polar(t, r, theta, np.where(t < 8.0, 0.5, -0.5))
    return analysed(track).sums()


def test_a_stay_in_the_exit_is_no_fold():
    in_fold, in_exit = there_and_back(np.nan, 3.0), there_and_back(R + 2e-3, 3.0)
    assert in_fold["reversal_rate_gaps"].sum(axis=0)[:2].tolist() == [1.0, 1.0]
    assert in_fold["search_bridged"][0, 1] == pytest.approx(3.1, abs=0.15)
    assert not in_exit["reversal_rate_gaps"].any()
    assert in_exit["search_bridged"][0, 1] == in_exit["search_missing"][0, 1] == 0.0


def test_a_gap_that_is_too_long_is_missing():
    sums = there_and_back(np.nan, 11.0)
    assert not sums["reversal_rate_gaps"].any()
    assert sums["search_missing"][0, 1] == pytest.approx(11.1, abs=0.15)
