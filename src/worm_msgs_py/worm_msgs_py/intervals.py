"""95 % intervals of counts, rates and exponential means, for the analysis and the walk alike."""

from math import inf, nan

from scipy.special import betaincinv, chdtri

Interval = tuple[float, float, float]
"""Value, low, high; NaN where it cannot be had."""
NOTHING: Interval = (nan, nan, nan)
SD_OF_MAD = 1.4826
"""Of normal noise: its standard deviation over its median distance from the median."""
NORMAL_95 = 1.959964
"""Standard deviations of a normal law on either side of its mean that hold 95 %."""
_TAIL = 0.025


def fraction(count: int, n: int) -> Interval:
    """Return a fraction and its Clopper–Pearson interval; NaN where n is 0."""
    if n < 1:
        return NOTHING
    low = float(betaincinv(count, n - count + 1, _TAIL)) if count > 0 else 0.0
    high = float(betaincinv(count + 1, n - count, 1 - _TAIL)) if count < n else 1.0
    return count / n, low, high


def poisson_rate(count: int, exposure: float) -> Interval:
    """Return a rate and its exact interval from a count; exposure is above 0."""
    low = _chi2(2 * count, _TAIL) / 2 if count > 0 else 0.0
    return count / exposure, low / exposure, _chi2(2 * count + 2, 1 - _TAIL) / 2 / exposure


def exponential_mean(n: int, total: float) -> Interval:
    """Return the mean of an exponential law by maximum likelihood; NaN where n is 0.

    Parameters
    ----------
    n : int
        Number of items that have ended, above the cut-off where there is one.
    total : float
        Sum of all items, those under way or censored too, or of what they exceed the cut-off by.

    Returns
    -------
    (float, float, float)
        total/n and its interval: 2·total/mean follows χ² with 2n degrees of freedom (exactly
        without censoring, closely with it).
    """
    if n < 1:
        return NOTHING
    return total / n, 2 * total / _chi2(2 * n, 1 - _TAIL), 2 * total / _chi2(2 * n, _TAIL)


def intervals_overlap(one: Interval, other: Interval) -> bool:
    """Whether two intervals have a value in common; an open end is as far as it can be."""
    ends = [(_or(low, -inf), _or(high, inf)) for _, low, high in (one, other)]
    return max(ends[0][0], ends[1][0]) <= min(ends[0][1], ends[1][1])


def _or(end: float, otherwise: float) -> float:
    return end if end == end else otherwise


def _chi2(degrees: int, probability: float) -> float:
    """Return the quantile of χ²."""
    return float(chdtri(degrees, 1 - probability))
