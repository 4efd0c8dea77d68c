"""The kinds of estimates that quantities are: each from sums to a value with a 95 % interval.

A trial's interval leaves out blocks of time in turn, a pool's whole trials too; where the items
follow a law of their own (a count, an exponential), it is never narrower than that law's. A pool's
interval is never narrower than its blocks of time allow: one trial alone gives its own.
"""

from collections.abc import Callable
from functools import lru_cache
from math import exp, isfinite, log, nan

import numpy as np

from worm_analysis.accumulators.bins import DEPTH_BIN_M
from worm_analysis.accumulators.body_size import histogram_median
from worm_analysis.kinematics.observables import wrap_angle
from worm_analysis.statistics.block_jackknife import Units, jackknife_half_width
from worm_analysis.statistics.goodness_of_fit import exponential_p, merged_bins
from worm_analysis.statistics.penetration_law import (
    PENETRATION,
    Penetration,
    PenetrationSettings,
    fit_penetration,
)
from worm_analysis.statistics.sample_correlation import pearson
from worm_analysis.statistics.unseen_episodes import per_true_cycle
from worm_analysis.summary.resolution import corrections, head_step_m, pixel_m
from worm_analysis.summary.settings import EstimateSettings
from worm_analysis.summary.sums import Sums
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval, exponential_mean, fraction, poisson_rate

Estimator = Callable[[Sums], Interval]
ValueOf = Callable[[Floats], Floats]
"""From sums of shape (m, k) to m values."""


def over(above: Floats, below: Floats) -> Floats:
    """Return a ratio; NaN where there is nothing below."""
    ratio: Floats = np.divide(above, below, out=np.full(len(above), nan), where=below > 0)
    return ratio


def _second_over_first(sums: Floats) -> Floats:
    return over(sums[:, 1], sums[:, 0])


def _symmetric(units: Units, value_of: ValueOf) -> Interval:
    value = float(value_of(units.total()[None])[0])
    half = jackknife_half_width(units, value_of) if isfinite(value) else nan
    return value, value - half, value + half


def exact(name: str) -> Estimator:
    """Return the estimator of a part of a whole that was counted in full: it has no interval."""
    return lambda sums: (float(_second_over_first(sums.total(name)[None])[0]), nan, nan)


def mean(name: str) -> Estimator:
    """Return the estimator of a mean over frames, from their number and their sum."""
    return lambda sums: _symmetric(sums.units(name), _second_over_first)


def way_over_time(name: str) -> Estimator:
    """Return the estimator of a way over a time, from the time, the way and the time taken off.

    How long the ways are that turns hide between frames is known on average only: the interval is
    wider by half of the time that was taken off for them.
    """

    def estimate(sums: Sums) -> Interval:
        value, low, high = mean(name)(sums)
        spent_s, _, lost_s = sums.total(name)
        half = value * lost_s / spent_s / 2
        return value, low - half, high + half

    return estimate


def slope(name: str) -> Estimator:
    """Return the estimator of a line through the origin, from sums of 1, x·y and x²."""
    return lambda sums: _symmetric(sums.units(name), lambda rows: over(rows[:, 1], rows[:, 2]))


def pearson_of(name: str) -> Estimator:
    """Return the estimator of Pearson's correlation."""
    return lambda sums: pearson(sums.units(name))


def median(name: str, bin_width: float) -> Estimator:
    """Return the estimator of a median, from a histogram."""

    def estimate(sums: Sums) -> Interval:
        total = sums.total(name)
        held = np.flatnonzero(total)  # nothing lies outside of these bins
        first, end = (int(held[0]), int(held[-1]) + 1) if len(held) else (0, len(total))
        parts = [trial[name][:, first:end] for trial in sums.trials if name in trial]
        return _symmetric(
            sums.units_of(parts), lambda rows: histogram_median(rows, first) * bin_width
        )

    return estimate


def direction(name: str) -> Estimator:
    """Return the estimator of a mean angle, from the sums of 1, sine and cosine, rad."""

    def estimate(sums: Sums) -> Interval:
        units = sums.units(name)
        _, up, along = units.total()
        middle = float(np.arctan2(up, along))
        half = jackknife_half_width(  # away from the mean, or π would be far from −π
            units, lambda rows: wrap_angle(np.arctan2(rows[:, 1], rows[:, 2]) - middle)
        )
        if half >= np.pi:  # a whole circle
            return nan, nan, nan
        return middle, middle - half, middle + half

    return estimate


def share(name: str) -> Estimator:
    """Return the estimator of a fraction, from n and the number of successes."""

    def estimate(sums: Sums) -> Interval:
        n, successes = (round(part) for part in sums.total(name))
        half = jackknife_half_width(sums.units(name), _second_over_first)
        return widened(fraction(successes, n), half)

    return estimate


