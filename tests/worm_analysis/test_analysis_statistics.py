"""Estimators against closed forms, SciPy and samples of known laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.signal import lfilter

from worm_analysis.accumulators.episode_sums import EpisodeSums
from worm_analysis.events.contacts import ClosedEpisode
from worm_analysis.statistics.block_jackknife import BlockSums, Units, jackknife_half_width
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_analysis.statistics.estimators import (
    exponential_mean,
    fraction,
    peak_positions,
    per_true_cycle,
    poisson_rate,
    unmerged_means,
)
from worm_analysis.statistics.goodness_of_fit import exponential_p, grouped, p_of_statistic
from worm_analysis.statistics.penetration_law import fit_penetration
from worm_analysis.statistics.running_median import RunningMedian
from worm_analysis.statistics.sample_correlation import pearson
from worm_analysis.summary.estimates import length as exponential_length
from worm_analysis.summary.sums import Sums
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


def closed_episode(kind, turn_rad, *, complete=True, start_seen=True, cut=False):
    distance_m = 0.01 * abs(turn_rad)
    depth_m = 1e-3 if kind is EpisodeKind.FREE else float("nan")
    episode = Episode("chamber_a", kind, 0, NS, distance_m, depth_m, complete=complete)
    return ClosedEpisode(episode, turn_rad, 10, start_seen, cut=cut or not complete)


def test_an_episode_without_its_start_is_left_out_and_one_without_its_end_is_censored():
    sums = EpisodeSums(0.01)
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.1))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.2, complete=False, start_seen=False))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.3, complete=False))
    assert sums.lengths.d_c.above(0.0) == (1, pytest.approx(4e-3), 0.0)


def test_reversals_are_counted_between_neighbouring_cycles_only():
    contact, free = EpisodeKind.CONTACT, EpisodeKind.FREE
    sums = EpisodeSums(0.01)
    for direction in (1, 1, -1, -1, 1):
        sums.push(closed_episode(contact, 0.1 * direction))
        sums.push(closed_episode(free, 0.1 * direction))
    assert (sums.reversals, sums.cycles) == (2, 4)
    sums.push(closed_episode(contact, 0.1, complete=False))  # a gap
    sums.push(closed_episode(free, -0.1, complete=False, start_seen=False))
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    assert (sums.reversals, sums.cycles) == (2, 4)
    sums.push(closed_episode(contact, 0.1))
    sums.push(closed_episode(free, 0.1, cut=True))  # into the exit: complete, and the last one
    assert (sums.reversals, sums.cycles) == (3, 5)
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    assert (sums.reversals, sums.cycles) == (3, 5)


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


@given(st.floats(0, 0.49), st.integers(1, 6))
def test_the_reversals_of_unseen_cycles_are_undone(chance, cycles):
    """A head that turns round with a chance after each cycle, looked at after every few cycles."""
    goes_on = 1.0
    for _ in range(cycles):
        goes_on = goes_on * (1 - chance) + (1 - goes_on) * chance
    assert per_true_cycle(1 - goes_on, cycles) == pytest.approx(chance, abs=1e-6)


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


def depths(rng, n, share, beta=0.5, span=10.0):
    x = rng.exponential(1 / beta, 4 * n)
    x = x[x < span][:n]
    even = rng.random(n) < share
    x[even] = rng.uniform(0, span, even.sum())
    return x


def fitted(x, bin_mm=0.1):
    edges = np.arange(np.ceil(x.max() / bin_mm) + 1) * bin_mm
    return fit_penetration(edges, np.histogram(x, edges)[0])


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_the_decay_of_failures_and_the_constant_are_covered_by_their_intervals(share):
    rng = np.random.default_rng(4)
    beta, span = 0.5, 10.0
    truth = {
        "beta": beta,
        "const": share / span,
        "alpha": (1 - share) * beta / -np.expm1(-beta * span),
    }
    hits = dict.fromkeys(truth, 0)
    for _ in range(60):
        found = fitted(depths(rng, 150, share, beta, span))
        for name, true in truth.items():
            value, low, high = getattr(found, name)
            assert np.isnan(low) or low <= value * (1 + 1e-9)
            assert np.isnan(high) or value <= high * (1 + 1e-9)
            hits[name] += not (true < low or true > high)
    # At 95 % each, fewer than 51 of 60 happens once in two hundred times.
    assert min(hits.values()) >= 51, hits


def test_the_decay_of_failures_is_the_maximum_of_the_likelihood():
    x = depths(np.random.default_rng(8), 200, 0.15)
    found = fitted(x)
    edges = np.arange(np.ceil(x.max() / 0.1) + 1) * 0.1
    counts, span = np.histogram(x, edges)[0], edges[-1]

    def log_likelihood(beta, share):
        decay = np.diff(-np.exp(-beta * edges)) / -np.expm1(-beta * span)
        return counts @ np.log((1 - share) * decay + share * 0.1 / span)

    beta, share = found.beta[0], found.const[0] * span
    best = log_likelihood(beta, share)
    for factor in (0.99, 1.01):
        assert log_likelihood(beta * factor, share) < best
        assert log_likelihood(beta, share * factor) < best
    for end in found.beta[1:]:
        profile = max(log_likelihood(end, s) for s in np.linspace(0, 0.9, 2000))
        assert best - profile == pytest.approx(1.92, abs=0.05)


@pytest.mark.parametrize(
    ("critical", "p"), [(0.736, 0.25), (1.062, 0.10), (1.321, 0.05), (1.591, 0.025), (1.959, 0.01)]
)
def test_p_is_that_of_the_printed_table(critical, p):
    """D'Agostino & Stephens (1986), table 4.14: A² of an exponential law with fitted mean."""
    assert p_of_statistic(critical) == pytest.approx(p, rel=0.03)


