"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from worm_tracker.outline import POINTS, arc_length, at_arc, tangents

Floats = NDArray[np.float64]

STEP_PX = 0.5
NODE_SPACING = 0.4
"""Distance of the cross-sections, in widths."""
PLATEAU = 0.25
"""How far inside its edge the body's level is read, in widths."""
LOW = 0.25
"""Fraction of the body's level below which there is no body."""
LEVEL_NODES = 5
"""Cross-sections to either side over which the body's level is steadied."""
FAN = np.radians(np.arange(-72.0, 72.1, 6.0))
"""Directions in which the outermost point of an end is looked for, about the midline's."""
FAN_POWER = 16
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
    curve = rough - np.array(offset, np.float64)
    # A rough midline is least to be trusted at its ends: they are found from within.
    curve = _smooth(_trim(curve, width, nodes), sigma)
    first = _centre(signal, curve, width, sigma)
    curve = _trim(_with_tips(signal, first.curve, first.level, width), 0.6 * width, nodes)
    second = _centre(signal, curve, width, 0.6 * sigma)
    level = float(np.median(second.level))
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
    return np.asarray(ndimage.gaussian_filter1d(long, sigma, axis=0)[pad:-pad])


class _Centred(NamedTuple):
    """A curve moved to the middle between its edges; widths, levels, fraction of edges seen."""

    curve: Floats
    widths: Floats
    level: Floats
    seen: float


def _centre(signal: NDArray[np.uint8], curve: Floats, width: float, sigma: float) -> _Centred:
    """Move a curve to the middle between the half-height edges across it."""
    normal = tangents(curve)[:, ::-1] * np.array([-1.0, 1.0])
    half = max(4, int(np.ceil(REACH * width / STEP_PX)))
    t = np.arange(-half, half + 1) * STEP_PX
    profiles = _sample(signal, curve[:, None, :] + t[None, :, None] * normal[:, None, :])
    core = max(1, int(0.3 * width / STEP_PX))
    level = profiles[:, half - core : half + core + 1].mean(1)
    level = ndimage.median_filter(level, min(2 * LEVEL_NODES + 1, len(level)), mode="nearest")
    level = np.maximum(level, 1.0)
    inside = max(1, round(PLATEAU * width / STEP_PX))
    both = np.concatenate([profiles[:, half:], profiles[:, half::-1]])
    out, found = _edge(both, np.concatenate([level, level]), inside)
    right, left = out[: len(curve)], out[len(curve) :]
    seen = found[: len(curve)] & found[len(curve) :]
    shift = _fill((right - left) / 2, seen, 0.0)
    moved = _smooth(curve + normal * shift[:, None], sigma)
    return _Centred(moved, _fill(right + left, seen, width), level, float(seen.mean()))


def _edge(profiles: Floats, level: Floats, inside: int) -> tuple[Floats, NDArray[np.bool_]]:
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
    half = 0.5 * np.clip(plateau, 2 * LOW * level, level)
    ahead = np.arange(profiles.shape[1]) >= top[:, None]
    k = np.argmax((profiles < half[:, None]) & ahead, axis=1)
    found &= k > 0
    k = np.maximum(k, 1)
    high, low = profiles[rows, k - 1], profiles[rows, k]
    part = np.clip((high - half) / np.maximum(high - low, 1e-6), 0.0, 1.0)
    return np.where(found, (k - 1 + part) * STEP_PX, 0.0), found


def _with_tips(signal: NDArray[np.uint8], curve: Floats, level: Floats, width: float) -> Floats:
    """Let a midline end at the tips."""
    middle = float(np.median(level))
    n = len(level) // 8
    for part in (level[:n], level[-n:]):
        # What is dark enough to be the body, even where the end is dimmer than the middle.
        local = max(float(np.median(part)), 0.5 * middle)
        tip, reach = _tip(signal, curve, local, width)
        inner = curve if reach > 0 else curve[np.searchsorted(arc_length(curve), -reach, "right") :]
        curve = np.concatenate([tip[None], inner])[::-1]
    return curve


def _tip(
    signal: NDArray[np.uint8], curve: Floats, level: float, width: float
) -> tuple[Floats, float]:
    """Return the outermost point of the body near a curve's first point, and how far beyond it is.

    The curve is continued with the direction and the bend of its first widths, and searched from
    well within the body outwards.
    """
    s = arc_length(curve)
    n = int(np.clip(np.searchsorted(s, 1.6 * width), 5, len(curve) - 1))
    powers = np.vander(-s[: n + 1], 3, increasing=True)
    along = np.linalg.solve(powers.T @ powers, powers.T @ curve[: n + 1])
    t = np.arange(-1.2 * width, 2.2 * width, STEP_PX)
    line = at_arc(curve, s, -t)
    beyond = t > 0
    line[beyond] = np.vander(t[beyond], 3, increasing=True) @ along
    values = _sample(signal, line[None])[0]
    out, found = _edge(values[None], np.array([level]), max(1, round(PLATEAU * width / STEP_PX)))
    reach = t[0] + float(out[0]) if found[0] else 0.0
    return at_arc(line, t, np.array([reach]))[0], reach


def _with_outermost(signal: NDArray[np.uint8], curve: Floats, level: float, width: float) -> Floats:
    """Let a centred midline, which ends short of its tips, end at the outermost points."""
    for _ in range(2):
        s = arc_length(curve)
        within = np.array([0.3, 1.1]) * width
        base, further = at_arc(curve, s, np.minimum(within, 0.4 * s[-1]))
        tip = _outermost(signal, base, base - further, level, width)
        curve = curve if tip is None else np.concatenate([tip[None], curve])
        curve = curve[::-1]
    return curve


def _outermost(
    signal: NDArray[np.uint8], base: Floats, axis: Floats, level: float, width: float
) -> Floats | None:
    """Return the edge point that is farthest from a point within the end.

    Edge distances are measured on a fan of rays; the direction is their mean, weighed by a high
    power of the distance: sharp for a pointed end, along the axis for a round one.
    """
    angles = FAN + np.arctan2(axis[1], axis[0])
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    r = np.arange(0.0, 2.2 * width, STEP_PX)
    profiles = _sample(signal, base + r[None, :, None] * rays[:, None, :])
    inside = max(1, round(PLATEAU * width / STEP_PX))
    reach, found = _edge(profiles, np.full(len(FAN), level), inside)
    if found.sum() < len(FAN) // 2:
        return None
    reach = np.where(found, reach, 0.0)
    weight = (reach / reach.max()) ** FAN_POWER
    turn = float((weight * FAN).sum() / weight.sum())
    angle = turn + np.arctan2(axis[1], axis[0])
    distance = float(np.interp(turn, FAN[found], reach[found]))
    return base + distance * np.array([np.cos(angle), np.sin(angle)])


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
