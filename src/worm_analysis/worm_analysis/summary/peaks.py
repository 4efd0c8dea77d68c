"""Peaks and quantiles of P(r) and P(ψ): a mode is not smooth, so blocks of time are drawn anew."""

from collections.abc import Callable
from functools import lru_cache
from math import isfinite, nan

import numpy as np
from scipy.ndimage import gaussian_filter1d

from worm_analysis.accumulators.bins import ANGLE_EDGES, RADIUS_BINS_PER_R, RADIUS_EDGES
from worm_analysis.statistics.block_jackknife import Units, jackknife_half_width
from worm_analysis.statistics.histograms import bin_centres, peak_positions
from worm_analysis.summary.direction_persistence import (
    NotEnoughData,
    correlation_curve,
    fit_decay_time,
)
from worm_analysis.summary.sums import Sums
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval

RESAMPLES_AT_ONCE = 24
"""Of the blocks, that are drawn together: matrix products of so few start no threads, which cost
more than they save."""
INTERVAL_QUANTILES = (0.025, 0.975)
"""Of a 95 % interval."""


def radius_peak(name: str) -> Callable[[Sums], Interval]:
    """Return the estimator of the mode of P(r), in units of R; nothing lies beyond the wall."""
    width = 1 / RADIUS_BINS_PER_R
    centres = bin_centres(RADIUS_EDGES[: RADIUS_BINS_PER_R + 1])
    around = np.concatenate([[centres[0] - width], centres, [centres[-1] + width]])

    def smoothed(rows: Floats, sums: Sums) -> Floats:
        bins = sums.settings.radius_smoothing_bins
        smooth = gaussian_filter1d(within_wall(rows), bins, axis=1, mode="reflect")
        return np.hstack([smooth[:, :1], smooth, smooth[:, -1:]])

    return lambda sums: _peak(
        sums, name, smoothed, lambda rows: peak_positions(rows, around), width
    )


def angle_peak(name: str, side: int) -> Callable[[Sums], Interval]:
    """Return the estimator of the mode of an angle below (0) or above (1) zero, rad."""
    centres = np.split(bin_centres(ANGLE_EDGES), 2)[side]

    def smoothed(rows: Floats, sums: Sums) -> Floats:
        bins = sums.settings.angle_smoothing_bins
        smooth: Floats = gaussian_filter1d(rows, bins, axis=1, mode="wrap")
        return smooth[:, side * len(centres) : (side + 1) * len(centres)]

    width = float(centres[1] - centres[0])
    return lambda sums: _peak(
        sums, name, smoothed, lambda rows: peak_positions(rows, centres), width
    )


def _peak(
    sums: Sums,
    name: str,
    smoothed: Callable[[Floats, Sums], Floats],
    place: Callable[[Floats], Floats],
    bin_width: float,
) -> Interval:
    """Return the place of a peak, and where it is when stretches of time are drawn anew.

    The interval is wider by half a bin at either end: within a bin nothing is seen.
    """
    stretches = independent_stretches(sums)
    units = sums.units(name)
    value = float(place(smoothed(units.total()[None], sums))[0])
    if not isfinite(value):
        return nan, nan, nan
    rows = _independent_blocks(units, stretches)
    drawn = smoothed(rows, sums)
    drawings = _drawings(len(rows), sums.settings.resamples)
    places = place(np.vstack([drawing @ drawn for drawing in drawings]))
    if not np.isfinite(places).all():
        raise NotEnoughData("there is no such peak in part of the time")
    in_order = np.sort(places)
    low, high = (_quantile_of(in_order, part) for part in INTERVAL_QUANTILES)
    return value, min(low, value) - bin_width / 2, max(high, value) + bin_width / 2


def independent_stretches(sums: Sums) -> float:
    """Return the time of the search in units of t_per.

    Raises
    ------
    NotEnoughData
        Where it is less than ten, or t_per is not known.
    """
    return sums.once("stretches", lambda: _independent_stretches(sums))


