"""How fast C_θ decays: the fitted exponential, the time to 1/e, and whether the two agree."""

import numpy as np
import pytest

from worm_analysis.accumulators.direction_correlation import SignCorrelation, lag_grid
from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.definition import Definition
from worm_analysis.summary.direction_persistence import (
    NotEnoughData,
    correlation_curve,
    fall_over_decay,
    fall_time,
    persistence_time,
    start_excess,
    tail_excess,
)
from worm_analysis.summary.quantities import DEFINITIONS
from worm_analysis.summary.sums import Sums

NS = 10**9
STEP_S = 0.1
LAGS = lag_grid(120.0, 10.0, STEP_S, 1.0)


def telegraph(rng, seconds, t_per_s):
    """Return a direction that turns at random: C_θ = exp(−t/t_per)."""
    flips = rng.random(int(seconds / STEP_S)) < 0.5 * -np.expm1(-STEP_S / t_per_s)
    return np.where(np.cumsum(flips) % 2, -1.0, 1.0)


def with_bursts(rng, seconds):
    """Return one that is kept for 20 s, but is the other one for a second now and then."""
    signs = telegraph(rng, seconds, 20.0)
    start = 0
    while start < len(signs):
        start += int(rng.exponential(8.0) / STEP_S) + 1
        end = start + int(rng.exponential(1.0) / STEP_S) + 1
        signs[start:end] *= -1
        start = end
    return signs


