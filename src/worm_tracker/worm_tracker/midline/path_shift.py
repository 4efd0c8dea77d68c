"""Moves a path sideways to where its cross-sections lie, no more abruptly than a body bends."""

from dataclasses import dataclass

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.cross_sections import CrossSections
from worm_tracker.midline.curve import smooth_open_curve, tangents
from worm_tracker.midline.path import evenly


@dataclass(frozen=True, slots=True)
class PathShiftSettings:
    """How far a path is moved, and how smoothly."""

    unseen_offset_sd_widths: float = 0.35
    """How far an unseen part may lie beside the path."""
    turn_sd_rad: float = 0.25
    """How far a stretch of a width may turn against the path."""
    bend_sd_rad_per_width: float = 0.5
    """How far its direction may bend against the path's within a width."""
    smoothing_widths: float = 0.3
    """Scale below which the path's wiggles are noise."""


def moved_to_middle(
    curve: Complex, step: float, seen: CrossSections, width: float, settings: PathShiftSettings
) -> Complex:
    """Return a path moved to the middle of its cross-sections, smoothly, its steps even again.

    The shifts minimise their squared misfits, each over its variance, plus those of the priors: an
    unseen part stays on the path, and shifts neither turn nor bend it much.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        u + iv.
    step, width : float
        Distance of its nodes and the body's width, pixels.
    seen : CrossSections
        At its nodes.
    settings : PathShiftSettings
    """
    share = step / width  # of a width, between two nodes
    turn = share / (settings.turn_sd_rad * step) ** 2
    bend = share / (settings.bend_sd_rad_per_width * step * share) ** 2
    unseen = share / (settings.unseen_offset_sd_widths * width) ** 2
    shift = np.empty(len(curve))
    _solve_shifts(seen.weight * share, seen.shift, unseen, turn, bend, shift)
    moved = curve + 1j * tangents(curve) * shift
    # Smoothed once, a curve would be pulled inwards; smoothed back by the same, it keeps its bends.
    sigma = settings.smoothing_widths * width / step
    once = smooth_open_curve(moved, sigma)
    return evenly(2 * once - smooth_open_curve(once, sigma), len(moved))


@compiled_for(
    array_read(types.float64),
    array_read(types.float64),
    types.float64,
    types.float64,
    types.float64,
    array_written(types.float64),
)
def _solve_shifts(
    weight: Floats, wanted: Floats, unseen: float, turn: float, bend: float, shift: Floats
) -> None:
    """Fill in the shifts of least cost: with two neighbours to either side, by LDLᵀ.

    Their squared distances from those wanted count by `weight`, they themselves by `unseen`, their
    first differences by `turn`, their second ones by `bend`.
    """
    n = len(weight)
    pivot, below, second = np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(n):
        sides = min(k, 1) + min(n - 1 - k, 1)
        middle = 4.0 if 0 < k < n - 1 else 0.0
        outer = (1.0 if k > 1 else 0.0) + (1.0 if k < n - 2 else 0.0)
        pivot[k] = weight[k] + unseen + sides * turn + (middle + outer) * bend
        shift[k] = weight[k] * wanted[k]
        if k > 1:
            second[k] = bend / pivot[k - 2]
            pivot[k] -= second[k] ** 2 * pivot[k - 2]
            shift[k] -= second[k] * shift[k - 2]
        if k > 0:
            bends = (1.0 if k > 1 else 0.0) + (1.0 if k < n - 1 else 0.0)
            beside = -turn - 2 * bends * bend
            if k > 1:
                beside -= second[k] * pivot[k - 2] * below[k - 1]
            below[k] = beside / pivot[k - 1]
            pivot[k] -= below[k] ** 2 * pivot[k - 1]
            shift[k] -= below[k] * shift[k - 1]
    for k in range(n):
        shift[k] /= pivot[k]
    for k in range(n - 1, -1, -1):
        if k + 1 < n:
            shift[k] -= below[k + 1] * shift[k + 1]
        if k + 2 < n:
            shift[k] -= second[k + 2] * shift[k + 2]
