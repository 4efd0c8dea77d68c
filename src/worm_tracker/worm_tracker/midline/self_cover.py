"""Where a body lies on or beside itself: which points of its path other parts of it cover.

Only there do an edge or an end of the body stay unseen, or look darker; everywhere else the picture
tells them.
"""

from dataclasses import dataclass
from functools import cache
from math import exp, hypot

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask
from worm_tracker.midline.curve import median_of


@dataclass(frozen=True, slots=True)
class SelfCoverSettings:
    """Which parts of a body are others, and where they lie over a point."""

    least_way_between_parts_widths: float = 1.5
    """Distance along the body from which on two points are of different parts: the two sides of the
    tightest bend are hardly farther apart."""
    nodes_per_disc: int = 2
    """Nodes of a path for each disc that stands for a piece of the body."""


def covered_by_others(
    at: Complex,
    path: Complex,
    half: Floats,
    body: slice,
    step: float,
    margin_px: float | Floats,
    settings: SelfCoverSettings,
) -> Mask:
    """Tell which points beside a path lie under another part of the body.

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
    ndarray of bool, shape (n, m)
    """
    first, last, _ = body.indices(len(path))
    parts = np.arange(first, last, settings.nodes_per_disc)
    width = 2 * median_of(half[first:last]) if last > first else 0.0
    apart = settings.least_way_between_parts_widths * width / max(step, 1e-9)
    margins = np.broadcast_to(margin_px, at.shape[1:])
    radius = np.maximum(half[parts, None] + margins, 0.0).astype(np.float32)
    covered = np.zeros(at.shape, bool)
    if not radius.size:
        return covered
    # Most pairs of node and disc are far apart: only what is left is looked at closely.
    far = float(np.abs(at - path[:, None]).max()) + float(radius.max()) + 1.0
    node, disc = np.nonzero(_squared_distances(path, path[parts]) < far**2)
    others = np.abs(node - parts[disc]) > apart
    node, disc = node[others], disc[others]
    away = at.astype(np.complex64)[node] - path[parts].astype(np.complex64)[disc, None]
    under = away.real**2 + away.imag**2 < (radius**2)[disc]
    for column in range(at.shape[1]):
        covered[node[under[:, column]], column] = True
    return covered


def lies_near_itself(path: Complex, width: float, step: float, far_widths: float = 2.2) -> bool:
    """Tell whether two parts of a path are so near that one can hide an edge of the other."""
    coarse = path[:: max(1, round(0.5 * width / step))]
    near = _squared_distances(coarse, coarse) < (far_widths * width) ** 2
    return bool((near & _six_apart(len(coarse))).any())


@cache
def _six_apart(count: int) -> Mask:
    """Tell which pairs of so many points have more than five between them."""
    k = np.arange(count)
    return np.asarray(np.abs(k[:, None] - k) > 6)


def _squared_distances(points: Complex, others: Complex) -> Floats32:
    """Return the squares of the distances of all pairs, shape (points, others)."""
    middle = points[:1]  # near which single precision is enough
    u, v = ((points - middle).astype(np.complex64).view(np.float32).reshape(-1, 2)).T
    other_u, other_v = ((others - middle).astype(np.complex64).view(np.float32).reshape(-1, 2)).T
    squared = u[:, None] - other_u
    squared *= squared
    aside = v[:, None] - other_v
    aside *= aside
    squared += aside
    return squared


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
