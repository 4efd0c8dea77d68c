"""Curves in the picture, as points (u, v) or as numbers u + iv: arc length, tangents, smoothing."""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgtsv

from worm_msgs_py.arrays import Complex, Floats

TRACKED_POINTS = 65
"""Points of a midline, at equal steps from tip to tip."""


def as_complex(curve: Floats) -> Complex:
    """Return points (u, v) as numbers u + iv: half as many steps for the same arithmetic."""
    return np.ascontiguousarray(curve).view(np.complex128)[:, 0]


def as_points(curve: Complex) -> Floats:
    """Return numbers u + iv as points (u, v), shape (n, 2)."""
    return curve[:, None].view(np.float64)


@cache
def unit_grid(count: int) -> Floats:
    """Return `count` equal steps from 0 to 1."""
    grid = np.linspace(0.0, 1.0, count)
    grid.flags.writeable = False
    return grid


def arc_length(curve: Floats) -> Floats:
    """Return the arc length along a polyline (n, 2), from zero."""
    return complex_arc_length(as_complex(curve))


def complex_arc_length(curve: Complex) -> Floats:
    """Return the arc length along a polyline of complex numbers, from zero."""
    s = np.zeros(len(curve))
    np.abs(curve[1:] - curve[:-1]).cumsum(out=s[1:])
    return s


def length_of(points: Floats) -> float:
    """Return the length of a midline (n, 2)."""
    line = as_complex(points)
    return float(abs(line[1:] - line[:-1]).sum())


def tangents(curve: Complex) -> Complex:
    """Return the unit tangents of a curve in the order of its points."""
    d = np.empty_like(curve)
    np.subtract(curve[2:], curve[:-2], out=d[1:-1])
    d[0], d[-1] = curve[1] - curve[0], curve[-1] - curve[-2]
    d /= np.maximum(np.abs(d), 1e-9)
    return d


def resample(curve: Floats, count: int) -> Floats:
    """Return `count` points at equal steps along a polyline."""
    z = as_complex(curve)
    s = complex_arc_length(z)
    return as_points(np.interp(s[-1] * unit_grid(count), s, z))


def cubic_through(s: Floats, curve: Complex, at: Floats) -> Complex:
    """Return points of the cubic spline through some points: SciPy's, at a fifth of its time.

    What `CubicSpline` costs is the care that it takes of all that it may be given.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Arc lengths of the points, n > 3.
    curve : ndarray of complex, shape (n,)
    at : ndarray, shape (m,)
        Arc lengths of the points wanted; beyond the ends the last piece goes on.

    Raises
    ------
    ValueError
        Two points are one.
    """
    step, rise = s[1:] - s[:-1], curve[1:] - curve[:-1]
    if not (step > 0).all():
        raise ValueError("two points of a curve are one")
    slope = rise / step
    # Slopes at the points: second derivatives agree there, at the last but one third ones, too.
    diagonal, above, below = np.empty(len(s)), np.empty(len(s) - 1), np.empty(len(s) - 1)
    right = np.empty(len(s), np.complex128)
    diagonal[1:-1] = 2 * (step[:-1] + step[1:])
    above[1:], below[:-1] = step[:-1], step[1:]
    right[1:-1] = 3 * (step[1:] * slope[:-1] + step[:-1] * slope[1:])
    diagonal[0], diagonal[-1] = step[1], step[-2]
    above[0], below[-1] = first, last = s[2] - s[0], s[-1] - s[-3]
    right[0] = (step[0] + 2 * first) * step[1] * slope[0] + step[0] ** 2 * slope[1]
    right[0] /= first
    right[-1] = step[-1] ** 2 * slope[-2] + (2 * last + step[-1]) * step[-2] * slope[-1]
    right[-1] /= last
    both = np.asfortranarray(right.view(np.float64).reshape(-1, 2))
    *_, solved, info = dgtsv(below, diagonal, above, both, True, True, True, True)
    if info:
        raise ValueError("two points of a curve are one")
    tangent = np.ascontiguousarray(solved).view(np.complex128)[:, 0]
    bend = (tangent[:-1] + tangent[1:] - 2 * slope) / step
    k = (s.searchsorted(at, "right") - 1).clip(0, len(step) - 1)
    way = at - s[k]
    points = curve[k] + tangent[k] * way
    way2 = way * way
    points += ((slope - tangent[:-1]) / step - bend)[k] * way2
    points += (bend / step)[k] * (way2 * way)
    return np.asarray(points, np.complex128)


def smooth_padded(padded: Complex, sigma: float, pad: int) -> Complex:
    """Smooth a curve along itself by a Gaussian; `pad` points at either end are cut off again."""
    # As one row of pairs: as a column it would take many times as long.
    row = padded.view(np.float64).reshape(1, -1, 2)
    blurred = cv2.GaussianBlur(row, (2 * pad + 1, 1), sigma)
    return blurred.reshape(-1).view(np.complex128)[pad:-pad]


def smooth_open_curve(curve: Complex, sigma: float) -> Complex:
    """Smooth a curve along itself without pulling its ends in."""
    padded, pad = reflected_ends(curve, sigma)
    return smooth_padded(padded, sigma, pad)


def reflected_ends(curve: Complex, sigma: float) -> tuple[Complex, int]:
    """Return a curve continued at both ends for a Gaussian, and by how many points."""
    # An odd reflection about the end keeps end points and end slopes.
    pad = min(int(3 * sigma) + 2, len(curve) - 1)
    low = 2 * curve[0] - curve[pad:0:-1]
    high = 2 * curve[-1] - curve[-2 : -pad - 2 : -1]
    return np.concatenate([low, curve, high]), pad


def median_of(values: Floats) -> float:
    """Return the median; NumPy's own takes five times as long for so few values."""
    ordered, middle = np.sort(values), len(values) // 2
    return float((ordered[middle] + ordered[~middle]) / 2)


def transformed_points(points: Floats | NDArray[np.int32], motion: Floats) -> Floats:
    """Return points (n, 2) where an affine map (2, 3) of the picture takes them."""
    return np.asarray(points @ motion[:, :2].T + motion[:, 2])
