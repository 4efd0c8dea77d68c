"""C_θ(t), its error and how fast it decays, from sums over pairs of moments (paper, Fig. 7a)."""

from collections.abc import Callable
from functools import lru_cache
from math import exp, isfinite, log, nan

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.settings import DEFAULTS, EstimateSettings
from worm_msgs_py import Correlation
from worm_msgs_py.arrays import Floats, Integers, Mask
from worm_msgs_py.intervals import NORMAL_95, Interval

ONE_E = exp(-1.0)


class NotEnoughData(ValueError):  # noqa: N818 (it is what the data are)
    """A number cannot be had; the message is the reason."""


def correlation_curve(units: Units) -> tuple[Floats, Integers]:
    """Return C_θ (NaN where there are no pairs) and the number of pairs at each lag.

    Parameters
    ----------
    units : Units
        The number of pairs at each lag, then the sums of their products.
    """
    return units.once("curve", lambda: _curve(units))


def _curve(units: Units) -> tuple[Floats, Integers]:
    pairs, products = np.split(units.total(), 2)
    c = np.divide(products, pairs, out=np.full(len(pairs), nan), where=pairs > 0)
    return c, np.rint(pairs).astype(np.int64)


def correlation(
    units: Units, lag_s: Floats, t_per_s: float | None, settings: EstimateSettings = DEFAULTS
) -> Correlation:
    """Return the curve, its error and the exponential of a decay time."""
    c, pairs = correlation_curve(units)
    model = np.full(len(c), nan) if t_per_s is None else np.exp(-lag_s / t_per_s)
    return Correlation(lag_s, c, _error(units, settings), pairs, model)


def _error(units: Units, settings: EstimateSettings) -> Floats:
    """Return one standard error at each lag from parts of the data; NaN with too few of them.

    The largest one over all sizes of parts is taken, as blocks shorter than the correlation time
    make it too small. Long lags may have nearly all of their pairs in a few parts: the error is
    widened by Student's law for the parts' effective number (Σ pairs)²/Σ pairs², so that 1.96 of it
    make a 95 % interval, and it is NaN with fewer than five.
    """
    c, pairs = correlation_curve(units)
    worst = np.full(len(c), nan)
    unknown = np.zeros(len(c), dtype=np.bool_)
    for rows, residuals in zip(units.levels(), _residuals_by_level(units), strict=True):
        squares = np.maximum(np.sum(rows[:, : len(c)] ** 2, axis=0), 1.0)
        k = pairs.astype(np.float64) ** 2 / squares
        unknown |= k < settings.fewest_parts_at_lag
        k = np.maximum(k, settings.fewest_parts_at_lag)
        squares = np.sum(residuals**2, axis=0) * (k / (k - 1))
        error = np.sqrt(squares) / np.maximum(pairs, 1)
        worst = np.fmax(worst, error * stdtrit(k - 1, 0.975) / NORMAL_95)
    worst[unknown] = nan
    return worst


def persistence_time(
    units: Units, lag_s: Floats, settings: EstimateSettings = DEFAULTS
) -> Interval:
    """Return t_per, s: the decay time of exp(−t/t_per), fitted to C_θ.

    Least squares over all lags, weighted by the number of pairs. The interval is the fit's linear
    response to each part of the data, on a logarithmic scale.

    Raises
    ------
    NotEnoughData
        Where the track is too short to tell.
    """
    fitted = _decay_time(units, lag_s, settings)
    return _interval_on_log_scale(
        fitted, _half_width_of_response(units, _of_fit(units, lag_s, fitted)), settings
    )


def _decay_time(units: Units, lag_s: Floats, settings: EstimateSettings) -> float:
    c, pairs = correlation_curve(units)
    fitted = fit_decay_time(lag_s, c, pairs)
    if not isfinite(fitted):
        raise NotEnoughData("the correlation does not decay within the longest lag observed")
    _refuse_short(fitted, "the decay time", pairs, lag_s, settings)
    return fitted


