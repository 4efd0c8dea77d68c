"""Whether episodes follow an exponential law: Anderson and Darling's test with a fitted mean."""

from math import exp, nan

import numpy as np

from worm_msgs_py.arrays import Integers

LARGEST_STATISTIC = 10.0
"""Beyond this the approximation of p turns round; p is below 10⁻⁶ there."""


def exponential_p(counts: Integers, width: float, mean: float) -> float:
    """Return the probability of a fit as bad as this one, were the law exponential.

    Parameters
    ----------
    counts : ndarray of int64, shape (m,)
        Items in bins of equal width from 0; the last bin has no end.
    width : float
        Width of a bin, much smaller than the mean.
    mean : float
        The mean that was fitted to the same items.

    Returns
    -------
    float
        NaN without items.

    Notes
    -----
    A² = n Σ (S − F)² p/(F (1 − F)) over the bins' upper edges, where S and F are the fraction of
    items below an edge and the law's, and p the law's share of a bin (Choulakian, Lockhart &
    Stephens 1994). With the mean fitted, A² (1 + 0.6/n) has a law that does not depend on the mean;
    its tail is D'Agostino & Stephens' (1986, section 4.9), good from p = 0.9 to 0.001.
    """
    n = int(counts.sum())
    if n == 0 or not mean > 0:
        return nan
    edges = width * np.arange(1, len(counts))
    below = -np.expm1(-edges / mean)
    share = np.diff(below, prepend=0.0)
    inside = share > 1e-12
    below, share = below[inside], share[inside]
    seen = np.cumsum(counts[:-1])[inside] / n
    statistic = n * float(np.sum((seen - below) ** 2 * share / (below * (1 - below))))
    return p_of_statistic(statistic * (1 + 0.6 / n))


def p_of_statistic(statistic: float) -> float:
    """Return the probability that A² (1 + 0.6/n) is larger, for an exponential law."""
    a = min(statistic, LARGEST_STATISTIC)
    if a >= 0.950:
        return exp(0.731 - 3.009 * a + 0.15 * a * a)
    if a >= 0.510:
        return exp(0.9209 - 3.353 * a + 0.300 * a * a)
    if a >= 0.260:
        return 1 - exp(-6.1327 + 20.218 * a - 18.663 * a * a)
    return 1 - exp(-12.2204 + 67.459 * a - 110.3 * a * a)


def merged_bins(counts: Integers, per_group: int) -> Integers:
    """Return the counts of so many bins together; the last group has no end.

    Parameters
    ----------
    counts : ndarray of int64, shape (m,)
        The last bin has no end.
    per_group : int
        Bins a group.
    """
    groups = np.add.reduceat(counts, np.arange(0, len(counts), per_group))
    return np.asarray(groups, dtype=np.int64)
