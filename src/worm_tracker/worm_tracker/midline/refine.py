"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.midline.contour_midline import (
    POINTS,
    Complex,
    Floats,
    arc,
    as_complex,
    as_points,
    smooth_along,
    tangents,
    unit_grid,
)
from worm_tracker.midline.edges import STEP_PX, edges, sample, steps
from worm_tracker.midline.tips import with_tips

NODE_SPACING = 0.4
"""Distance of the cross-sections, in widths."""
BUMP, BUMP_NODES = 1.1, 7
"""Width over the median of so many cross-sections to either side that is not the worm's alone."""
LEVEL_NODES = 5
"""Cross-sections over which the body's level is steadied."""
SHORT = 0.35
"""How far from its tips a midline ends before the tips are looked for, in widths."""
_CAP_AT = np.array([0.0, 0.05, 0.15, 0.35, 0.65])
_CAP = np.sqrt(1 - (1 - _CAP_AT) ** 2)
"""Widths of a round end at these parts of the way from the tip, relative."""
MIN_NODES, MAX_NODES = 40, 200
REACH = 0.9
"""How far to either side the edges are looked for, in widths."""


@dataclass(frozen=True, eq=False, slots=True)
class Fine:
    """A midline below a pixel.

    Attributes
    ----------
    points : ndarray, shape (POINTS, 2)
        (u, v) at equal steps from tip to tip.
    widths : ndarray, shape (POINTS,)
        Distance of the half-height edges; NaN-free, zero at the tips.
    level : float
        Median signal on the midline.
    seen : float
        Fraction of the cross-sections in which both edges were found.
    area, u, v : float
        Area between the edges and its centroid.
    """

    points: Floats
    widths: Floats
    level: float
    seen: float
    area: float
    u: float
    v: float


def refine(signal: NDArray[np.uint8], offset: tuple[int, int], rough: Floats, width: float) -> Fine:
    """Refine a midline on the signal.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window, not smoothed.
    offset : (int, int)
        (u, v) of the window's first pixel.
    rough : ndarray, shape (n, 2)
        A midline that lies within the body.
    width : float
        The body's expected width, pixels.
    """
    curve = as_complex(rough) - complex(*offset)
    s = arc(curve)
    length = float(s[-1])
    nodes = int(min(max(length / (NODE_SPACING * width), MIN_NODES), MAX_NODES))
    sigma = 0.35 * width * (nodes - 1) / max(length, 1e-6)
    # The tips are found from within: the ends of a rough midline are least to be trusted.
    margin = min(SHORT * width, 0.2 * length)
    curve = np.interp(margin + (length - 2 * margin) * unit_grid(nodes), s, curve)
    body = _centre(signal, _smooth(curve, sigma), width, 0.6 * sigma)
    level = _middle(body.level)
    whole = with_tips(signal, body.curve, level, width)
    s_whole = arc(whole)
    s, across = _widths_to_tips(whole, s_whole, body)
    area, centre = _area(np.interp(s, s_whole, whole), s, across)
    grid = s_whole[-1] * unit_grid(POINTS)
    return Fine(
        points=as_points(np.interp(grid, s_whole, whole) + complex(*offset)),
        widths=np.interp(grid, s, across),
        level=level,
        seen=body.seen,
        area=area,
        u=centre.real + offset[0],
        v=centre.imag + offset[1],
    )


def _area(curve: Complex, s: Floats, widths: Floats) -> tuple[float, complex]:
    """Return the area between the edges and its centroid.

    Where the body bends, more of its area lies on the outer side: a cross-section of width w has
    its centroid κ w²/12 outwards of the midline, which sums up to w³/12 times the tangent's change.
    """
    step = s[1:] - s[:-1]
    weight = np.zeros(len(s))  # of each cross-section, by the trapezoidal rule
    weight[1:] = step
    weight[:-1] += step
    weight *= widths / 2
    area = max(float(weight.sum()), 1e-9)
    d = curve[1:] - curve[:-1]
    d /= np.maximum(step, 1e-9)
    outwards = -(widths[1:-1] ** 3 * (d[1:] - d[:-1])).sum() / 12
    return area, complex(((weight * curve).sum() + outwards) / area)


