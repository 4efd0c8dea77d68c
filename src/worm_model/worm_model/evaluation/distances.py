"""Distances between a midline and the true one."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from worm_msgs_py.arrays import Floats

RESAMPLED_POINTS = 200


def resampled(midline_px: Floats, points: int = RESAMPLED_POINTS) -> Floats | None:
    """Return points at equal steps of arc length on the smooth curve through a midline.

    Straight pieces between the points of a table would cut the corners of tight bends by half a
    pixel.

    Parameters
    ----------
    midline_px : ndarray, shape (n, 2)
        (u, v), head first.
    points : int
        How many.

    Returns
    -------
    ndarray, shape (points, 2), or None
        None where there are fewer than two different, finite points.
    """
    if not np.isfinite(midline_px).all():
        return None
    step = np.hypot(*np.diff(midline_px, axis=0).T)
    kept = midline_px[np.r_[True, step > 1e-9]] if len(midline_px) else midline_px
    if len(kept) < 2:
        return None
    chord = np.r_[0.0, np.cumsum(np.hypot(*np.diff(kept, axis=0).T))]
    fine_at = np.linspace(0.0, chord[-1], 4 * points)
    fine = CubicSpline(chord, kept)(fine_at)
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(fine, axis=0).T))]
    at = np.linspace(0.0, s[-1], points)
    return np.stack([np.interp(at, s, fine[:, k]) for k in (0, 1)], axis=1)


def as_given_rms(one: Floats, other: Floats) -> float:
    """Return the rms distance of points at the same part of the length; (n, 2) each."""
    return float(np.sqrt(np.mean(np.sum((one - other) ** 2, axis=1))))


def shape_rms(one: Floats, other: Floats) -> float:
    """Return the rms distance of each curve's points from the other curve, both ways pooled.

    It does not know head from tail.
    """
    away = np.r_[_distance_to_curve(one, other), _distance_to_curve(other, one)]
    return float(np.sqrt(np.mean(away**2)))


def _distance_to_curve(points: Floats, curve: Floats) -> Floats:
    """Return each point's distance from the pieces beside the curve's nearest point."""
    _, nearest = cKDTree(curve).query(points)
    distance = np.full(len(points), np.inf)
    for first in (nearest - 1, nearest):
        start = curve[np.clip(first, 0, len(curve) - 2)]
        piece = curve[np.clip(first, 0, len(curve) - 2) + 1] - start
        length2 = np.maximum(np.sum(piece**2, axis=1), 1e-18)
        part = np.clip(np.sum((points - start) * piece, axis=1) / length2, 0.0, 1.0)
        away = points - start - part[:, np.newaxis] * piece
        distance = np.minimum(distance, np.hypot(*away.T))
    return distance
