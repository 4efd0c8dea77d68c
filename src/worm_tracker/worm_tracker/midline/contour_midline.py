"""From an outline to a first midline: the two ends, the two sides, and what lies between them."""

from dataclasses import dataclass
from functools import cache
from math import inf, log

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

POINTS = 65
"""Points of a midline."""
CANDIDATES = 6
PER_WIDTH = 7
"""Steps of the outline in a width."""
_SIDE = np.linspace(0.0, 1.0, POINTS)


@dataclass(frozen=True, eq=False, slots=True)
class Rough:
    """A midline to within a pixel or two.

    Attributes
    ----------
    points : ndarray, shape (POINTS, 2)
        (u, v); which end comes first means nothing.
    width : float
        Area over length.
    unequal : float
        Difference of the sides' lengths, less what the bend of the body explains, over its length.
    """

    points: Floats
    width: float
    unequal: float


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
    return arc(as_complex(curve))


def arc(curve: Complex) -> Floats:
    """Return the arc length along a polyline of complex numbers, from zero."""
    s = np.zeros(len(curve))
    np.abs(curve[1:] - curve[:-1]).cumsum(out=s[1:])
    return s


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
    s = arc(z)
    return as_points(np.interp(s[-1] * unit_grid(count), s, z))


def smooth_along(padded: Complex, sigma: float, pad: int) -> Complex:
    """Smooth a curve along itself by a Gaussian; `pad` points at either end are cut off again."""
    # As one row of pairs: as a column it would take many times as long.
    row = padded.view(np.float64).reshape(1, -1, 2)
    blurred = cv2.GaussianBlur(row, (2 * pad + 1, 1), sigma)
    return blurred.reshape(-1).view(np.complex128)[pad:-pad]


def rough_midline(contour: NDArray[np.int32], width: float, last: Floats | None) -> Rough | None:
    """Find the midline of a body that does not touch itself.

    Parameters
    ----------
    contour : ndarray, shape (n, 2)
        The outline's pixels in order.
    width : float
        The body's expected width, pixels.
    last : ndarray, shape (POINTS, 2), or None
        The last midline: of several candidates for the ends those near its ends are preferred.

    Returns
    -------
    Rough or None
        None where the outline has no two ends.

    Notes
    -----
    Over a stretch of two widths an end turns the outline by about π, a bend of the body by far
    less. The pair of turns is taken that makes both sides equally long, near the last ends.
    """
    loop, spacing = _smooth_loop(contour, width)
    n = len(loop)
    step = max(2, round(width / spacing))
    if n < 4 * step:
        return None
    oriented = cv2.contourArea(contour, oriented=True)
    turn, ends = _ends(loop, step, 1.0 if oriented > 0 else -1.0)
    best = _best_pair(loop, turn, ends, width, last)
    if best is None:
        return None
    i, j = best
    # The loop's points are at equal steps: half of these go one way round, half the other.
    at = np.concatenate([i + (j - i) * _SIDE, i + n - (i + n - j) * _SIDE])
    k = at.astype(np.int64)
    part = at - k
    sides = (1 - part) * loop.take(k, mode="wrap") + part * loop.take(k + 1, mode="wrap")
    points = (sides[:POINTS] + sides[POINTS:]) / 2
    # The outline runs through the centres of edge pixels: half a pixel is missing all round.
    area = abs(oriented) + len(contour) / 2
    length = max(float(np.abs(points[1:] - points[:-1]).sum()), 1.0)
    difference = abs(n - 2 * (j - i)) * spacing
    return Rough(
        points=as_points(points),
        width=area / length,
        unequal=abs(difference - area / length * abs(_bend(points))) / length,
    )


def _bend(points: Complex) -> float:
    """Return the angle by which a curve turns from end to end, its very ends left out."""
    thin = points[4:-4:4]
    d = thin[1:] - thin[:-1]
    return float(np.angle(d[1:] * d[:-1].conj()).sum())


def _smooth_loop(contour: NDArray[np.int32], width: float) -> tuple[Complex, float]:
    """Return the outline at equal steps, its pixel stairs smoothed away, and the step."""
    fine = max(1.0, width / PER_WIDTH)
    closed = as_complex(np.concatenate([contour[:: int(fine)], contour[:1]]).astype(np.float64))
    s = arc(closed)
    length = float(s[-1])
    count = max(16, round(length / fine))
    spacing = length / count
    sigma = max(0.12 * width / spacing, 0.8)
    pad = min(int(3 * sigma) + 2, count)
    at = spacing * np.arange(-pad, count + pad)
    at[:pad] += length
    at[count + pad :] -= length
    return smooth_along(np.interp(at, s, closed), sigma, pad), spacing


def _ends(loop: Complex, step: int, sign: float) -> tuple[Floats, NDArray[np.int64]]:
    """Return the outline's convex turn at each point, and its sharpest turns a width apart.

    The turn is that over a stretch of `step` points to either side.
    """
    n = len(loop)
    pad = 2 * step
    around = np.concatenate([loop[n - pad :], loop, loop[:pad]])
    chord = around[step:] - around[:-step]
    turned = chord[step:] * chord[:-step].conj()
    signed = np.arctan2(sign * turned.imag, turned.real).astype(np.float32)
    # Past a half turn (a thin tail) the angle wraps: a sharp end is convex, never concave.
    signed[signed < -2.6] += 2 * np.pi
    top = cv2.dilate(signed[None], np.ones((1, 2 * step + 1), np.uint8))[0]
    turn = signed[step : step + n]
    peaks = np.flatnonzero((turn == top[step : step + n]) & (turn > 0.6))
    return turn, peaks[np.argsort(-turn[peaks], kind="stable")][:CANDIDATES]


def _best_pair(
    loop: Complex, turn: Floats, ends: NDArray[np.int64], width: float, last: Floats | None
) -> tuple[int, int] | None:
    """Return the pair of candidates that make the most likely worm, in the outline's order."""
    best, most = None, -inf
    n = len(loop)
    where = ends.tolist()
    if len(where) == 2:  # nearly always: there is nothing to choose from
        return min(where), max(where)
    sharpness = np.minimum(turn[ends], 2.6).tolist()
    away = [[0.0, 0.0]] * len(where)
    if last is not None:
        tips = as_complex(last[[0, -1]])
        away = np.abs(loop[ends][:, None] - tips).tolist()
    for a in range(len(where)):
        for b in range(a + 1, len(where)):
            side = abs(where[a] - where[b])
            score = sharpness[a] + sharpness[b] - 4 * abs(log(side / (n - side)))
            moved = min(away[a][0] + away[b][1], away[a][1] + away[b][0])
            score -= 0.15 * min(moved / width, 12.0)
            if score > most:
                best, most = (min(where[a], where[b]), max(where[a], where[b])), score
    return best
