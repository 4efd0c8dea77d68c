"""Estimates with 95 % intervals from sums: means of exponential laws, fractions, rates, peaks."""

from math import expm1, log, log1p

import numpy as np
from scipy.special import betaincinv, chdtri

from worm_msgs_py.arrays import Floats

Estimate = tuple[float, float, float]
"""Value, low and high; NaN where it cannot be had."""

TAIL_PART = 0.025


def exponential_mean(n: int, excess: float) -> Estimate:
    """Return the mean of an exponential law by maximum likelihood.

    Parameters
    ----------
    n : int
        Number of complete items above the cut-off, 1 or more.
    excess : float
        Sum of what all items above the cut-off, censored ones too, exceed it by.

    Returns
    -------
    (float, float, float)
        excess/n and its interval: 2·excess/mean follows χ² with 2n degrees of freedom (exactly
        without censoring, closely with it).
    """
    return (
        excess / n,
        2 * excess / _chi2(2 * n, 1 - TAIL_PART),
        2 * excess / _chi2(2 * n, TAIL_PART),
    )


def unmerged_means(mean_c: float, mean_nc: float, step: float) -> tuple[float, float]:
    """Undo what sampling in frames does to the means of alternating exponential episodes.

    Between two frames a short episode can begin and end unseen; its neighbours are then taken for
    one. For a head that advances by `step` a frame, contact and no contact are a two-state Markov
    chain whose sampled runs are geometric, and the continuous rates follow from the sampled ones.

    Parameters
    ----------
    mean_c, mean_nc : float
        Means of the sampled episodes, after the cut-off.
    step : float
        The head's net advance a frame, same unit.

    Returns
    -------
    (float, float)
        Means of the true episodes; the inputs where they are too near to `step` to tell.
    """
    leave_c, leave_nc = step / (mean_c + step / 2), step / (mean_nc + step / 2)
    both = leave_c + leave_nc
    if not 0 < both < 0.9:
        return mean_c, mean_nc
    rate = -log(1 - both) / step
    return both / (rate * leave_c), both / (rate * leave_nc)


def merged_excursion_factor(mean_c: float, step: float) -> float:
    """Return by how much unseen contacts enlarge the mean of an excursion's largest depth.

    Two excursions whose contact in between falls between two frames are taken for one, which has
    the larger depth of the two. With the probability q of such a contact, exponential depths have
    the mean −ln(1 − q)/q of what they would have.

    Parameters
    ----------
    mean_c : float
        Mean length of a contact.
    step : float
        The head's net advance a frame, same unit.
    """
    unseen = 1 + expm1(-step / mean_c) * mean_c / step if step > 0 else 0.0
    return -log1p(-unseen) / unseen if unseen > 1e-12 else 1.0


def per_true_cycle(observed: float, cycles: float) -> float:
    """Return the chance of a reversal per cycle from that over several cycles taken for one.

    Parameters
    ----------
    observed : float
        Fraction of observed cycles that go the other way than the one before.
    cycles : float
        True cycles in an observed one, 1 or more: a slide or a hop between two frames is not seen,
        and the cycles around it are taken for one. An even number of reversals in it goes unseen.
    """
    kept = max(0.0, 1 - 2 * observed)
    return float((1 - kept ** (1 / max(1.0, cycles))) / 2) if kept > 0 else observed


def fraction(successes: int, n: int) -> Estimate:
    """Return a fraction and its Clopper–Pearson interval; n is 1 or more."""
    low = betaincinv(successes, n - successes + 1, TAIL_PART) if successes > 0 else 0.0
    high = betaincinv(successes + 1, n - successes, 1 - TAIL_PART) if successes < n else 1.0
    return successes / n, float(low), float(high)


def poisson_rate(count: int, exposure: float) -> Estimate:
    """Return a rate and its exact interval from a count; exposure is above 0."""
    low = _chi2(2 * count, TAIL_PART) / 2 if count > 0 else 0.0
    return (
        count / exposure,
        low / exposure,
        _chi2(2 * count + 2, 1 - TAIL_PART) / 2 / exposure,
    )


def peak_positions(smoothed: Floats, centres: Floats) -> Floats:
    """Return where each row has its highest value, between bins by a parabola.

    Parameters
    ----------
    smoothed : ndarray, shape (m, n)
        Smoothed histograms.
    centres : ndarray, shape (n,)
        Middle of each bin, evenly spaced.

    Returns
    -------
    ndarray, shape (m,)
        NaN where the highest value is at an end of the range: that is no peak.
    """
    top = np.argmax(smoothed, axis=1)
    rows = np.arange(len(smoothed))
    inside = (top > 0) & (top < len(centres) - 1)
    top = np.clip(top, 1, len(centres) - 2)
    left, middle, right = (smoothed[rows, top + shift] for shift in (-1, 0, 1))
    bend = left - 2 * middle + right
    shift = np.divide(left - right, 2 * bend, out=np.zeros(len(rows)), where=bend < 0)
    return np.where(inside, centres[top] + shift * (centres[1] - centres[0]), np.nan)


def _chi2(degrees: int, probability: float) -> float:
    """Return the quantile of χ²."""
    return float(chdtri(degrees, 1 - probability))