def _widths_to_tips(whole: Complex, s_whole: Floats, body: "_Centred") -> tuple[Floats, Floats]:
    """Return arc lengths from tip to tip and the widths there; the ends are round."""
    length = float(s_whole[-1])
    curve, widths = body.curve, body.widths
    first_gap = abs(curve[0] - whole[0])
    last_gap = abs(curve[-1] - whole[-1])
    at = s_whole[1:] if first_gap > 0 else s_whole
    at = at[: len(curve)]
    first, last = _CAP_AT * first_gap, length - _CAP_AT[::-1] * last_gap
    s = np.concatenate([first, at, last])
    return s, np.concatenate([_CAP * widths[0], widths, _CAP[::-1] * widths[-1]])


def _smooth(curve: Complex, sigma: float) -> Complex:
    """Smooth a curve along itself without pulling its ends in."""
    if sigma < 0.3:
        return curve
    # An odd reflection about the end keeps end points and end slopes.
    pad = min(int(3 * sigma) + 2, len(curve) - 1)
    low = 2 * curve[0] - curve[pad:0:-1]
    high = 2 * curve[-1] - curve[-2 : -pad - 2 : -1]
    return smooth_along(np.concatenate([low, curve, high]), sigma, pad)


class _Centred(NamedTuple):
    """A curve moved to the middle between its edges; widths, levels, fraction of edges seen."""

    curve: Complex
    widths: Floats
    level: NDArray[np.float32]
    seen: float


def _centre(signal: NDArray[np.uint8], curve: Complex, width: float, sigma: float) -> _Centred:
    """Move a curve to the middle between the half-height edges across it."""
    n = len(curve)
    normal = 1j * tangents(curve)
    half = max(4, int(REACH * width / STEP_PX) + 1)
    profiles = sample(signal, [curve, normal], steps(-half, half))
    core = max(1, int(0.3 * width / STEP_PX))
    level = profiles[:, half - core : half + core + 1] @ _mean_of(2 * core + 1)
    level = np.maximum(cv2.medianBlur(level[None], LEVEL_NODES)[0], 1.0)
    both = np.empty((2 * n, half + 1), np.float32)
    both[:n], both[n:] = profiles[:, half:], profiles[:, half::-1]
    out, found = edges(both, np.concatenate([level, level]), width)
    right, left = out[:n], out[n:]
    shift, across = (right - left) / 2, right + left
    seen = found[:n] & found[n:]
    trusted = seen & ~_bumps(across)
    if not trusted.all():
        shift, across = _fill(shift, trusted, 0.0), _fill(across, trusted, width)
    moved = _smooth(curve + normal * shift, sigma)
    return _Centred(moved, across, level, float(np.count_nonzero(seen) / n))


@cache
def _mean_of(size: int) -> NDArray[np.float32]:
    """Return the weights that average so many values: a product is faster than `mean`."""
    return np.full(size, 1 / size, np.float32)


def _middle(values: NDArray[np.float32]) -> float:
    """Return the (upper) median; NumPy's own takes five times as long for so few values."""
    return float(np.sort(values)[len(values) // 2])


def _bumps(across: Floats) -> NDArray[np.bool_]:
    """Return which cross-sections, and their neighbours, have something lying against them.

    These are wider than the median of those about them.
    """
    odd = np.zeros(len(across), bool)
    if across.max() <= BUMP * np.sort(across)[len(across) // 2]:
        return odd
    around = np.pad(across, BUMP_NODES, "reflect")
    around = np.lib.stride_tricks.sliding_window_view(around, 2 * BUMP_NODES + 1)
    odd |= across > BUMP * np.median(around, axis=1)
    wide = odd.copy()
    wide[1:] |= odd[:-1]
    wide[:-1] |= odd[1:]
    return wide


def _fill(values: Floats, found: NDArray[np.bool_], default: float) -> Floats:
    """Replace what was not found by its neighbours along the body."""
    if not found.any():
        return np.full_like(values, default)
    x = np.arange(len(values))
    return np.asarray(np.interp(x, x[found], values[found]))