def units(*trials):
    """Return the sums of C_θ of some trials."""
    parts = []
    for signs in trials:
        correlation = SignCorrelation(LAGS, STEP_S)
        correlation.add(np.arange(len(signs)) * (NS // 10), signs)
        parts.append(correlation.sums()["c_theta"])
    return Units(parts), correlation.lag_s


def holds(interval, truth):
    return interval[1] <= truth <= interval[2]


def test_one_exponential_falls_to_one_e_in_its_decay_time():
    rng = np.random.default_rng(1)
    estimates = [
        (fall_time, 10.0), (persistence_time, 10.0), (fall_over_decay, 1.0), (tail_excess, 0.0),
        (start_excess, 0.0),
    ]  # fmt: skip
    held = np.zeros(5)
    for _ in range(40):
        found = units(telegraph(rng, 1800.0, 10.0))
        held += [holds(estimate(*found), truth) for estimate, truth in estimates]
    assert (held >= 34).all(), held  # of 40 at 95 % each, fewer happens once in a thousand times


def test_a_decay_of_two_times_is_told_from_one_exponential_and_its_intervals_hold():
    rng = np.random.default_rng(2)
    long = units(with_bursts(rng, 200_000.0))
    estimates = (fall_time, fall_over_decay, tail_excess)
    truth = [estimate(*long)[0] for estimate in estimates]
    assert truth[1] > 1.2
    assert truth[2] > 0.1
    assert fall_over_decay(*long)[1] > 1
    held, told = np.zeros(3), 0
    for _ in range(40):
        found = units(with_bursts(rng, 1800.0))
        told += tail_excess(*found)[1] > 0
        held += [holds(e(*found), t) for e, t in zip(estimates, truth, strict=True)]
    assert (held >= 34).all(), held
    assert told >= 34, "a tail is told in a single trial"


def test_visits_of_three_decay_times_tell_a_curve_that_does_not_fall():
    """One that drops at once and stays: its fit is slow, and no visit lasts four times as long."""
    rng = np.random.default_rng(9)
    dropping = [np.where(rng.random(700) < 0.11, -1.0, 1.0) for _ in range(12)]
    found = units(*dropping)
    assert persistence_time(*found)[0] > 70.0 / 4
    assert tail_excess(*found)[1] > 0.2
    with pytest.raises(NotEnoughData, match="lags of several decay times"):
        tail_excess(*units(*(telegraph(rng, 50.0, 40.0) for _ in range(12))))


def test_visits_of_less_than_a_decay_time_tell_a_curve_that_drops_at_once():
    rng = np.random.default_rng(9)
    found = units(*(np.where(rng.random(200) < 0.11, -1.0, 1.0) for _ in range(40)))
    assert start_excess(*found)[2] < -0.1
    with pytest.raises(NotEnoughData, match="lags of several decay times"):
        tail_excess(*found)
    held = [holds(start_excess(*units(*(telegraph(rng, 150.0, 20.0) for _ in range(6)))), 0.0)
            for _ in range(20)]  # fmt: skip
    assert sum(held) >= 16, "of 20 at 95 % each, fewer happens in three of a thousand"


def test_the_time_to_one_e_is_where_the_curve_crosses_it():
    found, lag_s = units(with_bursts(np.random.default_rng(3), 3600.0))
    c, _ = correlation_curve(found)
    value, low, high = fall_time(found, lag_s)
    assert np.interp(value, lag_s, c) == pytest.approx(np.exp(-1), abs=1e-9)
    assert low < value < high


def test_a_pool_tells_it_like_one_long_trial_and_surer_than_each():
    rng = np.random.default_rng(4)
    trials = [with_bursts(rng, 1800.0) for _ in range(8)]
    value, low, high = fall_over_decay(*units(*trials))
    alone = [fall_over_decay(*units(trial)) for trial in trials]
    assert 1 < low < value < high
    assert np.log(high / low) < min(np.log(each[2] / each[1]) for each in alone)
    assert (
        np.log(high / low) > 0.5 * np.median([np.log(each[2] / each[1]) for each in alone]) / 8**0.5
    )


def test_trials_that_differ_widen_the_time_to_one_e():
    rng = np.random.default_rng(5)
    alike = units(*(telegraph(rng, 1800.0, 10.0) for _ in range(8)))
    differ = units(*(telegraph(rng, 1800.0, t) for t in (2.0, 40.0) * 4))
    widths = [np.log(high / low) for _, low, high in (fall_time(*alike), fall_time(*differ))]
    assert widths[1] > 2 * widths[0]


def test_an_interval_that_nothing_bounds_has_no_ends():
    """C_θ stays where it is about 1/e: the time at which it crosses that is anywhere."""
    ends = []
    for seed in range(4):
        rng = np.random.default_rng([10, seed])
        kept = telegraph(rng, 600.0, 60.0)
        value, low, high = fall_time(*units(kept * np.where(rng.random(6000) < 0.18, -1.0, 1.0)))
        assert np.isfinite(low) == np.isfinite(high)
        ends.append(high / value)
    assert np.isfinite(ends).tolist() == [True, False, True, True]
    assert np.nanmax(ends) <= 100.0


@pytest.mark.parametrize("seconds", [30.0, 300.0])
def test_a_direction_that_is_hardly_ever_left_has_no_time_but_a_reason(seconds):
    found = units(np.ones(int(seconds / STEP_S)))
    with pytest.raises(NotEnoughData, match="does not fall to 1/e"):
        fall_time(*found)


def test_a_track_that_is_too_short_for_its_decay_says_so():
    found = units(telegraph(np.random.default_rng(8), 60.0, 20.0))
    with pytest.raises(NotEnoughData, match=r"times the time to 1/e|does not fall"):
        fall_time(*found)


@pytest.mark.parametrize("name", ["t_1e", "t_1e_over_t_per", "c_theta_tail"])
def test_they_are_numbers_of_the_table_with_n_and_an_interval(name):
    found, lag_s = units(telegraph(np.random.default_rng(6), 1800.0, 5.0))
    sums = Sums([{"c_theta": found._trials[0], "pixel": np.array([[1.0, 1e-4]])}], lag_s=lag_s)
    definition: Definition = DEFINITIONS[name]
    quantity = definition.of(sums)
    assert quantity.low < quantity.value < quantity.high
    assert quantity.n == 18000
