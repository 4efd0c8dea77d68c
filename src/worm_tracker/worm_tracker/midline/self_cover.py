"""Where a body lies on or beside itself: which points of its path other parts of it cover.

Only there do an edge or an end of the body stay unseen, or look darker; everywhere else the picture
tells them.
"""

from dataclasses import dataclass
from math import exp, hypot

import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Floats32
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.curve import median_of


@dataclass(frozen=True, slots=True)
class SelfCoverSettings:
    """Which parts of a body are others, and where they lie over a point."""

    least_way_between_parts_widths: float = 1.5
    """Distance along the body from which on two points are of different parts: the two sides of the
    tightest bend are hardly farther apart."""
    least_way_between_layers_widths: float = 5.0
    """The same for two that lie on each other: the sides of a hairpin lie beside each other."""
    nodes_per_disc: int = 2
    """Nodes of a path for each disc that stands for a piece of the body."""


def parts_over(
    at: Complex,
    path: Complex,
    half: Floats,
    body: slice,
    step: float,
    margin_px: float | Floats,
    settings: SelfCoverSettings,
) -> NDArray[np.uint8]:
    """Return how many other parts of the body lie over points beside a path.

    Parameters
    ----------
    at : ndarray of complex, shape (n, m)
        Points that belong to the path's nodes, u + iv.
    path : ndarray of complex, shape (n,)
        The path at equal steps.
    half : ndarray, shape (n,)
        Half the body's width there, pixels.
    body : slice
        Nodes at which the body is thought to be.
    step : float
        Distance of the nodes, pixels.
    margin_px : float, or ndarray, shape (m,)
        How far beyond its edge (negative: within it) a part still counts as covering.
    settings : SelfCoverSettings

    Returns
    -------
    ndarray of uint8, shape (n, m)
    """
    first, last, _ = body.indices(len(path))
    parts = np.arange(first, last, settings.nodes_per_disc)
    width = 2 * median_of(half[first:last]) if last > first else 0.0
    apart = settings.least_way_between_parts_widths * width / max(step, 1e-9)
    layers_apart = settings.least_way_between_layers_widths * width / max(step, 1e-9)
    margins = np.broadcast_to(margin_px, at.shape[1:])
    radius2 = np.maximum(half[parts, None] + margins, 0.0).astype(np.float32) ** 2
    over = np.zeros(at.shape, np.uint8)
    if radius2.size:
        _cover(at, path, parts, radius2, apart, layers_apart, float(np.sqrt(radius2.max())), over)
    return over


@compiled
def _farthest(points: Complex, place: complex) -> float:
    """Return how far the farthest of some points is from a place."""
    most2 = 0.0
    for point in points:
        du, dv = point.real - place.real, point.imag - place.imag
        most2 = max(most2, du * du + dv * dv)
    return float(np.sqrt(most2))


@compiled_for(
    array_read(types.complex128, 2),
    array_read(types.complex128),
    array_read(types.intp),
    array_read(types.float32, 2),
    types.float64,
    types.float64,
    types.float64,
    array_written(types.uint8, 2),
)
def _cover(
    at: Complex,
    path: Complex,
    parts: NDArray[np.intp],
    radius2: Floats32,
    apart: float,
    layers_apart: float,
    most_radius: float,
    over: NDArray[np.uint8],
) -> None:
    """Count for each point the parts of which it lies in a disc about one of their nodes.

    Most nodes and discs are far apart: only what is left is looked at closely. No two discs that
    follow on each other are farther apart than the longest way between two of them: where one is
    far beyond reach, so are some of the next.
    """
    longest = 1e-9
    for disc in range(1, len(parts)):
        longest = max(longest, abs(path[parts[disc]] - path[parts[disc - 1]]))
    last = np.empty(at.shape[1])
    for node in range(len(path)):
        last[:] = -np.inf
        far, disc = _farthest(at[node], path[node]) + most_radius + 1.0, 0
        while disc < len(parts):
            middle = path[parts[disc]]
            du, dv = path[node].real - middle.real, path[node].imag - middle.imag
            away2 = du * du + dv * dv
            if away2 >= far * far:
                disc += 1 + int((np.sqrt(away2) - far) / longest)
                continue
            if abs(node - parts[disc]) > apart:
                for k in range(at.shape[1]):
                    du, dv = at[node, k].real - middle.real, at[node, k].imag - middle.imag
                    if du * du + dv * dv < radius2[disc, k]:
                        over[node, k] += parts[disc] - last[k] > layers_apart
                        last[k] = parts[disc]
            disc += 1


def lies_near_itself(path: Complex, width: float, step: float, far_widths: float = 2.2) -> bool:
    """Tell whether two parts of a path are so near that one can hide an edge of the other."""
    coarse = path[:: max(1, round(0.5 * width / step))]
    return bool(_comes_near(coarse, far_widths * width))


@compiled_for(array_read(types.complex128), types.float64)
def _comes_near(path: Complex, far: float) -> bool:
    """Tell whether two points of a path with six or more between them are nearer than that."""
    for k in range(len(path)):
        for other in range(k + 7, len(path)):
            du, dv = path[other].real - path[k].real, path[other].imag - path[k].imag
            if du * du + dv * dv < far * far:
                return True
    return False


def ends_on_body(
    path: Complex, near_px: float, step: float, apart_over_near: float = 2.0
) -> tuple[bool, bool]:
    """Tell of each end of a path whether it is nearer than this to another part of it.

    Parameters
    ----------
    path : ndarray of complex, shape (n,)
        At equal steps, u + iv.
    near_px : float
    step : float
        Distance of the path's points, pixels.
    apart_over_near : float
        How far along the path, over `near_px`, another part begins.
    """
    apart = 1 + round(apart_over_near * near_px / step)
    first = abs(path[apart:] - path[0]) < near_px
    last = abs(path[: max(len(path) - apart, 0)] - path[-1]) < near_px
    return bool(first.any()), bool(last.any())


def strands_at_ends(path: Complex, near_px: float, width: float, step: float) -> tuple[int, int]:
    """Return how many other strands of a body pass each of its ends.

    Parameters
    ----------
    path : ndarray of complex, shape (n,)
        At equal steps, u + iv.
    near_px : float
        How near their middles pass it.
    width : float
        The body's, pixels: another strand is two of them along the body from the end, or more, and
        one from the next.
    step : float
        Distance of the path's points, pixels.
    """
    first, last = (_strands_at_start(curve, near_px, width, step) for curve in (path, path[::-1]))
    return first, last


def _strands_at_start(path: Complex, near_px: float, width: float, step: float) -> int:
    near = np.flatnonzero(abs(path - path[0]) < near_px)
    near = near[near * step > 2 * width]
    return int(near.size > 0) + int((np.diff(near) * step > width).sum())


def ends_kept(points: Floats, end_sd_px: tuple[float, float]) -> float:
    """Return the probability, 0.5 to 1, that no end of a body was taken for its other one.

    Where they lie so near each other that either may be where the other is said to be, the one
    that is seen next may be either: a body that is slid along itself goes on with it.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        The midline.
    end_sd_px : tuple of float
        How surely its first and its last end are where they are said to be.
    """
    sd = hypot(*end_sd_px)
    apart = float(np.hypot(*(points[0] - points[-1])))
    return 1 - exp(-((apart / sd) ** 2) / 2) / 2 if sd > 0 else 1.0
