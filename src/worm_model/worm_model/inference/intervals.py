"""95 % intervals of counts and of exponential means, as the analysis gives them."""

from math import inf, nan

from scipy.special import betaincinv, chdtri

Interval = tuple[float, float, float]
"""Value, low, high."""
NOTHING: Interval = (nan, nan, nan)
TAIL_PROBABILITY = 0.025


def fraction(count: int, n: int) -> Interval:
    """Return a fraction and its Clopper–Pearson interval; NaN where n is 0."""
    if n < 1:
        return NOTHING
    low = float(betaincinv(count, n - count + 1, TAIL_PROBABILITY)) if count > 0 else 0.0
    high = float(betaincinv(count + 1, n - count, 1.0 - TAIL_PROBABILITY)) if count < n else 1.0
    return count / n, low, high


def exponential_mean(n: int, total: float) -> Interval:
    """Return the mean of an exponential law from n ends and the time under way in all.

    What is still under way counts in `total` and not in n. NaN where n is 0.
    """
    if n < 1 or not total > 0.0:
        return NOTHING
    low, high = (
        2.0 * total / float(chdtri(2 * n, tail))
        for tail in (TAIL_PROBABILITY, 1.0 - TAIL_PROBABILITY)
    )
    return total / n, low, high


def intervals_overlap(one: Interval, other: Interval) -> bool:
    """Whether two intervals have a value in common; an open end is as far as it can be."""
    ends = [(_or(low, -inf), _or(high, inf)) for _, low, high in (one, other)]
    return max(ends[0][0], ends[1][0]) <= min(ends[0][1], ends[1][1])


def _or(end: float, otherwise: float) -> float:
    return end if end == end else otherwise
