"""Histograms with fixed bins, and where they have their peaks."""

import numpy as np

from worm_msgs_py.arrays import Floats


def bin_centres(edges: Floats) -> Floats:
    """Return the middle of each bin."""
    centres: Floats = (edges[1:] + edges[:-1]) / 2
    return centres


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