def widened(law: Interval, half: float) -> Interval:
    """Return a fraction with the wider one of a law's interval and one symmetric in log odds."""
    value, low, high = law
    if isfinite(half) and 0 < value < 1:
        odds, stretch = value / (1 - value), exp(half / (value * (1 - value)))
        low = min(low, odds / stretch / (1 + odds / stretch))
        high = max(high, odds * stretch / (1 + odds * stretch))
    return value, low, high


def rate(name: str) -> Estimator:
    """Return the estimator of a rate, from the time (a whole exposure) and a count."""

    def estimate(sums: Sums) -> Interval:
        exposure, count = sums.total(name)
        law = poisson_rate(round(count), float(exposure))
        half = jackknife_half_width(sums.units(name), _second_over_first)
        return _wider_on_log_scale(law, half, sums.settings)

    return estimate


def _wider_on_log_scale(law: Interval, half: float, settings: EstimateSettings) -> Interval:
    """Return the wider one of a law's interval and one that is symmetric in the logarithm.

    Where leaving out parts changes the value by far more than itself, nothing bounds it.
    """
    value, low, high = law
    if isfinite(half) and value > 0:
        if half > value * log(settings.most_end_over_value):
            return value, nan, nan
        low, high = min(low, value * exp(-half / value)), max(high, value * exp(half / value))
    return value, low, high


def length(name: str, which: int | None = None, rule: str = "") -> Estimator:
    """Return the estimator of the mean of an exponential law above a limit of resolution.

    What frames hide is known only as far as the law holds for short episodes too. So the interval
    is wider by the whole correction at either end.

    Parameters
    ----------
    name : str
        The sums: complete items above the limit, and by what all items exceed it.
    which : int or None
        0, 1, 2: corrected for unseen episodes as d_c, d_nc, Δr_h; None: not corrected.
    rule : str
        Of contact, as in the sums' names.
    """

    def estimate(sums: Sums) -> Interval:
        n, excess = sums.total(name)[:2]
        if not n:
            return nan, nan, nan
        law = exponential_mean(round(n), float(excess))
        half = jackknife_half_width(sums.units(name), lambda rows: over(rows[:, 1], rows[:, 0]))
        scale = 1.0 if which is None else corrections(sums, rule)[which]
        value, low, high = _wider_on_log_scale(law, half, sums.settings)
        stretch = max(scale, 1 / scale)
        return value * scale, low * scale / stretch, high * scale * stretch

    return estimate


def reversal_chance(sums: Sums) -> Interval:
    """Estimate the chance of a reversal per cycle of slide and hop, gaps bridged.

    A fold hides the change of cycle at which the worm turned: it is a pair that differs. The other
    changes of cycle in it are left out, as likely to differ as those that are seen. The worm may
    turn in the cycles that frames hide more than in others: the interval allows for a half of them.
    """
    units = _with_gaps(sums, "reversal_per_cycle", 5)

    def folds_of(rows: Floats) -> tuple[Floats, Floats]:
        pairs, reversals, gaps, turned, gap_s, cycles, cycles_s = rows.T
        in_gap = np.nan_to_num(over(gap_s, gaps) / over(cycles_s, cycles))

        def kept(folds: Floats) -> Floats:
            chance = np.nan_to_num(over(reversals + folds, pairs + folds))
            mean: Floats = np.maximum(1 - 2 * chance, 0.0) ** in_gap
            return mean

        return _folds(gaps, turned, kept, sums.settings)

    def value_of(rows: Floats) -> Floats:
        folds, _ = folds_of(rows)
        return over(rows[:, 1] + folds, rows[:, 0] + folds)

    total = units.total()[None]
    (folds,), (kept,) = folds_of(total)
    pairs, reversals = (float(part) for part in total[0, :2] + folds)
    law = fraction(round(reversals * kept), round(pairs * kept))
    seen = (reversals / pairs, *law[1:])
    cycles = _cycles_in_one(sums)
    value, low, high = (
        per_true_cycle(end, cycles) for end in widened(seen, jackknife_half_width(units, value_of))
    )
    hidden = max(1 - 1 / cycles, 0.0)
    return value, low, high + hidden * max(0.5 - high, 0.0)


def reversal_rate(sums: Sums) -> Interval:
    """Estimate the rate at which θ̇_h changes its sign, 1/s, gaps bridged."""

    def value_of(rows: Floats) -> Floats:
        directed_s, turns, gaps, turned, gap_s = rows.T
        longest = 2 * np.nan_to_num(over(gap_s, gaps))

        def kept(folds: Floats) -> Floats:
            whole: Floats = np.exp(-longest * np.nan_to_num(over(turns + folds, directed_s)))
            return whole

        folds, _ = _folds(gaps, turned, kept, sums.settings)
        return over(turns + folds, directed_s)

    return _symmetric(_with_gaps(sums, "reversal_rate", 3), value_of)


