"""The numbers of a pool with 95 % intervals: by drawing trials again, or from events alone."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import exp, expm1, isfinite, log, nan

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import minimize

from worm_analysis.accumulators.direction_correlation import fit_decay_time
from worm_analysis.pooling.pool import Pool
from worm_analysis.pooling.trial_sums import ANGLE_EDGES_DEG, DEPTH_EDGES_MM, RADIUS_EDGES
from worm_analysis.results import Floats
from worm_analysis.statistics.estimators import (
    Estimate,
    exponential_mean,
    finite_or_none,
    fraction,
    merged_excursion_factor,
    peak_positions,
    per_true_cycle,
    poisson_rate,
    unmerged_means,
)
from worm_analysis.statistics.penetration_law import MOST_SHARE, fit_penetration
from worm_analysis.summary.paper_values import paper_value
from worm_msgs_py import Quantity

FEWEST_TRIALS = 5
"""Fewer trials cannot be drawn again: the interval then rests on events, as if all were alike."""
FEWEST, FEWEST_FOR_DECAY = 10, 20
FITS = 200
"""Resamples of what must be fitted anew for each."""
TRIAL_S = 1800.0
RADIUS_SMOOTHING, ANGLE_SMOOTHING = 2.0, 4.0
"""In bins of R/100 and of 2°, as for a single trial."""
BY_TRIALS, BY_EVENTS, NO_INTERVAL = "trials", "events", ""

Estimator = Callable[[Floats], Floats]
"""From sums of shape (m, k) to m values."""


@dataclass(frozen=True, slots=True)
class Pooled:
    """A number of a pool.

    Attributes
    ----------
    quantity : Quantity
        `n` counts events or frames.
    trials : int
        Trials that it rests on.
    by : str
        What the interval comes from: ``trials``, drawn again with replacement; ``events``, where
        there are fewer than five trials; or nothing.
    """

    quantity: Quantity
    trials: int
    by: str = NO_INTERVAL


@dataclass(frozen=True, slots=True)
class _Recipe:
    """How a number follows from sums, and what its n is."""

    name: str
    unit: str
    sums: tuple[str, ...]
    n: Callable[[Floats], float]
    estimate: Estimator
    items: str
    from_events: Callable[[Floats], Estimate] | None = None
    fewest: int = FEWEST
    n_shown: Callable[[Floats], float] | None = None
    resamples: int = 1000


def pooled_quantities(pool: Pool) -> list[Pooled]:
    """Return every number of a pool; one that cannot be had has a reason."""
    return [_pooled(pool, recipe) for recipe in _recipes(pool)]


def pooled_quantity(pool: Pool, name: str) -> Pooled:
    """Return one number of a pool."""
    return next(_pooled(pool, recipe) for recipe in _recipes(pool) if recipe.name == name)


def _pooled(pool: Pool, recipe: _Recipe) -> Pooled:
    paper = paper_value(recipe.name, pool.width_mm * 1e-3)
    trials = len(_with_data(pool, recipe))

    def without(why: str, n: int = 0) -> Pooled:
        return Pooled(
            Quantity(recipe.name, None, n=n, unit=recipe.unit, paper=paper, why=why), trials
        )

    if not trials:
        return without("no trial has it")
    total = np.concatenate([pool.total(name) for name in recipe.sums])
    n = round(recipe.n(total))
    if n < recipe.fewest:
        return without(f"not enough data: {n} {recipe.items}, {recipe.fewest} are needed", n)
    value = float(recipe.estimate(total[None])[0])
    if not isfinite(value):
        return without("the data do not determine it", n)
    low, high, by = nan, nan, NO_INTERVAL
    if trials >= FEWEST_TRIALS:
        drawn = np.hstack([pool.resampled(name, recipe.resamples) for name in recipe.sums])
        values = recipe.estimate(drawn)
        values = values[np.isfinite(values)]
        if len(values) > 0.9 * recipe.resamples:
            low, high = (float(end) for end in np.quantile(values, (0.025, 0.975)))
            by = BY_TRIALS
    elif recipe.from_events is not None:
        _, low, high = recipe.from_events(total)
        by = BY_EVENTS
    if recipe.n_shown is not None:
        n = round(recipe.n_shown(total))
    least, most = finite_or_none(low), finite_or_none(high)
    return Pooled(Quantity(recipe.name, value, least, most, n, recipe.unit, paper), trials, by)


def _with_data(pool: Pool, recipe: _Recipe) -> list[int]:
    return [
        k
        for k, trial in enumerate(pool.trials)
        if all(name in trial.sums for name in recipe.sums)
        and recipe.n(np.concatenate([trial.sums[name] for name in recipe.sums])) > 0
    ]


def _recipes(pool: Pool) -> list[_Recipe]:
    first, second = (lambda s: float(s[0])), (lambda s: float(s[1]))
    episodes = ("d_c", "d_nc", "advance")
    contacts = "complete contacts above the resolution limit"
    excursions = "complete excursions above the resolution limit"
    recipes = [
        _Recipe(
            f"r_{point}_over_R", "1", (f"r_{point}",), np.sum, _radius_peak, "frames in a chamber"
        )
        for point in "hct"
    ]
    recipes += [
        _Recipe(
            f"psi_b_{side}_peak", "deg", ("psi_b",), np.sum, partial(_angle_peak, sign),
            "frames with a body angle",
        )
        for side, sign in (("negative", -1), ("positive", 1))
    ]  # fmt: skip
    recipes += [
        _Recipe("contact_fraction", "1", ("contact_fraction",), second, _ratio,
                "frames in a chamber"),
        _Recipe("d_c", "mm", episodes, first, partial(_length, 0), contacts,
                lambda s: _scaled_mean(0, s)),
        _Recipe("d_nc", "mm", episodes, lambda s: float(s[2]), partial(_length, 1), excursions,
                lambda s: _scaled_mean(1, s)),
        _Recipe("delta_r_h", "mm", ("delta_r_h", *episodes), first, _depth, excursions,
                _depth_interval),
        _Recipe("v_w", "mm/s", ("v_w",), lambda s: float(s[2]), _ratio, "windows of time"),
        _Recipe("v_b", "mm/s", ("v_b",), second, _ratio, "frames with a speed"),
        _Recipe("theta_dot_psi_b_correlation", "1", ("theta_dot_psi_b",), first, _pearson,
                "frames with a speed and a body angle"),
        _Recipe("theta_dot_incidence_correlation", "1", ("theta_dot_incidence",), first, _pearson,
                "contacts with an incidence and a speed after it"),
        _Recipe("reversal_per_cycle", "1", ("reversal_per_cycle", *episodes, "whole_episodes"),
                second, _reversals, "pairs of cycles", _reversals_interval),
        _Recipe("tau_h", "s", ("tau_h",), first, lambda s: _over(s[:, 1], s[:, 0]),
                "findings of the exit after a contact",
                lambda s: exponential_mean(round(s[0]), float(s[1]))),
        _Recipe("n_s", "per 30 min", ("n_s",), second,
                lambda s: TRIAL_S * _over(s[:, 0], s[:, 1]), "seconds in a chamber", _skips,
                n_shown=first),
    ]  # fmt: skip
    for name, items in (
        ("success", "decided attempts"),
        ("failures_without_contact", "failed attempts in which contact can be told"),
        ("failures_in_elongation", "failed attempts with a known phase of the stroke"),
        ("failures_touching_in_elongation", "failed attempts whose cause can be told"),
        ("failures_touching_in_contraction", "failed attempts whose cause can be told"),
    ):
        recipes.append(
            _Recipe(name, "1", (name,), second, _ratio, items,
                    lambda s: fraction(round(s[0]), round(s[1])))
        )  # fmt: skip
    recipes.append(
        _Recipe("beta", "1/mm", ("x_p",), np.sum, partial(_betas, pool), "failed attempts",
                partial(_decay, pool), FEWEST_FOR_DECAY, resamples=FITS)
    )  # fmt: skip
    if pool.lags_agree:
        lag_s = pool.trials[0].lag_s
        k = len(lag_s)
        recipes.append(
            _Recipe("t_per", "s", ("c_theta",), lambda s: float(s[k]), partial(_t_per, lag_s),
                    "moments with a direction", resamples=FITS)
        )  # fmt: skip
    return recipes


def _over(above: Floats, below: Floats) -> Floats:
    ratio: Floats = np.divide(above, below, out=np.full(len(above), nan), where=below > 0)
    return ratio


def _ratio(sums: Floats) -> Floats:
    return _over(sums[:, 0], sums[:, 1])


def _radius_peak(sums: Floats) -> Floats:
    smoothed = gaussian_filter1d(sums, RADIUS_SMOOTHING, axis=1, mode="constant")
    return peak_positions(smoothed, (RADIUS_EDGES[1:] + RADIUS_EDGES[:-1]) / 2)


def _angle_peak(sign: int, sums: Floats) -> Floats:
    half = (len(ANGLE_EDGES_DEG) - 1) // 2
    side = slice(half, None) if sign > 0 else slice(0, half)
    smoothed = gaussian_filter1d(sums, ANGLE_SMOOTHING, axis=1, mode="wrap")
    centres = (ANGLE_EDGES_DEG[1:] + ANGLE_EDGES_DEG[:-1]) / 2
    return peak_positions(smoothed[:, side], centres[side])


def _true_means(row: Floats) -> tuple[float, float, float]:
    """Return ⟨d_c⟩, ⟨d_nc⟩ and the head's step from their sums and the advance's."""
    if not (row[0] > 0 and row[2] > 0 and row[5] > 0):
        return nan, nan, nan
    step = float(row[4] / row[5])
    seen = float(row[1] / row[0]), float(row[3] / row[2])
    return (*(unmerged_means(*seen, step) if step > 0 else seen), step)


def _length(which: int, sums: Floats) -> Floats:
    return np.array([_true_means(row)[which] for row in sums])


def _scaled_mean(which: int, row: Floats) -> Estimate:
    value, low, high = exponential_mean(round(row[2 * which]), float(row[2 * which + 1]))
    scale = _true_means(row)[which] / value
    return value * scale, low * scale, high * scale


def _cycles_in_one(row: Floats) -> float:
    """Return how many true cycles an observed one holds, as `episode_quantities` does."""
    true = _true_means(row[2:8])
    n_c, whole_c, n_nc, whole_nc = row[8:]
    if not (n_c > 0 and n_nc > 0 and isfinite(true[0]) and true[0] + true[1] > 0):
        return 1.0
    return max(1.0, float(whole_c / n_c + whole_nc / n_nc) / (true[0] + true[1]))


def _reversals(sums: Floats) -> Floats:
    observed = _ratio(sums)
    return np.array(
        [
            per_true_cycle(seen, _cycles_in_one(row))
            for seen, row in zip(observed, sums, strict=True)
        ]
    )


def _reversals_interval(row: Floats) -> Estimate:
    cycles = _cycles_in_one(row)
    value, low, high = fraction(round(row[0]), round(row[1]))
    return (
        per_true_cycle(value, cycles),
        per_true_cycle(low, cycles),
        per_true_cycle(high, cycles),
    )


def _depth(sums: Floats) -> Floats:
    return np.array([_depth_interval(row)[0] for row in sums])


def _depth_interval(row: Floats) -> Estimate:
    if not row[0] > 0:
        return nan, nan, nan
    mean_c, _, step = _true_means(row[2:])
    scale = 1 / merged_excursion_factor(mean_c, step) if isfinite(mean_c) else 1.0
    value, low, high = exponential_mean(round(row[0]), float(row[1]))
    return value * scale, low * scale, high * scale


def _pearson(sums: Floats) -> Floats:
    n, x, y, xx, yy, xy = sums.T
    with np.errstate(divide="ignore", invalid="ignore"):
        var_x, var_y = xx / n - (x / n) ** 2, yy / n - (y / n) ** 2
        return np.asarray((xy / n - x * y / n**2) / np.sqrt(var_x * var_y))


def _skips(row: Floats) -> Estimate:
    value, low, high = poisson_rate(round(row[0]), float(row[1]))
    return TRIAL_S * value, TRIAL_S * low, TRIAL_S * high


def _t_per(lag_s: Floats, sums: Floats) -> Floats:
    found = []
    for row in sums:
        products, pairs = np.split(row, 2)
        found.append(fit_decay_time(lag_s, _over(products, pairs), np.rint(pairs).astype(np.int64)))
    return np.array(found)


def penetration_range(pool: Pool, counts: Floats) -> slice:
    """Return the bins of F(x_p) that are fitted: from the circle's bulge on, to the deepest."""
    half = pool.width_mm / 2
    bulge = pool.radius_mm - np.sqrt(pool.radius_mm**2 - half**2) if isfinite(half) else 0.0
    first = int(np.searchsorted(DEPTH_EDGES_MM, bulge - 1e-9))
    held = np.flatnonzero(counts)
    return slice(first, max(first + 2, int(held[-1]) + 1 if len(held) else 0))