def _independent_stretches(sums: Sums) -> float:
    if not (sums.has("c_theta") and sums.has("search_bridged")):
        raise NotEnoughData("how long a direction is kept is not known")
    c, pairs = correlation_curve(sums.units("c_theta"))
    t_per_s = fit_decay_time(sums.lag_s, c, pairs) if len(sums.lag_s) else nan
    if not isfinite(t_per_s):
        raise NotEnoughData(
            "how long a direction is kept is not known, and so how much of the data is independent"
        )
    stretches = float(sums.total("search_bridged")[0]) / t_per_s
    needed = sums.settings.fewest_stretches
    if stretches < needed:
        raise NotEnoughData(
            f"not enough data: {stretches:.1f} independent stretches of time, of {t_per_s:.0f} s "
            f"each, {needed} are needed"
        )
    return stretches


def _independent_blocks(units: Units, most: float) -> Floats:
    """Return blocks of time that are long enough to be independent, shape (parts, bins)."""
    rows = np.empty((0, 0))
    for rows in units.levels():
        if len(rows) <= most:
            break
    if not len(rows):
        fewest = units.settings.fewest_blocks
        raise NotEnoughData(f"not enough data: fewer than {fewest} blocks of time")
    return rows


def _quantile_of(in_order: Floats, part: float) -> float:
    """Return what np.quantile does; that takes longer than all else here."""
    at = part * (len(in_order) - 1)
    share = at - int(at)
    below, above = in_order[int(at) : int(at) + 2]
    between = above - below
    return float(below + between * share if share < 0.5 else above - between * (1 - share))


@lru_cache(maxsize=64)
def _drawings(parts: int, resamples: int) -> list[Floats]:
    """Return how often each part is drawn, a row a drawing, in pieces; always the same ones."""
    rng = np.random.default_rng(1)
    drawings = rng.multinomial(parts, np.full(parts, 1 / parts), size=resamples).astype(np.float64)
    return np.split(drawings, np.arange(RESAMPLES_AT_ONCE, resamples, RESAMPLES_AT_ONCE))


def within_wall(rows: Floats) -> Floats:
    """Return histograms of r/R up to 1: what noise puts beyond the wall is reflected at it."""
    inside = rows[:, :RADIUS_BINS_PER_R].copy()
    beyond = rows[:, RADIUS_BINS_PER_R:]
    inside[:, -beyond.shape[1] :] += beyond[:, ::-1]
    return inside


def radius_quantile(name: str, part: float) -> Callable[[Sums], Interval]:
    """Return the estimator of a quantile of r, in units of R."""
    edges = RADIUS_EDGES[: RADIUS_BINS_PER_R + 1]
    return lambda sums: _quantile(sums, name, part, edges, within_wall)


def angle_quantile(name: str, part: float) -> Callable[[Sums], Interval]:
    """Return the estimator of a quantile of an angle in (−π, π], rad."""
    return lambda sums: _quantile(sums, name, part, ANGLE_EDGES, lambda rows: rows)


def _quantile(
    sums: Sums, name: str, part: float, edges: Floats, prepared: Callable[[Floats], Floats]
) -> Interval:
    units = sums.units(name)
    whole, cumulated = units.once("cumulated", lambda: _cumulated(prepared(units.total()[None])))
    value = float(_quantiles_of_rows(whole, cumulated, part, edges)[0])
    if not isfinite(value):
        return nan, nan, nan

    def value_of(rows: Floats) -> Floats:
        left = units.once("cumulated without one", lambda: _cumulated(prepared(rows)))
        return _quantiles_of_rows(*left, part, edges)

    half = jackknife_half_width(units, value_of)
    return value, value - half, value + half


def _cumulated(counts: Floats) -> tuple[Floats, Floats]:
    """Return counts and, beside them, how many there are up to each."""
    return counts, np.cumsum(counts, axis=1)


def _quantiles_of_rows(counts: Floats, cumulated: Floats, part: float, edges: Floats) -> Floats:
    wanted = part * cumulated[:, -1]
    rows = np.arange(len(counts))
    at = np.argmax(cumulated >= wanted[:, None], axis=1)
    inside = counts[rows, at]
    below = cumulated[rows, at] - inside
    share = np.divide(wanted - below, inside, out=np.full(len(rows), nan), where=inside > 0)
    found: Floats = edges[at] + share * (edges[at + 1] - edges[at])
    return found
