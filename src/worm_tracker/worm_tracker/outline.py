"""From an outline to a first midline: the two ends, the two sides, and what lies between them."""

from dataclasses import dataclass
from math import inf, log

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Floats = NDArray[np.float64]

POINTS = 65
"""Points of a midline."""
CANDIDATES = 6
MIN_END_TURN = 1.2
"""Least turn of the outline, in radians, over twice the body's width at an end."""


@dataclass(frozen=True, eq=False, slots=True)
class Rough:
    """A midline to within a pixel or two.

    Attributes
    ----------
    points : ndarray, shape (POINTS, 2)
        (u, v); which end comes first means nothing.
    width : float
        Area over length.
    end_turn : float
        Turn of the outline at the blunter end, radians: near π for a free end.
    unequal : float
        Difference of the sides' lengths, less what the bend of the body explains, over its length.
    """

    points: Floats
    width: float
    end_turn: float
    unequal: float


def arc_length(curve: Floats) -> Floats:
    """Return the arc length along a polyline (n, 2), from zero."""
    d = curve[1:] - curve[:-1]
    s = np.zeros(len(curve))
    np.cumsum(np.sqrt(d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]), out=s[1:])
    return s


def at_arc(curve: Floats, s: Floats, at: Floats) -> Floats:
    """Return the points of a polyline with arc lengths `s` at the arc lengths `at`."""
    out = np.empty((len(at), 2))
    out[:, 0] = np.interp(at, s, curve[:, 0])
    out[:, 1] = np.interp(at, s, curve[:, 1])
    return out


def tangents(curve: Floats) -> Floats:
    """Return the unit tangents of a curve in the order of its points."""
    d = np.empty_like(curve)
    d[1:-1] = curve[2:] - curve[:-2]
    d[0], d[-1] = curve[1] - curve[0], curve[-1] - curve[-2]
    norm = np.sqrt(d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1])
    return np.asarray(d / np.maximum(norm, 1e-9)[:, None])


def resample(curve: Floats, count: int) -> Floats:
    """Return `count` points at equal steps along a polyline."""
    s = arc_length(curve)
    return at_arc(curve, s, np.linspace(0.0, s[-1], count))


def smooth_along(padded: Floats, sigma: float, pad: int) -> Floats:
    """Smooth a curve along itself by a Gaussian; `pad` points at either end are cut off again."""
    size = (1, 2 * pad + 1)
    blurred = cv2.GaussianBlur(np.ascontiguousarray(padded), size, sigma, sigmaY=sigma)
    return np.asarray(blurred[pad:-pad], np.float64)


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
    loop = _smooth_loop(contour, width)
    n = len(loop)
    step = max(2, round(width * n / max(_loop_length(loop), 1.0)))
    if n < 4 * step:
        return None
    turn = _turn(loop, step)
    ends = _peaks(turn, step)
    best = _best_pair(loop, turn, ends, width, last)
    if best is None:
        return None
    i, j = best
    one = loop[i : j + 1]
    other = np.concatenate([loop[j:], loop[: i + 1]])[::-1]
    a, b = resample(one, POINTS), resample(other, POINTS)
    points = (a + b) / 2
    # The outline runs through the centres of edge pixels: half a pixel is missing all round.
    u, v = contour[:, 0].astype(np.float64), contour[:, 1].astype(np.float64)
    area = abs(float(u @ np.roll(v, -1) - v @ np.roll(u, -1))) / 2 + len(contour) / 2
    length = max(float(arc_length(points)[-1]), 1.0)
    difference = abs(float(arc_length(one)[-1] - arc_length(other)[-1]))
    return Rough(
        points=points,
        width=area / length,
        end_turn=float(min(turn[i], turn[j])),
        unequal=abs(difference - area / length * abs(_bend(points))) / length,
    )


def _bend(points: Floats) -> float:
    """Return the angle by which a curve turns from end to end, its very ends left out."""
    d = np.diff(points[4:-4:4], axis=0)
    angle = np.unwrap(np.arctan2(d[:, 1], d[:, 0]))
    return float(angle[-1] - angle[0])


def _smooth_loop(contour: NDArray[np.int32], width: float) -> Floats:
    """Return the outline at equal steps of about a pixel, its pixel stairs smoothed away."""
    closed = np.concatenate([contour, contour[:1]]).astype(np.float64)
    count = max(16, round(arc_length(closed)[-1] / max(1.0, width / 8)))
    loop = resample(closed, count + 1)[:-1]
    sigma = 0.12 * width * count / max(_loop_length(loop), 1.0)
    sigma = max(sigma, 0.8)
    pad = min(int(np.ceil(3 * sigma)) + 1, count)
    return smooth_along(np.concatenate([loop[-pad:], loop, loop[:pad]]), sigma, pad)


def _loop_length(loop: Floats) -> float:
    return float(arc_length(loop)[-1] + np.hypot(*(loop[0] - loop[-1])))


def _turn(loop: Floats, step: int) -> Floats:
    """Return the convex turn of the outline over a stretch of `step` points to either side."""
    u, v = np.concatenate([loop[-step:], loop, loop[:step]]).T
    u, v = u[step:] - u[:-step], v[step:] - v[:-step]
    (back_u, ahead_u), (back_v, ahead_v) = (u[:-step], u[step:]), (v[:-step], v[step:])
    angle = np.arctan2(back_u * ahead_v - back_v * ahead_u, back_u * ahead_u + back_v * ahead_v)
    area = loop[-1, 0] * loop[0, 1] - loop[-1, 1] * loop[0, 0]
    area += loop[:-1, 0] @ loop[1:, 1] - loop[:-1, 1] @ loop[1:, 0]
    # Past a half turn (a thin tail) the angle wraps: a sharp end is convex, never concave.
    signed = angle * np.sign(area)
    return np.asarray(np.where(signed < -2.6, signed + 2 * np.pi, signed))


def _peaks(turn: Floats, step: int) -> NDArray[np.int64]:
    """Return the sharpest convex turns, at least a width apart."""
    top = ndimage.maximum_filter1d(turn, 2 * step + 1, mode="wrap")
    peaks = np.flatnonzero((turn == top) & (turn > 0.6))
    return peaks[np.argsort(-turn[peaks], kind="stable")][:CANDIDATES]


def _best_pair(
    loop: Floats, turn: Floats, ends: NDArray[np.int64], width: float, last: Floats | None
) -> tuple[int, int] | None:
    """Return the pair of candidates that make the most likely worm, in the outline's order."""
    best, most = None, -inf
    n = len(loop)
    sharpness = np.minimum(turn[ends], 2.6).tolist()
    where = ends.tolist()
    off = np.zeros((len(where), 2)) if last is None else _distances(loop[ends], last[[0, -1]])
    for a in range(len(where)):
        for b in range(a + 1, len(where)):
            side = abs(where[a] - where[b])
            score = sharpness[a] + sharpness[b] - 4 * abs(log(side / (n - side)))
            moved = min(off[a, 0] + off[b, 1], off[a, 1] + off[b, 0])
            score -= 0.15 * min(moved / width, 12.0)
            if score > most:
                best, most = (min(where[a], where[b]), max(where[a], where[b])), score
    return best


def _distances(a: Floats, b: Floats) -> Floats:
    """Return the distance of every point of `a` from every point of `b`."""
    d = a[:, None] - b[None]
    return np.asarray(np.sqrt((d * d).sum(-1)))