def _decay(pool: Pool, counts: Floats) -> Estimate:
    chosen = penetration_range(pool, counts)
    if counts[chosen].sum() < FEWEST_FOR_DECAY:
        return nan, nan, nan
    edges = DEPTH_EDGES_MM[chosen.start : chosen.stop + 1]
    return fit_penetration(edges, np.rint(counts[chosen]).astype(np.int64)).beta


def _betas(pool: Pool, sums: Floats) -> Floats:
    """Return β of each row: of one row as for a trial, of resamples by a search from there."""
    total = pool.total("x_p")
    if len(sums) == 1:
        return np.array([_decay(pool, sums[0])[0]])
    chosen = penetration_range(pool, total)
    edges = DEPTH_EDGES_MM[chosen.start : chosen.stop + 1]
    best = fit_penetration(edges, np.rint(total[chosen]).astype(np.int64))
    span = float(edges[-1] - edges[0])
    start = np.array([log(best.beta[0]), min(best.const[0] * span, MOST_SHARE)])
    depth = edges - edges[0]
    even = np.diff(depth) / span

    def loss(x: Floats, counts: Floats) -> float:
        beta, share = exp(x[0]), x[1]
        decay = -np.diff(np.exp(-beta * depth)) / -expm1(-beta * span)
        chance = (1 - share) * decay + share * even
        return -float(counts @ np.log(np.maximum(chance, 1e-300)))

    bounds = [(log(0.1 / span), log(4 / float(depth[1]))), (0.0, MOST_SHARE)]
    found = [
        minimize(loss, start, (row,), method="L-BFGS-B", bounds=bounds).x[0]
        for row in sums[:, chosen]
    ]
    return np.asarray(np.exp(found), dtype=np.float64)
