"""The two ends of a body: the outermost points of its edge, looked for from within.

From a point within each end the edge is measured along a fan of rays that bend as the body does
there, so that a curved end is looked at as a straight one. Along straight rays the outermost point
of a bent end would lie on its outer flank, by a third of a pixel and more.
"""

from cmath import exp
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask, Picture
from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.edges import (
    PROFILE_STEP_PX,
    EdgeSettings,
    distance_powers,
    find_half_heights,
    sample_lines,
)

_FAN = np.radians(np.arange(-72.0, 72.1, 6.0))
"""Directions in which the outermost point of an end is looked for, about the midline's."""
_FAN_DOUBLINGS = 4
"""How often a distance is squared to give a ray's weight: its sixteenth power."""
_RAYS = np.exp(1j * _FAN)
_ASIDE = np.cos(_FAN) * (0.5j * np.cos(_FAN) - np.sin(_FAN))
"""What bending by a radian a pixel adds to a ray, over the square of the distance."""
_PLACES = np.arange(3.0)


@dataclass(frozen=True, slots=True)
class TipSettings:
    """From where, and how far, the edge of an end is looked for."""

    ray_length_widths: float = 1.8
    """Length of a ray: a pointed end reaches farther beyond the fan's base than a round one."""
    peak_from_tip_widths: float = 0.4
    """How far from its tip an end may be darkest: nearer than a paler, or broader, part of it."""
    edge_over_peak: float = 0.45
    """Part of that peak at a tip: less than half, since a lens draws an end inwards."""
    base_from_end_widths: float = 0.3
    """How far from the end of a midline that stops short of its tip the fan has its base."""
    bend_stretch_widths: float = 0.4
    """Distance of the three points that tell how the body bends near its end."""
    most_bend_rad_per_width: float = 0.5
    """Most that a body is taken to bend near its end: more is an error of the three points."""
    edge: EdgeSettings = field(default_factory=EdgeSettings)


class _EndBases(NamedTuple):
    """Points within both ends: places, outward directions there, bend (radians a pixel)."""

    bases: Complex
    axes: Complex
    bends: Floats


def with_tips(
    signal: Picture, curve: Complex, level: Floats32, width: float, settings: TipSettings
) -> Complex:
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
    level : ndarray, shape (2,)
        The body's signal near either end.
    width : float
        The body's expected width, pixels.
    settings : TipSettings
    """
    ends = _end_bases(curve, width, settings)
    rays = (ends.axes[:, None] * _RAYS).ravel()
    aside = ((ends.axes * ends.bends)[:, None] * _ASIDE).ravel()
    t = distance_powers(0, int(settings.ray_length_widths * width / PROFILE_STEP_PX), 3)
    profiles = sample_lines(signal, [ends.bases.repeat(len(_FAN)), rays, aside], t)
    levels = np.asarray(np.repeat(level, len(_FAN)), np.float32)
    distances, found, *_ = find_half_heights(
        profiles,
        levels,
        settings.peak_from_tip_widths * width,
        settings.edge,
        settings.edge_over_peak,
    )
    first = _outermost(distances[: len(_FAN)], found[: len(_FAN)])
    last = _outermost(distances[len(_FAN) :], found[len(_FAN) :])
    parts = [curve]
    if first is not None:
        parts.insert(0, _tip_at(ends, 0, *first))
    if last is not None:
        parts.append(_tip_at(ends, 1, *last))
    return np.concatenate(parts)


def _end_bases(curve: Complex, width: float, settings: TipSettings) -> _EndBases:
    s = complex_arc_length(curve)
    length = float(s[-1])
    step = min(settings.bend_stretch_widths * width, 0.2 * length)
    from_end = min(settings.base_from_end_widths * width, 0.3 * length) + step * _PLACES
    points = np.interp(np.concatenate([from_end, length - from_end]), s, curve).reshape(2, 3)
    outer, inner = points[:, 0] - points[:, 1], points[:, 1] - points[:, 2]
    turned = outer * inner.conj()
    most = settings.most_bend_rad_per_width * step / width
    turn = np.minimum(np.maximum(np.arctan2(turned.imag, turned.real), -most), most)
    axes = outer / np.maximum(np.abs(outer), 1e-9) * np.exp(0.5j * turn)
    return _EndBases(points[:, 0], axes, turn / step)


def _outermost(distances: Floats, found: Mask) -> tuple[float, float] | None:
    """Return direction and distance of the outermost edge on a fan; None where edges are rare."""
    if np.count_nonzero(found) < len(_FAN) // 2:
        return None
    weight = distances / distances.max()  # zero where nothing was found
    for _ in range(_FAN_DOUBLINGS):
        weight *= weight
    angle = float((weight @ _FAN) / weight.sum())
    return angle, float(np.interp(angle, _FAN[found], distances[found]))


def _tip_at(ends: _EndBases, end: int, angle: float, distance: float) -> Complex:
    """Return the point on a ray of one end's fan, shape (1,)."""
    ray = exp(1j * angle)
    aside = ray.real * complex(-ray.imag, 0.5 * ray.real)
    along = distance * ray + distance**2 * ends.bends[end] * aside
    return np.asarray(ends.bases[end : end + 1] + ends.axes[end] * along)
