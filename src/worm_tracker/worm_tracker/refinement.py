"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from worm_tracker.outline import POINTS, arc_length, resample

Floats = NDArray[np.float64]

STEP_PX = 0.5
NODE_SPACING = 0.4
"""Distance of the cross-sections, in widths."""
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
    """

    points: Floats
    widths: Floats
    level: float
    seen: float


def refine(
    signal: NDArray[np.uint8], offset: tuple[int, int], rough: Floats, width: float, rounds: int = 3
) -> Fine:
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
    rounds : int
        Times that the midline is moved to the middle between its edges.
    """
    nodes = int(np.clip(arc_length(rough)[-1] / (NODE_SPACING * width), MIN_NODES, MAX_NODES))
    curve = resample(rough, nodes) - np.array(offset, np.float64)
    curve = _trim(curve, 1.3 * width)  # a rough midline is least to be trusted at its ends
    sigma = 0.35 * width / max(arc_length(curve)[-1] / (nodes - 1), 1e-6)
    curve = _smooth(curve, sigma)
    for k in range(rounds):
        if k:
            curve = _trim(_with_tips(signal, curve, level, width), 0.6 * width)
        normal = _normals(curve)
        shift, widths, level, found = _edges_across(signal, curve, normal, width)
        curve = curve + normal * _fill(shift, found, 0.0)[:, None]
        curve = _smooth(curve, sigma if k == 0 else 0.6 * sigma)
    whole = _with_tips(signal, curve, level, width)
    points = resample(whole, POINTS)
    widths = np.concatenate([[0.0], _fill(widths, found, width), [0.0]])
    widths = np.interp(arc_length(points), arc_length(whole), widths)
    return Fine(points + np.array(offset), widths, float(np.median(level)), float(found.mean()))


def _trim(curve: Floats, margin: float) -> Floats:
    """Cut both ends by a margin along the arc; the tips are looked for from within."""
    s = arc_length(curve)
    margin = min(margin, 0.2 * s[-1])
    grid = np.linspace(margin, s[-1] - margin, len(curve))
    return np.stack([np.interp(grid, s, curve[:, k]) for k in (0, 1)], axis=1)


def _smooth(curve: Floats, sigma: float) -> Floats:
    """Smooth a curve along itself without pulling its ends in."""
    if sigma < 0.3:
        return curve
    # An odd reflection about the end keeps end points and end slopes.
    pad = int(np.ceil(3 * sigma)) + 1
    pad = min(pad, len(curve) - 1)
    low = 2 * curve[0] - curve[pad:0:-1]
    high = 2 * curve[-1] - curve[-2 : -pad - 2 : -1]
    long = np.concatenate([low, curve, high])
    return np.asarray(ndimage.gaussian_filter1d(long, sigma, axis=0)[pad:-pad])


def _normals(curve: Floats) -> Floats:
    d = np.gradient(curve, axis=0)
    d /= np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)[:, None]
    return np.stack([-d[:, 1], d[:, 0]], axis=1)


def _edges_across(
    signal: NDArray[np.uint8], curve: Floats, normal: Floats, width: float
) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Return, for each point, shift to the middle of the edges, width, level, and success."""
    half = max(4, int(np.ceil(REACH * width / STEP_PX)))
    t = np.arange(-half, half + 1) * STEP_PX
    profiles = _sample(signal, curve[:, None, :] + t[None, :, None] * normal[:, None, :])
    near = np.abs(t) <= 0.3 * width
    level = ndimage.median_filter(profiles[:, near].mean(1), 7, mode="nearest")
    level = np.maximum(level, 1.0)
    right, right_found = _crossing(profiles[:, half:], level)
    left, left_found = _crossing(profiles[:, half::-1], level)
    found = right_found & left_found
    return (right - left) / 2, right + left, level, found


def _crossing(profiles: Floats, level: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the distance at which each profile first falls below half its level."""
    half = level[:, None] / 2
    below = profiles < half
    k = np.argmax(below, axis=1)
    rows = np.arange(len(profiles))
    found = k > 0
    k = np.maximum(k, 1)
    high, low = profiles[rows, k - 1], profiles[rows, k]
    part = (high - half[:, 0]) / np.maximum(high - low, 1e-6)
    return np.where(found, (k - 1 + part) * STEP_PX, 0.0), found


def _with_tips(signal: NDArray[np.uint8], curve: Floats, level: Floats, width: float) -> Floats:
    """Extend a trimmed midline to the tips."""
    first = _tip(signal, curve, float(level[: len(level) // 8].mean()), width)
    last = _tip(signal, curve[::-1], float(level[-len(level) // 8 :].mean()), width)
    return np.concatenate([first[None], curve, last[None]])


def _tip(signal: NDArray[np.uint8], curve: Floats, level: float, width: float) -> Floats:
    """Return the outermost point of the body beyond a curve's first point.

    The curve is continued with the direction and the bend of its first widths.
    """
    s = arc_length(curve)
    n = int(np.clip(np.searchsorted(s, 1.6 * width), 5, len(curve) - 1))
    along = np.polynomial.polynomial.polyfit(-s[: n + 1], curve[: n + 1], 2)
    t = np.arange(0.0, 2.5 * width, STEP_PX)
    line = np.polynomial.polynomial.polyval(t, along).T
    direction = np.gradient(line, axis=0)
    direction /= np.maximum(np.hypot(*direction.T), 1e-9)[:, None]
    normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    beside = np.array([-0.5, 0.0, 0.5])
    values = _sample(signal, line[:, None, :] + beside[None, :, None] * normal[:, None, :]).mean(1)
    out, found = _crossing(values[None], np.array([max(level, 1.0)]))
    reach = float(out[0]) if found[0] else 0.6 * width
    return np.array([np.interp(reach, t, line[:, k]) for k in (0, 1)])


def _sample(signal: NDArray[np.uint8], at: Floats) -> Floats:
    """Return the signal at (…, 2) window coordinates, zero outside."""
    u, v = at[..., 0].astype(np.float32), at[..., 1].astype(np.float32)
    return np.asarray(
        cv2.remap(signal, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT), np.float64
    )


def _fill(values: Floats, found: NDArray[np.bool_], default: float) -> Floats:
    """Replace what was not found by its neighbours along the body."""
    if found.all():
        return values
    if not found.any():
        return np.full_like(values, default)
    x = np.arange(len(values))
    return np.asarray(np.interp(x, x[found], values[found]))