@pytest.mark.parametrize("n", [25, 2000])
def test_a_true_exponential_is_refused_as_often_as_the_level_says(n):
    rng = np.random.default_rng(6)
    p = []
    for _ in range(1500):
        x = rng.exponential(1.95, n)
        counts = np.bincount((x / 0.1).astype(int), minlength=2)
        p.append(exponential_p(np.append(counts, 0), 0.1, x.mean()))
    for level in (0.05, 0.2, 0.5):
        spread = 3.5 * np.sqrt(level * (1 - level) / len(p))
        assert np.mean(np.array(p) < level) == pytest.approx(level, abs=spread + 0.01)


def test_another_law_is_refused():
    rng = np.random.default_rng(7)
    for x in (rng.gamma(2.0, 1.0, 300), rng.weibull(0.7, 300), rng.uniform(0, 4, 300)):
        counts = np.append(np.bincount((x / 0.05).astype(int)), 0)
        assert exponential_p(counts, 0.05, x.mean()) < 1e-3


@given(st.lists(st.integers(0, 20), min_size=1, max_size=40), st.integers(1, 9))
def test_grouping_loses_no_item(counts, per_group):
    groups = grouped(np.array(counts), per_group)
    assert groups.sum() == sum(counts)
    assert groups[0] == sum(counts[:per_group])


def test_the_interval_of_a_mean_allows_for_a_worm_that_changes():
    """The mean length of a slide swings over ten minutes: the law's own interval is too narrow."""
    rng = np.random.default_rng(9)
    hits = narrow = 0
    for _ in range(100):
        sums, blocks = ExcessSums(1e-5, 6001), ExcessBlocks(1e-5, 101)
        phase = rng.uniform(0, 2 * np.pi)
        for k in range(1000):  # one every 1.8 s
            mean = 2e-3 * (1 + 0.8 * np.sin(2 * np.pi * k / 137 + phase))
            length = rng.exponential(mean)
            sums.push(length, complete=True)
            blocks.push(k * 1_800_000_000, length, complete=True)
        n, excess, _ = sums.above(0.0)
        _, low, high = exponential_length("tau_h")(Sums([{"tau_h": blocks.rows(0.0)}]))
        hits += low < 2e-3 < high
        _, low, high = exponential_mean(n, excess)
        narrow += low < 2e-3 < high
    assert hits >= 90
    assert narrow < hits


@given(st.integers(0, 2**32 - 1))
def test_pearson_from_sums_is_numpys(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(3, 2, 300)
    y = rng.normal(0, 1, 300) + rng.normal() * x
    blocks = BlockSums(6)
    rows = np.stack([np.ones(300), x, y, x * x, y * y, x * y], axis=1)
    for step, row in enumerate(rows):
        blocks.row(step * NS)[:] += row
    r, low, high = pearson(Units([blocks.rows()]))
    assert r == pytest.approx(np.corrcoef(x, y)[0, 1], abs=1e-9)
    assert low < r < high


def test_the_interval_of_a_correlation_of_slow_series_is_honest():
    """Two series without anything in common, each with a memory of 20 steps."""
    rng = np.random.default_rng(10)
    hits = 0
    for _ in range(100):
        x, y = lfilter([1.0], [1.0, -0.95], rng.normal(size=(2, 2000)))
        blocks = BlockSums(6)
        rows = np.stack([np.ones(2000), x, y, x * x, y * y, x * y], axis=1)
        columns = np.tile(np.arange(6), (2000, 1))
        blocks.add(np.arange(2000) * NS, columns, rows)
        _, low, high = pearson(Units([blocks.rows()]))
        hits += low < 0 < high
    assert hits >= 90


def test_a_series_that_does_not_vary_has_no_correlation():
    blocks = BlockSums(6)
    for step in range(100):
        blocks.row(step * NS)[:] += (1.0, 0.3, step, 0.09, step**2, 0.3 * step)
    assert np.isnan(pearson(Units([blocks.rows()]))[0])


@given(
    st.lists(st.floats(0.01, 300), min_size=1, max_size=200),
    st.integers(1, 50),
    st.integers(0, 2**32 - 1),
)
def test_sums_do_not_depend_on_how_frames_are_bunched(intervals_s, at_once, seed):
    rng = np.random.default_rng(seed)
    stamps = np.cumsum(np.array(intervals_s) * NS).astype(np.int64)
    columns = rng.integers(-1, 3, (len(stamps), 2))
    values = rng.normal(size=(len(stamps), 2))
    one, many = BlockSums(3), BlockSums(3)
    for stamp, column, value in zip(stamps.tolist(), columns, values, strict=True):
        row = one.row(stamp)
        for at, item in zip(column, value, strict=True):
            if at >= 0:
                row[at] += item
    for start in range(0, len(stamps), at_once):
        part = slice(start, start + at_once)
        many.add(stamps[part], columns[part], values[part])
    assert one.rows().tobytes() == many.rows().tobytes()


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
    units = Units([blocks.rows()])
    np.testing.assert_array_equal(units.total(), [len(stamps), 3 * len(stamps)])
    for rows in units.levels():
        assert len(rows) <= 64
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
        half = jackknife_half_width(Units([blocks.rows()]), lambda sums: sums[:, 0] / sums[:, 1])
        hits += abs(series.mean()) < half
    assert hits >= 90
