"""Whether estimates of one number differ by more than their intervals allow: Cochran's test."""

from collections.abc import Sequence
from math import nan

import numpy as np
from scipy.special import chdtrc

from worm_msgs_py.intervals import NORMAL_95, Interval

DEVIATIONS_IN_INTERVAL = 2 * NORMAL_95
"""Standard deviations in a 95 % interval."""


def same_number_p(estimates: Sequence[Interval]) -> float:
    """Return the probability of estimates as different as these, were they all of one number.

    Parameters
    ----------
    estimates : sequence of (value, low, high)
        With their 95 % intervals. Where all are positive they are compared by their logarithms.

    Returns
    -------
    float
        NaN for fewer than two with an interval of some width.

    Notes
    -----
    Q = Σ w (x − x̄)² with w = 1/σ² and x̄ the mean so weighted follows χ² with one degree of freedom
    less than there are estimates (Cochran 1954).
    """
    found = np.array([item for item in estimates if item[1] < item[2]], dtype=np.float64)
    if len(found) < 2:
        return nan
    if (found > 0).all():
        found = np.log(found)
    x, weight = found[:, 0], (DEVIATIONS_IN_INTERVAL / (found[:, 2] - found[:, 1])) ** 2
    q = float(np.sum(weight * (x - np.sum(weight * x) / np.sum(weight)) ** 2))
    return float(chdtrc(len(x) - 1, q))
