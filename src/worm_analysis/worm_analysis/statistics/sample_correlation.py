"""Pearson's correlation of two series from their sums, with an interval for correlated frames."""

from math import nan

import numpy as np

from worm_analysis.statistics.block_jackknife import Units, jackknife_half_width
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval

NO_SPREAD = 1e-12
"""A variance below this part of the mean square is rounding: the series does not vary."""


def pearson(units: Units, level: float = 0.95) -> Interval:
    """Return the correlation and its interval.

    The interval is that of Fisher's z = artanh r, whose error comes from leaving out parts of the
    data (`jackknife_half_width`): frames that follow each other are not independent.

    Parameters
    ----------
    units : Units
        The sums of 1, x, y, x², y² and xy.
    level : float
        Confidence.

    Returns
    -------
    (float, float, float)
        Value, low and high; no interval (NaN) where there are too few parts, and all NaN where x
        or y does not vary.
    """
    r = float(correlation_of_sums(units.total()[None])[0])
    if r != r or abs(r) >= 1:
        return r, nan, nan
    half = jackknife_half_width(units, lambda sums: np.arctanh(correlation_of_sums(sums)), level)
    z = np.arctanh(r)
    return r, float(np.tanh(z - half)), float(np.tanh(z + half))


def correlation_of_sums(sums: Floats) -> Floats:
    """Return r of each row of sums of 1, x, y, x², y² and xy; NaN where x or y does not vary.

    Parameters
    ----------
    sums : ndarray, shape (m, 6)
        A row an estimate.
    """
    n, x, y, xx, yy, xy = sums.T
    with np.errstate(divide="ignore", invalid="ignore"):
        var_x, var_y = xx / n - (x / n) ** 2, yy / n - (y / n) ** 2
        r = (xy / n - x * y / n**2) / np.sqrt(var_x * var_y)
        varies = (var_x > NO_SPREAD * xx / n) & (var_y > NO_SPREAD * yy / n)
    return np.where(varies, np.clip(r, -1.0, 1.0), nan)
