"""Cross-sections of a body that may lie on itself: where their middle is, and whether that is seen.

A cross-section with both edges a body's width apart tells its middle. One that merges with another
part of the body at one side still has its other edge, half a known width from the middle. One that
has no edge where the body's could be tells nothing.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.midline.contour_midline import Complex, Floats, tangents

STEP_PX = 0.5
"""Step of the profiles across the body."""
REACH = 0.95
"""How far to either side edges are looked for, in widths."""
CORE = 0.2
"""How far from its middle the body's level is read, in widths."""
SPINE_PX = 1.0
"""How far from its middle it is read where the body ends: a tip is narrow."""
EDGE = 0.5
"""Part of the body's level at its edge."""
EDGE_SD, LONE_EDGE_SD = 0.03, 0.08
"""Error of a cross-section's middle, in widths, where both its edges or only one is seen."""
UNEQUAL_WIDTH, LONE_SHIFT = 0.3, 0.3
"""Most that a cross-section's width differs from the known one, and shifts by one edge, widths."""


@dataclass(frozen=True, eq=False, slots=True)
class CrossSections:
    """What is seen across a path, at each of its nodes.

    Attributes
    ----------
    shift : ndarray, shape (n,)
        How far to the side of the path the body's middle is, pixels; 0 where that is not seen.
    weight : ndarray, shape (n,)
        One over that number's variance; 0 where it is not seen.
    spine : ndarray, shape (n,)
        Signal on the path, grey levels.
    """

    shift: Floats
    weight: Floats
    spine: NDArray[np.float32]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Where an edge is seen."""
        return self.weight > 0

    @property
    def turned(self) -> "CrossSections":
        """The same from the other end on (the shifts' sign left as it is)."""
        return CrossSections(self.shift[::-1], self.weight[::-1], self.spine[::-1])


def cross_sections(
    signal: NDArray[np.uint8], path: Complex, half: Floats, level: float, width: float, ends: int
) -> CrossSections:
    """Look for a body's edges across a path.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    path : ndarray of complex, shape (n,)
        u + iv in the signal's coordinates.
    half : ndarray, shape (n,)
        Half the width that the body is expected to have.
    level : float
        Signal on the midline, grey levels.
    width : float
        The body's width, pixels.
    ends : int
        Nodes at either end at which the body may taper off in a way that is not known yet.
    """
    n = len(path)
    reach = int(REACH * width / STEP_PX) + 1
    offsets = STEP_PX * np.arange(-reach, reach + 1)
    profiles = sampled(signal, path[:, None] + (1j * tangents(path))[:, None] * offsets)
    core, spine = (
        profiles[:, reach - k : reach + k + 1].mean(axis=1)
        for k in (max(1, round(CORE * width / STEP_PX)), round(SPINE_PX / STEP_PX))
    )
    # Where the body lies on itself it may be darker: its edge is still that of one layer.
    threshold = EDGE * np.clip(core, 0.4 * level, level)
    right = _first_below(profiles[:, reach:], threshold)
    left = _first_below(profiles[:, reach::-1], threshold)
    body = core > EDGE * level
    tip = np.ones(n, np.bool_)
    tip[ends : n - ends] = False
    across = right + left
    gate = UNEQUAL_WIDTH * width
    both = body & np.where(tip, across < width + gate, np.abs(across - 2 * half) < gate)
    shift = np.zeros(n)
    shift[both] = (right[both] - left[both]) / 2
    weight = np.where(both, (EDGE_SD * width) ** -2, 0.0)
    # Of two edges that do not make the body's width, the one nearer to its place is believed.
    off_right, off_left = right - half, half - left
    lone = np.where(np.abs(off_right) <= np.abs(off_left), off_right, off_left)
    one = body & ~both & ~tip & (np.abs(lone) < LONE_SHIFT * width)
    shift[one] = lone[one]
    weight[one] = (LONE_EDGE_SD * width) ** -2
    return CrossSections(shift, weight, spine)


def sampled(signal: NDArray[np.uint8], where: Complex) -> NDArray[np.float32]:
    """Return a signal between its pixels, at u + iv; zero outside."""
    at = where.astype(np.complex64).view(np.float32).reshape(*where.shape, 2)
    values = cv2.remap(  # the stubs do not know that pairs need no second map
        signal,
        at,
        None,  # type: ignore[call-overload]
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
    )
    return np.asarray(values, np.float32)


def _first_below(profiles: NDArray[np.float32], threshold: Floats) -> Floats:
    """Return where each profile first falls below its threshold; infinity where it does not."""
    below = profiles < threshold[:, None]
    below[:, 0] = False
    k = below.argmax(axis=1)
    row = np.arange(len(profiles))
    high, low = profiles[row, np.maximum(k - 1, 0)], profiles[row, k]
    part = np.clip((high - threshold) / np.maximum(high - low, 1e-6), 0.0, 1.0)
    return np.where(k > 0, (k - 1 + part) * STEP_PX, np.inf)
