"""The two ends of a body: the outermost points of its edge, looked for from within.

From a point within each end the edge is measured along a fan of rays that bend as the body does
there, so that a curved end is looked at as a straight one. Along straight rays the outermost point
of a bent end would lie on its outer flank, by a third of a pixel and more.
"""

from cmath import exp
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from worm_tracker.midline.contour_midline import Complex, Floats, arc
from worm_tracker.midline.edges import STEP_PX, edges, sample, steps

FAN = np.radians(np.arange(-72.0, 72.1, 6.0))
"""Directions in which the outermost point of an end is looked for, about the midline's."""
FAN_DOUBLINGS = 5
"""How often a distance is squared to give a ray's weight: its 32nd power."""
REACH = 1.8
"""Length of a ray, in widths."""
BASE, BEND = 0.3, 0.4
"""How far from its ends a midline is left for the fan, and how far apart three points are that
tell how it bends there, in widths."""
MOST_BEND = 0.5
"""Most that a body is taken to bend within a width, radians."""

_RAYS = np.exp(1j * FAN)
_ASIDE = np.cos(FAN) * (0.5j * np.cos(FAN) - np.sin(FAN))
"""What bending by a radian a pixel adds to a ray, over the square of the distance."""
_PLACES = np.arange(3.0)


class _Within(NamedTuple):
    """Points within both ends: places, outward directions there, bend (radians a pixel)."""

    bases: Complex
    axes: Complex
    bends: Floats


def with_tips(signal: NDArray[np.uint8], curve: Complex, level: float, width: float) -> Complex:
    """Let a centred midline, which ends short of its tips, end at the outermost points.

    The direction of each tip is the mean of the rays', weighed by a high power of the distance to
    the edge: sharp for a pointed end, along the axis for a round one. An end without an edge about
    it stays as it is.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    curve : ndarray of complex, shape (n,)
        The midline, u + iv.
    level : float
        The body's signal.
    width : float
        The body's expected width, pixels.
    """
    within = _within_ends(curve, width)
    rays = (within.axes[:, None] * _RAYS).ravel()
    aside = ((within.axes * within.bends)[:, None] * _ASIDE).ravel()
    t = steps(0, int(REACH * width / STEP_PX), 3)
    profiles = sample(signal, [within.bases.repeat(len(FAN)), rays, aside], t)
    distances, found = edges(profiles, np.full(len(rays), level, np.float32), width)
    first = _farthest(distances[: len(FAN)], found[: len(FAN)])
    last = _farthest(distances[len(FAN) :], found[len(FAN) :])
    parts = [curve]
    if first is not None:
        parts.insert(0, _place(within, 0, *first))
    if last is not None:
        parts.append(_place(within, 1, *last))
    return np.concatenate(parts)


def _within_ends(curve: Complex, width: float) -> _Within:
    s = arc(curve)
    length = float(s[-1])
    step = min(BEND * width, 0.2 * length)
    from_end = min(BASE * width, 0.3 * length) + step * _PLACES
    points = np.interp(np.concatenate([from_end, length - from_end]), s, curve).reshape(2, 3)
    outer, inner = points[:, 0] - points[:, 1], points[:, 1] - points[:, 2]
    turned = outer * inner.conj()
    most = MOST_BEND * step / width
    turn = np.minimum(np.maximum(np.arctan2(turned.imag, turned.real), -most), most)
    axes = outer / np.maximum(np.abs(outer), 1e-9) * np.exp(0.5j * turn)
    return _Within(points[:, 0], axes, turn / step)


def _farthest(distances: Floats, found: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Return direction and distance of the outermost edge on a fan; None where edges are rare."""
    if np.count_nonzero(found) < len(FAN) // 2:
        return None
    weight = distances / distances.max()  # zero where nothing was found
    for _ in range(FAN_DOUBLINGS):
        weight *= weight
    angle = float((weight @ FAN) / weight.sum())
    return angle, float(np.interp(angle, FAN[found], distances[found]))


def _place(within: _Within, end: int, angle: float, distance: float) -> Complex:
    """Return the point on a ray of one end's fan, shape (1,)."""
    ray = exp(1j * angle)
    aside = ray.real * complex(-ray.imag, 0.5 * ray.real)
    along = distance * ray + distance**2 * within.bends[end] * aside
    return np.asarray(within.bases[end : end + 1] + within.axes[end] * along)
