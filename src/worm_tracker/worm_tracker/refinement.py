"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass
from math import cos, sin
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.outline import POINTS, arc_length, at_arc, smooth_along, tangents

Floats = NDArray[np.float64]

STEP_PX = 0.5
NODE_SPACING = 0.4
"""Distance of the cross-sections, in widths."""
PLATEAU = 0.25
"""How far inside its edge the body's level is read, in widths."""
LOW = 0.25
"""Fraction of the body's level below which there is no body."""
LEVEL_NODES = 5
"""Cross-sections over which the body's level is steadied."""
SHORT = 0.35
"""How far from its tips a midline ends before the tips are looked for, in widths."""
FAN = np.radians(np.arange(-72.0, 72.1, 6.0))
"""Directions in which the outermost point of an end is looked for, about the midline's."""
FAN_POWER = 30
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
    length = float(arc_length(rough)[-1])
    nodes = int(np.clip(length / (NODE_SPACING * width), MIN_NODES, MAX_NODES))
    sigma = 0.35 * width * (nodes - 1) / max(length, 1e-6)
    # The tips are found from within: the ends of a rough midline are least to be trusted.
    curve = _trim(rough - np.array(offset, np.float64), SHORT * width, nodes)
    first = _centre(signal, _smooth(curve, sigma), width, sigma)
    second = _centre(signal, first.curve, width, 0.6 * sigma)
    level = _middle(second.level)
    whole = _with_outermost(signal, second.curve, level, width)
    s, across = _widths_to_tips(whole, second.curve, second.widths)
    s_whole = arc_length(whole)
    area, centre = _area(at_arc(whole, s_whole, s), s, across)
    grid = np.linspace(0.0, s_whole[-1], POINTS)
    return Fine(
        points=at_arc(whole, s_whole, grid) + np.array(offset),
        widths=np.interp(grid, s, across),
        level=level,
        seen=second.seen,
        area=area,
        u=float(centre[0]) + offset[0],
        v=float(centre[1]) + offset[1],
    )


def _area(curve: Floats, s: Floats, widths: Floats) -> tuple[float, Floats]:
    """Return the area between the edges and its centroid.

    Where the body bends, more of its area lies on the outer side: a cross-section of width w has
    its centroid κ w²/12 outwards of the midline, which sums up to w³/12 times the tangent's change.
    """
    area = max(float(np.trapezoid(widths, s)), 1e-9)
    along = np.trapezoid(widths[:, None] * curve, s, axis=0)
    d = curve[1:] - curve[:-1]
    tangent = d / np.maximum(np.sqrt((d * d).sum(1)), 1e-9)[:, None]
    outwards = -(widths[1:-1, None] ** 3 / 12 * (tangent[1:] - tangent[:-1])).sum(0)
    return area, (along + outwards) / area


def _widths_to_tips(whole: Floats, curve: Floats, widths: Floats) -> tuple[Floats, Floats]:
    """Return arc lengths from tip to tip and the widths there; the ends are round."""
    length = arc_length(whole)[-1]
    at = float(np.hypot(*(curve[0] - whole[0]))) + arc_length(curve)
    inside = (at > 0) & (at < length)
    at, widths = at[inside], widths[inside]
    if not len(at):
        return np.array([0.0, length]), np.zeros(2)
    x = np.array([0.0, 0.05, 0.15, 0.35, 0.65])
    cap = np.sqrt(1 - (1 - x) ** 2)
    first, last = x * at[0], length - x[::-1] * (length - at[-1])
    s = np.concatenate([first, at, last])
    return s, np.concatenate([cap * widths[0], widths, cap[::-1] * widths[-1]])


def _trim(curve: Floats, margin: float, count: int) -> Floats:
    """Cut both ends by a margin along the arc; return `count` points at equal steps."""
    s = arc_length(curve)
    margin = min(margin, 0.2 * float(s[-1]))
    return at_arc(curve, s, np.linspace(margin, s[-1] - margin, count))


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
    return smooth_along(long, sigma, pad)


class _Centred(NamedTuple):
    """A curve moved to the middle between its edges; widths, levels, fraction of edges seen."""

    curve: Floats
    widths: Floats
    level: NDArray[np.float32]
    seen: float


def _centre(signal: NDArray[np.uint8], curve: Floats, width: float, sigma: float) -> _Centred:
    """Move a curve to the middle between the half-height edges across it."""
    normal = tangents(curve)[:, ::-1] * np.array([-1.0, 1.0])
    half = max(4, int(np.ceil(REACH * width / STEP_PX)))
    t = np.arange(-half, half + 1, dtype=np.float64) * STEP_PX
    profiles = _sample(signal, curve, normal, t)
    core = max(1, int(0.3 * width / STEP_PX))
    level = profiles[:, half - core : half + core + 1].mean(1)
    level = np.maximum(cv2.medianBlur(level[None], LEVEL_NODES)[0], 1.0)
    both = np.concatenate([profiles[:, half:], profiles[:, half::-1]])
    out, found = _edge(both, np.concatenate([level, level]), _inside(width))
    right, left = out[: len(curve)], out[len(curve) :]
    seen = found[: len(curve)] & found[len(curve) :]
    shift = _fill((right - left) / 2, seen, 0.0)
    moved = _smooth(curve + normal * shift[:, None], sigma)
    return _Centred(moved, _fill(right + left, seen, width), level, float(seen.mean()))