def fall_time(units: Units, lag_s: Floats, settings: EstimateSettings = DEFAULTS) -> Interval:
    """Return the time at which C_θ has fallen to 1/e, s, whatever its form.

    The interval is the curve's error there over its slope, on a logarithmic scale.

    Raises
    ------
    NotEnoughData
        Where it does not fall so far, or the track is too short to tell.
    """
    at_s, response = _fall(units, lag_s, settings)
    return _interval_on_log_scale(at_s, _half_width_of_response(units, response), settings)


def _fall(units: Units, lag_s: Floats, settings: EstimateSettings) -> tuple[float, "Response"]:
    _, pairs = correlation_curve(units)
    at_s, response = _of_fall(units, lag_s, settings)
    _refuse_short(at_s, "the time to 1/e", pairs, lag_s, settings)
    return at_s, response


def fall_over_decay(units: Units, lag_s: Floats, settings: EstimateSettings = DEFAULTS) -> Interval:
    """Return the time to 1/e over t_per: 1 where C_θ is one exponential.

    Both rest on the same pairs and err together, so this is told better than either.

    Raises
    ------
    NotEnoughData
        Where one of the two cannot be had.
    """
    decay_s = _decay_time(units, lag_s, settings)
    at_s, of_fall = _fall(units, lag_s, settings)
    of_fit = _of_fit(units, lag_s, decay_s)
    half = _half_width_of_response(units, lambda residuals: of_fall(residuals) - of_fit(residuals))
    return _interval_on_log_scale(at_s / decay_s, half, settings)


def tail_excess(units: Units, lag_s: Floats, settings: EstimateSettings = DEFAULTS) -> Interval:
    """Return by how much C_θ lies above its exponential fit on average, from 1.5 to 4 t_per.

    It ends sooner where pairs do: visits may be shorter than that. 0 where C_θ is one exponential.
    A direction that is lost for moments and kept for long has its 1/e where the fit has it, and a
    tail that the fit has not.

    Raises
    ------
    NotEnoughData
        There is no t_per, or too few pairs at these lags.
    """
    _, pairs = correlation_curve(units)
    decay_s = persistence_time(units, lag_s, settings)[0]
    first, last = settings.tail_in_t_per
    inside = (lag_s >= first * decay_s) & (lag_s <= last * decay_s)
    few = np.flatnonzero(inside & (pairs < settings.fewest_pairs_in_tail * pairs[0]))
    if len(few):
        inside[few[0] :] = False
    far_enough = not len(few) or lag_s[few[0]] > settings.shortest_tail_in_t_per * decay_s
    if not (inside.any() and far_enough):
        raise NotEnoughData("not enough data at lags of several decay times")
    return _excess(units, lag_s, decay_s, inside)


def start_excess(units: Units, lag_s: Floats, settings: EstimateSettings = DEFAULTS) -> Interval:
    """Return the same of the lags up to half of t_per, which every visit has.

    A direction that is lost for moments falls below the fit at once; where it is kept for longer
    than visits last, its tail is not seen.

    Raises
    ------
    NotEnoughData
        There is no t_per, or it is too short for any lag.
    """
    decay_s = persistence_time(units, lag_s, settings)[0]
    inside = (lag_s > 0) & (lag_s <= settings.start_in_t_per * decay_s)
    if not inside.any():
        raise NotEnoughData("the correlation decays within the shortest lags")
    return _excess(units, lag_s, decay_s, inside)


def _excess(units: Units, lag_s: Floats, decay_s: float, inside: Mask) -> Interval:
    """Return by how much C_θ lies above its fit on average at some lags."""
    c, pairs = correlation_curve(units)
    of_fit = _of_fit(units, lag_s, decay_s)
    weight = np.where(inside, np.gradient(lag_s), 0.0)
    weight /= weight.sum()
    fit = np.exp(-lag_s / decay_s)
    value = float(np.sum((np.nan_to_num(c) - fit) * weight))
    turn = float(np.sum(weight * lag_s / decay_s * fit))

    def response(residuals: Floats) -> Floats:
        answered: Floats = residuals @ (weight / np.maximum(pairs, 1))
        return answered - turn * of_fit(residuals)

    half = _half_width_of_response(units, response)
    return value, value - half, value + half


