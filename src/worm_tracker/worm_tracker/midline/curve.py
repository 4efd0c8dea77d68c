"""Curves in the picture, as points (u, v) or as numbers u + iv: arc length, tangents, smoothing."""

from functools import cache

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for

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
    """Return points of the cubic spline through some points: SciPy's, at a twentieth of its time.

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
        Two points are one, or there are fewer than four.
    """
    if len(s) < 4:  # compiled code has no bounds
        raise ValueError("a cubic goes through four points at least")
    points = np.empty(len(at), np.complex128)
    if not _fill_cubic(s, curve, at, points):
        raise ValueError("two points of a curve are one")
    return points


@compiled
def _spline_tangents(s: Floats, curve: Complex) -> Complex:
    """Return the slopes of the cubic spline at its points.

    Second derivatives agree there, at the last but one third ones, too.
    """
    n = len(s)
    diagonal, above, right = np.empty(n), np.empty(n), np.empty(n, np.complex128)
    step, after = s[1] - s[0], s[2] - s[1]
    slope, slope_after = (curve[1] - curve[0]) / step, (curve[2] - curve[1]) / after
    both = step + after
    diagonal[0], above[0] = after, both
    right[0] = ((step + 2 * both) * after * slope + step * step * slope_after) / both
    for k in range(1, n - 1):
        step, after = s[k] - s[k - 1], s[k + 1] - s[k]
        slope, slope_after = (curve[k] - curve[k - 1]) / step, (curve[k + 1] - curve[k]) / after
        share = after / diagonal[k - 1]
        diagonal[k] = 2 * (step + after) - share * above[k - 1]
        above[k] = step
        right[k] = 3 * (after * slope + step * slope_after) - share * right[k - 1]
    step, after = s[n - 2] - s[n - 3], s[n - 1] - s[n - 2]
    slope, slope_after = (
        (curve[n - 2] - curve[n - 3]) / step,
        (curve[n - 1] - curve[n - 2]) / after,
    )
    both = step + after
    share = both / diagonal[n - 2]
    last = (after * after * slope + (2 * both + after) * step * slope_after) / both
    right[n - 1] = (last - share * right[n - 2]) / (step - share * above[n - 2])
    for k in range(n - 2, -1, -1):
        right[k] = (right[k] - above[k] * right[k + 1]) / diagonal[k]
    return right


@compiled_for(
    array_read(types.float64),
    array_read(types.complex128),
    array_read(types.float64),
    array_written(types.complex128),
)
def _fill_cubic(s: Floats, curve: Complex, at: Floats, points: Complex) -> bool:
    """Fill in points of the cubic spline through others; return False where two of them are one."""
    for k in range(len(s) - 1):
        if not s[k + 1] > s[k]:
            return False
    tangent = _spline_tangents(s, curve)
    k = 0
    for j in range(len(at)):
        while k > 0 and at[j] < s[k]:
            k -= 1
        while k < len(s) - 2 and at[j] >= s[k + 1]:
            k += 1
        step, way = s[k + 1] - s[k], at[j] - s[k]
        slope = (curve[k + 1] - curve[k]) / step
        bend = (tangent[k] + tangent[k + 1] - 2 * slope) / step
        bow = (slope - tangent[k]) / step - bend
        points[j] = curve[k] + way * (tangent[k] + way * (bow + way * (bend / step)))
    return True


def turn_about(curve: Complex, over: int) -> Floats:
    """Return by how much a curve turns from so many points before each one to as many after it.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
    over : int

    Returns
    -------
    ndarray, shape (n,)
        Radians, anticlockwise in u + iv; only what lies on the curve counts.
    """
    turned = np.empty(len(curve))
    _fill_turn(curve, over, turned)
    return turned


@compiled_for(array_read(types.complex128), types.intp, array_written(types.float64))
def _fill_turn(curve: Complex, over: int, turned: Floats) -> None:
    n = len(curve)
    upto = np.zeros(n + 1)  # sum of the turns at the nodes before each one
    for k in range(n):
        turn = 0.0
        if 0 < k < n - 1:
            turn = np.angle((curve[k + 1] - curve[k]) * (curve[k] - curve[k - 1]).conjugate())
        upto[k + 1] = upto[k] + turn
    for k in range(n):
        turned[k] = upto[min(k + over + 1, n)] - upto[max(k - over, 0)]


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