def _with_gaps(sums: Sums, name: str, columns: int) -> Units:
    """Return sums with those of the gaps beside them; results of old have no gaps."""
    trials = [trial for trial in sums.trials if name in trial]
    none = [np.zeros((len(trial[name]), columns)) for trial in trials]
    return sums.units_of(
        [
            np.hstack([trial[name], trial.get(f"{name}_gaps", zeros)])
            for trial, zeros in zip(trials, none, strict=True)
        ]
    )


def _folds(
    gaps: Floats,
    turned: Floats,
    kept_by: Callable[[Floats], Floats],
    settings: EstimateSettings,
) -> tuple[Floats, Floats]:
    """Return how many gaps hide a reversal of their own, and the part of direction kept in one.

    In a gap as anywhere else the worm may turn, also twice: its direction would be kept by a part k
    on average. If F of B gaps are folds, with a reversal of their own, then another direction is
    seen after F(1 + k)/2 + (B − F)(1 − k)/2 of them. That is solved for F.

    Parameters
    ----------
    gaps, turned : ndarray, shape (m,)
        B, and after how many of them the direction is another one.
    kept_by : callable
        From F to k, which depends on the reversals that there are.
    """
    folds, kept = np.zeros(len(gaps)), np.ones(len(gaps))
    rounds = settings.fold_rounds if gaps.any() else 1  # without gaps there is nothing to solve
    for _ in range(rounds):
        kept = np.maximum(kept_by(folds), settings.least_kept_over_gap)
        folds = np.clip((turned - gaps * (1 - kept) / 2) / kept, 0.0, gaps)
    return folds, kept


def _cycles_in_one(sums: Sums) -> float:
    """Return how many cycles of slide and hop an observed one holds: 1, where frames are dense."""
    observed_m = true_m = 0.0
    for name, scale in zip(("d_c", "d_nc"), corrections(sums), strict=False):
        n_above, excess_m, n, whole_m = sums.total(name)
        if not (n and n_above):
            return 1.0
        observed_m += whole_m / n
        true_m += scale * excess_m / n_above
    return observed_m / true_m if true_m > 0 else 1.0


def exponential_fit(name: str, bin_width: float) -> Estimator:
    """Return the estimator of the p value of an exponential law; it has no interval.

    Censored items, which are few, are left out. Where items are cut short at random, at a constant
    rate, the complete ones are exponential too, with a shorter mean: the test is of the law,
    whatever its mean.
    """

    def estimate(sums: Sums) -> Interval:
        total = sums.total(name)
        whole, excess = np.rint(total[:-1]).astype(np.int64), float(total[-1])
        coarse = bin_width
        if name in ("d_c_excess", "d_nc_excess"):
            coarse = sums.settings.steps_a_group * head_step_m(sums)
        elif name == "delta_r_h_excess":
            coarse = pixel_m(sums)
        per_group = max(1, round(coarse / bin_width))
        mean_excess = excess / whole.sum()
        p = exponential_p(merged_bins(whole, per_group), per_group * bin_width, float(mean_excess))
        return p, nan, nan

    return estimate


def penetration(counts: Floats, settings: PenetrationSettings = PENETRATION) -> Penetration:
    """Fit F(x_p) to the depths of failed attempts (paper, Fig. 9).

    Parameters
    ----------
    counts : ndarray, shape (k,)
        Failures in bins of 0.1 mm from the least depth that is seen; one of them is not empty.
        The range of the constant is the observed one, up to the deepest failure.
    settings : PenetrationSettings
    """
    whole = np.rint(counts).astype(np.int64)
    return _penetration(tuple(whole[: int(np.flatnonzero(whole)[-1]) + 1].tolist()), settings)


@lru_cache(maxsize=512)
def _penetration(counts: tuple[int, ...], settings: PenetrationSettings) -> Penetration:
    edges = np.arange(len(counts) + 1, dtype=np.float64) * DEPTH_BIN_M
    return fit_penetration(edges, np.array(counts, dtype=np.int64), settings)


def penetration_part(part: str) -> Estimator:
    """Return the estimator of ``beta``, ``alpha`` or ``const`` of F(x_p), 1/m."""

    def estimate(sums: Sums) -> Interval:
        units, settings = sums.units("x_p"), sums.settings

        def part_of(row: Floats) -> Interval:
            law: Interval = getattr(penetration(row, settings.penetration), part)
            return law

        half = jackknife_half_width(units, lambda rows: np.array([part_of(row)[0] for row in rows]))
        return _wider_on_log_scale(part_of(units.total()), half, settings)

    return estimate


def persistence(estimate: Callable[[Units, Floats, EstimateSettings], Interval]) -> Estimator:
    """Return the estimator of a number of C_θ: see `direction_persistence`."""
    return lambda sums: estimate(sums.units("c_theta"), sums.lag_s, sums.settings)
