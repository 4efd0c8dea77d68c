"""C_θ(t), its error and its decay time t_per from sums over pairs of moments (paper, Fig. 7a)."""

from functools import lru_cache
from math import exp, isfinite, nan

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.settings import DEFAULTS
from worm_msgs_py import Correlation
from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.intervals import Interval

FEWEST_PARTS_AT_LAG = 5
"""Fewer parts with pairs at a lag say nothing of the error there."""
NORMAL = 1.959964
"""Half the width of a 95 % interval in standard deviations, where the parts are many."""


class NotEnoughData(ValueError):  # noqa: N818 (it is what the data are)
    """A number cannot be had; the message is the reason."""


def correlation_curve(units: Units) -> tuple[Floats, Integers]:
    """Return C_θ (NaN where there are no pairs) and the number of pairs at each lag.

    Parameters
    ----------
    units : Units
        The number of pairs at each lag, then the sums of their products.
    """
    pairs, products = np.split(units.total(), 2)
    c = np.divide(products, pairs, out=np.full(len(pairs), nan), where=pairs > 0)
    return c, np.rint(pairs).astype(np.int64)


def correlation(units: Units, lag_s: Floats, t_per_s: float | None) -> Correlation:
    """Return the curve, its error and the exponential of a decay time."""
    c, pairs = correlation_curve(units)
    model = np.full(len(c), nan) if t_per_s is None else np.exp(-lag_s / t_per_s)
    return Correlation(lag_s, c, _error(units), pairs, model)


def _error(units: Units) -> Floats:
    """Return one standard error at each lag from parts of the data; NaN with too few of them.

    The largest one over all sizes of parts is taken, as blocks shorter than the correlation time
    make it too small. Long lags may have nearly all of their pairs in a few parts: the error is
    widened by Student's law for the parts' effective number (Σ pairs)²/Σ pairs², so that 1.96 of it
    make a 95 % interval, and it is NaN with fewer than five.
    """
    c, pairs = correlation_curve(units)
    worst = np.full(len(c), nan)
    unknown = np.zeros(len(c), dtype=np.bool_)
    for rows in units.levels():
        squares = np.maximum(np.sum(rows[:, : len(c)] ** 2, axis=0), 1.0)
        k = pairs.astype(np.float64) ** 2 / squares
        unknown |= k < FEWEST_PARTS_AT_LAG
        k = np.maximum(k, FEWEST_PARTS_AT_LAG)
        squares = np.sum(_residuals(rows, c) ** 2, axis=0) * (k / (k - 1))
        error = np.sqrt(squares) / np.maximum(pairs, 1)
        worst = np.fmax(worst, error * stdtrit(k - 1, 0.975) / NORMAL)
    worst[unknown] = nan
    return worst


def persistence_time(
    units: Units, lag_s: Floats, shortest_track: float = DEFAULTS.shortest_track_in_t_per
) -> Interval:
    """Return t_per, s: the decay time of exp(−t/t_per), fitted to C_θ.

    Least squares over all lags, weighted by the number of pairs. The interval is the fit's linear
    response to each part of the data, on a logarithmic scale.

    Raises
    ------
    NotEnoughData
        Where the track is too short to tell.
    """
    c, pairs = correlation_curve(units)
    observed_s = float(pairs[0] * lag_s[1])
    fitted = fit_decay_time(lag_s, c, pairs)
    if not isfinite(fitted):
        raise NotEnoughData("the correlation does not decay within the longest lag observed")
    if observed_s < shortest_track * fitted:
        raise NotEnoughData(
            f"not enough data: {observed_s:.0f} s with a direction of motion, less than "
            f"{shortest_track:.0f} times the decay time of about {fitted:.0f} s"
        )
    half = nan
    slope = lag_s / fitted * np.exp(-lag_s / fitted)
    leverage = float(np.sum(pairs * slope**2))
    for rows in units.levels():
        response = np.sum(_residuals(rows, c) * slope, axis=1) / leverage
        k = len(rows)
        error = float(np.sqrt(np.sum(response**2) * (k / (k - 1))))
        half = float(np.fmax(half, stdtrit(k - 1, 0.975) * error))
    if not isfinite(half):
        raise NotEnoughData("not enough data: fewer than eight independent stretches of time")
    return fitted, fitted * exp(-half), fitted * exp(half)


def _residuals(rows: Floats, c: Floats) -> Floats:
    pairs, products = np.split(rows, 2, axis=1)
    residuals: Floats = products - np.nan_to_num(c) * pairs
    return residuals


def fit_decay_time(lag_s: Floats, c: Floats, pairs: Integers) -> float:
    """Return t_per of the exp(−t/t_per) that is nearest to C_θ, weighted by pairs.

    Parameters
    ----------
    lag_s, c : ndarray, shape (n,)
        Lags in s and C_θ, NaN where there are no pairs.
    pairs : ndarray of int64, shape (n,)
        The weights.

    Returns
    -------
    float
        Seconds; NaN where C_θ decays faster than the lags resolve, or not at all.
    """
    return _fit_decay_time(lag_s.tobytes(), c.tobytes(), pairs.tobytes())


@lru_cache(maxsize=2)
def _fit_decay_time(lags: bytes, values: bytes, weights: bytes) -> float:
    """Return the same from the arrays' bytes: the curve and the number ask one after the other."""
    lag_s, c, pairs = np.frombuffer(lags), np.frombuffer(values), np.frombuffer(weights, np.int64)
    known = (pairs > 0) & np.isfinite(c) & (lag_s > 0)
    if np.count_nonzero(known) < 3:
        return float("nan")
    lag, value, weight = lag_s[known], c[known], pairs[known].astype(np.float64)
    weight /= weight.sum()
    shortest, longest = np.log(lag[0] / 3), np.log(lag[-1] * 10)

    def misfit(log_t: float) -> float:
        return float(np.sum(weight * (value - np.exp(-lag / np.exp(log_t))) ** 2))

    grid = np.linspace(shortest, longest, 120)
    misfits = (value - np.exp(-lag / np.exp(grid)[:, None])) ** 2
    best = int(np.argmin(np.sum(weight * misfits, axis=1)))
    if best in (0, len(grid) - 1):
        return float("nan")
    found = minimize_scalar(
        misfit, bounds=(grid[best - 1], grid[best + 1]), method="bounded", options={"xatol": 1e-10}
    )
    return float(np.exp(found.x))
