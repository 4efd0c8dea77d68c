"""A midline as a fine curve that is kept from frame to frame, and continued beyond its ends.

Resampling a midline of few points again and again would shrink a tight coil; a fine curve through
which a smooth one is laid does not shrink.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.curve import (
    TRACKED_POINTS,
    as_complex,
    as_points,
    complex_arc_length,
    cubic_through,
    tangents,
    transformed_points,
    unit_grid,
)

_NODES_PER_WIDTH = 5.0
"""Nodes of a path in a width of the body."""
_MOST_NODES = 700


@dataclass(frozen=True, slots=True)
class ContinuationSettings:
    """How a path is continued beyond the ends of a body."""

    tip_left_out_widths: float = 0.4
    """How far from a tip the midline does not count: there it is least sure."""
    fitted_stretch_widths: float = 2.5
    """Length of the stretch before it that gives direction and curvature."""
    least_radius_widths: float = 0.8
    """Least radius of curvature of the continuation: a body does not bend more tightly."""


@dataclass(frozen=True, eq=False)
class BodyPath:
    """Where a body lies, from tip to tip, and how it slides.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,)
        u + iv at equal steps.
    ways : tuple of float
        How far each end went in the last frame, along the body towards the first end, pixels.
    """

    curve: Complex
    ways: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def length(self) -> float:
        """Length from tip to tip, pixels."""
        return float(complex_arc_length(self.curve)[-1])

    @property
    def step(self) -> float:
        """Distance of the nodes, pixels."""
        return self.length / (len(self.curve) - 1)

    @cached_property
    def points(self) -> Floats:
        """The midline, shape (TRACKED_POINTS, 2)."""
        return as_points(evenly(self.curve, TRACKED_POINTS))

    def shifted(self, by: complex) -> "BodyPath":
        """Return the path in coordinates whose origin is elsewhere."""
        return BodyPath(self.curve + by, self.ways)

    def turned_round(self) -> "BodyPath":
        """Return the path from its last end to its first."""
        return BodyPath(self.curve[::-1], (-self.ways[1], -self.ways[0]))

    def transformed(self, motion: Floats) -> "BodyPath":
        """Return the path where an affine map (2, 3) of the picture takes it."""
        curve = as_complex(transformed_points(as_points(self.curve), motion))
        return BodyPath(curve, self.ways)


def path_of(last: Floats, before: Floats | None, width: float) -> BodyPath:
    """Return the path of a midline.

    Parameters
    ----------
    last, before : ndarray, shape (n, 2)
        The midline and that of the frame before, in the same order.
    width : float
        The body's width, pixels.
    """
    line = as_complex(last)
    ways = 0.0, 0.0
    if before is not None:
        moved = ((line - as_complex(before)) * -tangents(line).conj()).real
        end = len(line) // 8
        ways = float(moved[:end].mean()), float(moved[-end:].mean())
    nodes = nodes_for(float(complex_arc_length(line)[-1]), width)
    return BodyPath(evenly(line, nodes), ways)


def sharpest_turn(path: BodyPath, width: float) -> float:
    """Return the most that a path turns over a width of the body, radians."""
    d = np.diff(path.curve)
    angle = np.concatenate([[0.0], np.cumsum(np.angle(d[1:] * d[:-1].conj()))])
    over = max(1, round(width / path.step))
    return float(np.abs(angle[over:] - angle[:-over]).max()) if len(angle) > over else 0.0


def sharp_turns(points: Floats, width: float, least_rad: float) -> Floats:
    """Return those of a line's points (n, 2) about which it turns by so much within a width."""
    line = as_complex(points)
    d = np.diff(line)
    angle = np.concatenate([[0.0], np.cumsum(np.angle(d[1:] * d[:-1].conj()))])
    half = max(0.5, 0.5 * width * len(d) / max(float(np.abs(d).sum()), 1e-9))
    at = np.arange(len(line)) - 0.5  # of each point among the segments
    segments = np.arange(len(d))
    turn = np.interp(at + half, segments, angle) - np.interp(at - half, segments, angle)
    return np.asarray(points[np.abs(turn) > least_rad])


def nodes_for(length: float, width: float) -> int:
    """Return how many nodes a path of this length has, for a body of this width."""
    return int(min(max(_NODES_PER_WIDTH * length / width, TRACKED_POINTS), _MOST_NODES))


def evenly(curve: Complex, count: int, first: float = 0.0, last: float | None = None) -> Complex:
    """Return points at equal steps along the smooth curve through some points.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
    count : int
    first, last : float
        Arc lengths from which and to which; all of it by default.
    """
    s = complex_arc_length(curve)
    last = float(s[-1]) if last is None else last
    return cubic_through(s, curve, first + (last - first) * unit_grid(count))


def continued(path: BodyPath, beyond: int, width: float, settings: ContinuationSettings) -> Complex:
    """Return a path's curve with some nodes more at both ends, on arcs of its curvature there.

    Parameters
    ----------
    path : BodyPath
    beyond : int
        Nodes at either end.
    width : float
        The body's width, pixels.
    settings : ContinuationSettings
    """
    curve, step = path.curve, path.step
    cut = max(1, round(settings.tip_left_out_widths * width / step))
    fitted = round(settings.fitted_stretch_widths * width / step)
    cut = min(cut, (len(curve) - 4) // 2)
    fitted = min(max(4, fitted), len(curve) - 2 * cut)
    most_curved = 1 / (settings.least_radius_widths * width)
    first = _onwards(curve[cut : cut + fitted][::-1], step, cut + beyond, most_curved)
    last = _onwards(curve[-cut - fitted : -cut], step, cut + beyond, most_curved)
    return np.concatenate([first[::-1], curve[cut:-cut], last])


def _onwards(stretch: Complex, step: float, count: int, most_curved: float) -> Complex:
    """Return the points that follow on a stretch, on an arc of its curvature (1 / pixels)."""
    onwards = np.empty(count, np.complex128)
    _fill_arc(stretch, step, most_curved, onwards)
    return onwards


@compiled_for(
    array_read(types.complex128), types.float64, types.float64, array_written(types.complex128)
)
def _fill_arc(stretch: Complex, step: float, most_curved: float, onwards: Complex) -> None:
    n = len(stretch) - 1
    heading = np.empty(n)
    for k in range(n):
        heading[k] = np.angle(stretch[k + 1] - stretch[k])
        while k > 0 and heading[k] - heading[k - 1] > np.pi:
            heading[k] -= 2 * np.pi
        while k > 0 and heading[k] - heading[k - 1] < -np.pi:
            heading[k] += 2 * np.pi
    # A line through the headings, by least squares; its middle lies half the stretch back.
    curvature, squares, mean = 0.0, 0.0, heading.mean()
    for k in range(n):
        off = step * (k - (n - 1) / 2)
        curvature += off * (heading[k] - mean)
        squares += off * off
    curvature = min(max(curvature / squares, -most_curved), most_curved)
    point = stretch[n]
    for k in range(len(onwards)):
        angle = mean + curvature * step * (k + 0.5 + n / 2)
        point += step * complex(np.cos(angle), np.sin(angle))
        onwards[k] = point
