"""A midline as a fine curve that is kept from frame to frame, and continued beyond its ends.

Resampling a midline of few points again and again would shrink a tight coil; a fine curve through
which a smooth one is laid does not shrink.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from worm_tracker.midline.contour_midline import (
    POINTS,
    Complex,
    Floats,
    arc,
    as_complex,
    as_points,
    tangents,
)

NODES_A_WIDTH = 5.0
"""Nodes of a trail in a width of the body."""
MOST_NODES = 700
FREE = 0.4
"""How far from a tip the midline counts for its continuation, in widths."""
TELLING = 2.5
"""Length of the stretch before an end that tells its direction and curvature, in widths."""
TIGHTEST = 0.8
"""Least radius of curvature with which an end is continued, in widths."""


@dataclass(frozen=True, eq=False, slots=True)
class Trail:
    """Where a body lies, from tip to tip, and how it slides.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,)
        u + iv at equal steps.
    forward : float
        How far the body slid in the last frame, towards the first end, pixels.
    """

    curve: Complex
    forward: float = 0.0

    @property
    def length(self) -> float:
        """Length from tip to tip, pixels."""
        return float(arc(self.curve)[-1])

    @property
    def step(self) -> float:
        """Distance of the nodes, pixels."""
        return self.length / (len(self.curve) - 1)

    @property
    def points(self) -> Floats:
        """The midline, shape (POINTS, 2)."""
        return as_points(evenly(self.curve, POINTS))

    def shifted(self, by: complex) -> "Trail":
        """Return the trail in other coordinates."""
        return Trail(self.curve + by, self.forward)


def trail_of(last: Floats, before: Floats | None, width: float) -> Trail:
    """Return the trail of a midline.

    Parameters
    ----------
    last, before : ndarray, shape (n, 2)
        The midline and that of the frame before, in the same order.
    width : float
        The body's width, pixels.
    """
    line = as_complex(last)
    forward = 0.0
    if before is not None:
        moved = ((line - as_complex(before)) * -tangents(line).conj()).real
        cut = len(line) // 8
        forward = float(moved[cut:-cut].mean())
    return Trail(evenly(line, nodes_for(float(arc(line)[-1]), width)), forward)


def sharpest_turn(trail: Trail, width: float) -> float:
    """Return the most that a trail turns over a width of the body, radians."""
    d = np.diff(trail.curve)
    angle = np.concatenate([[0.0], np.cumsum(np.angle(d[1:] * d[:-1].conj()))])
    over = max(1, round(width / trail.step))
    return float(np.abs(angle[over:] - angle[:-over]).max()) if len(angle) > over else 0.0


def nodes_for(length: float, width: float) -> int:
    """Return how many nodes a trail of this length has, for a body of this width."""
    return int(min(max(NODES_A_WIDTH * length / width, POINTS), MOST_NODES))


def evenly(curve: Complex, count: int, first: float = 0.0, last: float | None = None) -> Complex:
    """Return points at equal steps along the smooth curve through some points.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
    count : int
    first, last : float
        Arc lengths from which and to which; all of it by default.
    """
    s = arc(curve)
    at = np.linspace(first, float(s[-1]) if last is None else last, count)
    return np.asarray(CubicSpline(s, curve)(at), np.complex128)


def continued(trail: Trail, beyond: int, width: float) -> Complex:
    """Return a trail's curve with some nodes more at both ends, on arcs of its curvature there.

    Parameters
    ----------
    trail : Trail
    beyond : int
        Nodes at either end.
    width : float
        The body's width, pixels.
    """
    curve, step = trail.curve, trail.step
    free = max(1, round(FREE * width / step))
    telling = min(max(4, round(TELLING * width / step)), len(curve) - 2 * free)
    first = _onwards(curve[free : free + telling][::-1], step, free + beyond, width)
    last = _onwards(curve[-free - telling : -free], step, free + beyond, width)
    return np.concatenate([first[::-1], curve[free:-free], last])


def _onwards(stretch: Complex, step: float, count: int, width: float) -> Complex:
    """Return the points that follow on a stretch, on an arc of its curvature."""
    pieces = np.diff(stretch)
    heading = np.unwrap(np.angle(pieces))
    at = step * (np.arange(len(pieces)) + 0.5 - len(pieces))  # 0 at the stretch's end
    off = at - at.mean()
    curvature = float(off @ heading) / float(off @ off)
    tight = 1 / (TIGHTEST * width)
    curvature = min(max(curvature, -tight), tight)
    angle = heading.mean() + curvature * (step * (np.arange(count) + 0.5) - at.mean())
    return np.asarray(stretch[-1] + np.cumsum(step * np.exp(1j * angle)), np.complex128)