def _edge(
    profiles: NDArray[np.float32], level: NDArray[np.float32], inside: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the distance at which each profile falls through the half-height of its edge.

    The edge is first met where the profile falls below a low fraction of the body's level; its
    height is then taken `inside` samples further in, because a body need not be equally dark
    across its width.
    """
    rows = np.arange(len(profiles))
    foot = np.argmax(profiles < LOW * level[:, None], axis=1)
    found = foot > 0
    foot = np.maximum(foot, 1)
    top = np.maximum(foot - inside, 0)
    plateau = (profiles[rows, top] + profiles[rows, np.maximum(top - 1, 0)]) / 2
    # Never above the body's own level: a bright rim must not narrow the body.
    half = 0.5 * np.minimum(np.maximum(plateau, 2 * LOW * level), level)
    ahead = np.arange(profiles.shape[1]) >= top[:, None]
    k = np.argmax((profiles < half[:, None]) & ahead, axis=1)
    found &= k > 0
    k = np.maximum(k, 1)
    high, low = profiles[rows, k - 1], profiles[rows, k]
    part = np.minimum(np.maximum((high - half) / np.maximum(high - low, 1e-6), 0.0), 1.0)
    return np.where(found, (k - 1 + part) * STEP_PX, 0.0), found


def _with_outermost(signal: NDArray[np.uint8], curve: Floats, level: float, width: float) -> Floats:
    """Let a centred midline, which ends short of its tips, end at the outermost points.

    From a point within each end, edge distances are measured on a fan of rays. The tip's direction
    is their mean, weighed by a high power of the distance: sharp for a pointed end, along the axis
    for a round one.
    """
    s = arc_length(curve)
    near, far = np.minimum(np.array([0.3, 1.1]) * width, 0.4 * s[-1])
    bases = at_arc(curve, s, np.array([near, s[-1] - near]))
    axes = bases - at_arc(curve, s, np.array([far, s[-1] - far]))
    axis_angles = np.arctan2(axes[:, 1], axes[:, 0])
    angles = (axis_angles[:, None] + FAN).ravel()
    rays = np.empty((len(angles), 2))
    rays[:, 0], rays[:, 1] = np.cos(angles), np.sin(angles)
    starts = np.repeat(bases, len(FAN), axis=0)
    t = np.arange(int(2.4 * width / STEP_PX) + 1, dtype=np.float64) * STEP_PX
    profiles = _sample(signal, starts, rays, t)
    reach, found = _edge(profiles, np.full(len(rays), level, np.float32), _inside(width))
    parts = [curve]
    for end in (0, 1):
        fan = slice(end * len(FAN), (end + 1) * len(FAN))
        tip = _farthest(bases[end], axis_angles[end], reach[fan], found[fan])
        if tip is not None:
            parts.insert(0, tip) if end == 0 else parts.append(tip)
    return np.concatenate(parts)


def _farthest(base: Floats, axis: float, reach: Floats, found: NDArray[np.bool_]) -> Floats | None:
    """Return the outermost edge point on a fan of rays, shape (1, 2); None where edges are rare."""
    if found.sum() < len(FAN) // 2:
        return None
    reach = np.where(found, reach, 0.0)
    weight = (reach / reach.max()) ** FAN_POWER
    turn = float((weight @ FAN) / weight.sum())
    distance = float(np.interp(turn, FAN[found], reach[found]))
    return base[None] + distance * np.array([[cos(axis + turn), sin(axis + turn)]])


def _sample(
    signal: NDArray[np.uint8], start: Floats, direction: Floats, t: Floats
) -> NDArray[np.float32]:
    """Return the signal along straight lines, shape (lines, len(t)); zero outside the window."""
    start32, direction32, t32 = (x.astype(np.float32) for x in (start, direction, t))
    u = start32[:, :1] + direction32[:, :1] * t32
    v = start32[:, 1:] + direction32[:, 1:] * t32
    sampled = cv2.remap(signal, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return sampled.astype(np.float32)


def _inside(width: float) -> int:
    """Return how many samples inside its edge the body's level is read."""
    return max(1, round(PLATEAU * width / STEP_PX))


def _middle(values: NDArray[np.float32]) -> float:
    """Return the (upper) median; NumPy's own takes five times as long for so few values."""
    return float(np.sort(values)[len(values) // 2])


def _fill(values: Floats, found: NDArray[np.bool_], default: float) -> Floats:
    """Replace what was not found by its neighbours along the body."""
    if found.all():
        return values
    if not found.any():
        return np.full_like(values, default)
    x = np.arange(len(values))
    return np.asarray(np.interp(x, x[found], values[found]))