Response = Callable[[Floats], Floats]
"""From the residuals of each part to what it changes in a number, or in its logarithm."""


def _refuse_short(
    time_s: float, what: str, pairs: Integers, lag_s: Floats, settings: EstimateSettings
) -> None:
    shortest_track = settings.shortest_track_in_t_per
    observed_s = float(pairs[0] * lag_s[1])
    if observed_s < shortest_track * time_s:
        raise NotEnoughData(
            f"not enough data: {observed_s:.0f} s with a direction of motion, less than "
            f"{shortest_track:.0f} times {what} of about {time_s:.0f} s"
        )


def _half_width_of_response(units: Units, response: Response) -> float:
    """Return half of a 95 % interval, from the linear response to each part."""
    half = nan
    for residuals in _residuals_by_level(units):
        k = len(residuals)
        error = float(np.sqrt(np.sum(response(residuals) ** 2) * (k / (k - 1))))
        half = float(np.fmax(half, stdtrit(k - 1, 0.975) * error))
    if not isfinite(half):
        fewest = units.settings.fewest_blocks
        raise NotEnoughData(f"not enough data: fewer than {fewest} independent stretches of time")
    return half


def _interval_on_log_scale(value: float, half: float, settings: EstimateSettings) -> Interval:
    """Return the interval; without ends where C_θ is so flat that nothing bounds the time."""
    if half > log(settings.most_end_over_value):
        return value, nan, nan
    return value, value * exp(-half), value * exp(half)


def _of_fit(units: Units, lag_s: Floats, fitted_s: float) -> Response:
    """Return how t_per answers to each part."""
    _, pairs = correlation_curve(units)
    slope = lag_s / fitted_s * np.exp(-lag_s / fitted_s)
    leverage = float(np.sum(pairs * slope**2))

    def response(residuals: Floats) -> Floats:
        answered: Floats = np.sum(residuals * slope, axis=1) / leverage
        return answered

    return response


def _of_fall(units: Units, lag_s: Floats, settings: EstimateSettings) -> tuple[float, Response]:
    """Return when C_θ is 1/e for the first time, and how that answers to each part."""
    c, pairs = correlation_curve(units)
    below = np.flatnonzero(c < ONE_E)
    if not len(below) or below[0] == 0 or not isfinite(c[below[0] - 1]):
        raise NotEnoughData("the correlation does not fall to 1/e within the lags observed")
    after = int(below[0])
    part = (c[after - 1] - ONE_E) / (c[after - 1] - c[after])
    at_s = float(lag_s[after - 1] + part * (lag_s[after] - lag_s[after - 1]))
    near = (np.abs(lag_s - at_s) <= settings.slope_span * at_s) & np.isfinite(c)
    near[after - 1 : after + 1] = True
    slope = float(np.polyfit(lag_s[near], c[near], 1)[0])
    if not slope < 0:
        raise NotEnoughData("the correlation does not fall steadily where it is 1/e")

    def response(residuals: Floats) -> Floats:
        changes = residuals[:, after - 1 : after + 1] / pairs[after - 1 : after + 1]
        answered: Floats = changes @ [1 - part, part] / (-slope * at_s)
        return answered

    return at_s, response


def _residuals_by_level(units: Units) -> list[Floats]:
    """Return what the products of each part exceed those of C_θ by, level by level."""
    return units.once("residuals", lambda: _residuals(units))


def _residuals(units: Units) -> list[Floats]:
    c = np.nan_to_num(correlation_curve(units)[0])
    return [rows[:, len(c) :] - c * rows[:, : len(c)] for rows in units.levels()]


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
