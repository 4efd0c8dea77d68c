"""Estimators against closed forms, SciPy and samples of known laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.signal import lfilter

from worm_analysis.blocks import BlockSums, jackknife_half_width
from worm_analysis.contacts import ClosedEpisode
from worm_analysis.distributions import ExcessSums
from worm_analysis.episode_sums import EpisodeSums
from worm_analysis.running_median import RunningMedian
from worm_analysis.statistics import (
    decay_over_constant,
    exponential_mean,
    fraction,
    peak_positions,
    poisson_rate,
    unmerged_means,
)
from worm_msgs_py import Episode, EpisodeKind

NS = 10**9


def test_exponential_mean_with_cutoff_and_censoring_is_covered_by_its_interval():
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(300):
        length, limit = rng.exponential(1.95e-3, 80), rng.exponential(8e-3, 80)
        sums = ExcessSums(1e-5, 6001)
        for item, end in zip(length, limit, strict=True):
            sums.push(min(item, end), complete=bool(item < end))
        n, excess, cutoff = sums.above(1.23e-4)
        assert cutoff == pytest.approx(1.3e-4)
        _, low, high = exponential_mean(n, excess)
        hits += low < 1.95e-3 < high
    assert 0.92 < hits / 300 < 0.98


def closed_episode(kind, turn_rad, *, complete=True, start_seen=True):
    distance_m = 0.01 * abs(turn_rad)
    depth_m = 1e-3 if kind is EpisodeKind.FREE else float("nan")
    episode = Episode("chamber_a", kind, 0, NS, distance_m, depth_m, complete=complete)
    return ClosedEpisode(episode, turn_rad, 10, start_seen)


def test_an_episode_without_its_start_is_left_out_and_one_without_its_end_is_censored():
    sums = EpisodeSums()
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.1))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.2, complete=False, start_seen=False))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.3, complete=False))
    assert sums.d_c.above(0.0) == (1, pytest.approx(4e-3), 0.0)


def test_reversals_are_counted_between_neighbouring_cycles_only():
    contact, free = EpisodeKind.CONTACT, EpisodeKind.FREE
    sums = EpisodeSums()
    for direction in (1, 1, -1, -1, 1):
        sums.push(closed_episode(contact, 0.1 * direction))
        sums.push(closed_episode(free, 0.1 * direction))
    assert (sums.reversals, sums.cycles) == (2, 4)
    sums.push(closed_episode(contact, 0.1, complete=False))  # a gap
    sums.push(closed_episode(free, -0.1, complete=False, start_seen=False))
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    assert (sums.reversals, sums.cycles) == (2, 4)


@given(st.lists(st.floats(0, 0.1), min_size=1, max_size=50), st.floats(0, 0.02))
def test_sums_above_a_cutoff_are_those_of_the_lengths_themselves(lengths, cutoff):
    sums = ExcessSums(1e-5, 6001)
    for length in lengths:
        sums.push(length, complete=True)
    n, excess, edge = sums.above(cutoff)
    chosen = [length for length in lengths if int(length / 1e-5) >= round(edge / 1e-5)]
    assert n == len(chosen)
    assert excess == pytest.approx(sum(length - edge for length in chosen), abs=1e-12)
    assert cutoff - 1e-12 <= edge <= cutoff + 1e-5


def test_sampling_in_frames_is_undone():
    """Runs of a two-state process that is looked at once a step, against its true means."""
    rng = np.random.default_rng(2)
    true, step, n = (1.95, 1.46), 0.3, 200_000
    edges = np.cumsum(rng.exponential(np.tile(true, n // 2)))
    seen = np.searchsorted(edges, np.arange(0, edges[-1], step)) % 2
    change = np.flatnonzero(np.diff(seen)) + 1
    runs = np.diff(change) * step
    state = seen[change[:-1]]
    excess = [(runs[state == k] - 1.5 * step)[runs[state == k] > 1.5 * step] for k in (0, 1)]
    naive = [item.mean() for item in excess]
    assert naive[0] > 1.02 * true[0]
    assert unmerged_means(*naive, step) == pytest.approx(true, rel=0.01)


@pytest.mark.parametrize(("successes", "n"), [(0, 12), (7, 12), (12, 12), (60, 100)])
def test_fraction_is_clopper_pearson(successes, n):
    interval = stats.binomtest(successes, n).proportion_ci()
    assert fraction(successes, n) == pytest.approx((successes / n, interval.low, interval.high))


@pytest.mark.parametrize("count", [0, 1, 13])
def test_poisson_rate_has_the_exact_interval(count):
    rate, low, high = poisson_rate(count, 2.0)
    assert rate == count / 2
    assert stats.poisson.cdf(count, 2 * high) == pytest.approx(0.025)
    if count:
        assert stats.poisson.sf(count - 1, 2 * low) == pytest.approx(0.025)


@pytest.mark.parametrize("constant", [0.0, 0.2])
def test_the_decay_of_failures_is_found_over_a_constant(constant):
    rng = np.random.default_rng(4)
    edges = np.linspace(0, 35e-3, 141)
    x = rng.exponential(2e-3, 400)
    x[: round(400 * constant)] = rng.uniform(0, 35e-3, round(400 * constant))
    counts, _ = np.histogram(x, edges)
    beta, low, high = decay_over_constant(edges, counts)
    assert low < 500 < high
    assert low < beta < high
    assert beta == pytest.approx(500, rel=0.15)


def test_a_peak_lies_between_bins_and_an_end_is_no_peak():
    centres = np.arange(-89.0, 90.0, 2.0)
    rows = np.stack([np.exp(-(((centres - 30.7) / 12) ** 2)), np.arange(90.0)])
    peak, none = peak_positions(rows, centres)
    assert peak == pytest.approx(30.7, abs=0.05)
    assert np.isnan(none)


@given(st.lists(st.floats(0, 1.99e-3), min_size=1, max_size=200))
def test_the_running_median_is_that_of_numpy_to_a_bin(values):
    median = RunningMedian(2e-6, 1000)
    for count, value in enumerate(values, 1):
        median.push(value)
        ordered = sorted(values[:count])
        low, high = ordered[(count - 1) // 2], ordered[count // 2]
        assert low - 2.1e-6 <= median.value() <= high + 2.1e-6
    backwards = RunningMedian(2e-6, 1000)
    for value in reversed(values):
        backwards.push(value)
    assert backwards.value() == median.value()
    assert median.n == median.counts.sum() == len(values)


def test_the_running_median_leaves_out_what_is_no_width():
    median = RunningMedian(2e-6, 1000)
    assert np.isnan(median.value())
    for value in (np.nan, -1.0, np.inf):
        median.push(value)
    assert median.n == 0


@given(st.lists(st.floats(0.001, 400), min_size=1, max_size=300))
def test_block_sums_add_up_however_long_the_trial(intervals_s):
    blocks = BlockSums(2)
    stamps = np.cumsum(np.array(intervals_s) * NS).astype(np.int64)
    for stamp in stamps.tolist():
        blocks.row(stamp)[:] += (1.0, 3.0)
    np.testing.assert_array_equal(blocks.total(), [len(stamps), 3 * len(stamps)])
    for rows in blocks.levels():
        assert len(rows) <= 128
        assert rows.sum() == 4 * len(stamps)


def test_the_interval_of_a_mean_of_a_correlated_series_is_honest():
    """An AR(1) series with a memory of a block: the shortest blocks alone hold 75 of 100."""
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(100):
        series = lfilter([1.0], [1.0, -0.95], rng.normal(size=2500))
        blocks = BlockSums(2)
        for step, value in enumerate(series.tolist()):
            blocks.row(step * NS)[:] += (value, 1.0)
        half = jackknife_half_width(blocks, lambda sums: sums[:, 0] / sums[:, 1])
        hits += abs(series.mean()) < half
    assert hits >= 90
