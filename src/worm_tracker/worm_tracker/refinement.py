"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass
from functools import cache
from math import cos, sin
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.outline import (
    POINTS,
    Complex,
    arc,
    as_complex,
    as_points,
    smooth_along,
    tangents,
    unit_grid,
)

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
_RAYS = np.exp(1j * FAN)
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
    whole = _with_outermost(signal, body.curve, level, width)
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
    profiles = _sample(signal, curve, normal, _steps(-half, half))
    core = max(1, int(0.3 * width / STEP_PX))
    level = profiles[:, half - core : half + core + 1] @ _mean_of(2 * core + 1)
    level = np.maximum(cv2.medianBlur(level[None], LEVEL_NODES)[0], 1.0)
    both = np.empty((2 * n, half + 1), np.float32)
    both[:n], both[n:] = profiles[:, half:], profiles[:, half::-1]
    out, found = _edge(both, np.concatenate([level, level]), _inside(width))
    right, left = out[:n], out[n:]
    shift, across = (right - left) / 2, right + left
    seen = found[:n] & found[n:]
    if not seen.all():
        shift, across = _fill(shift, seen, 0.0), _fill(across, seen, width)
    moved = _smooth(curve + normal * shift, sigma)
    return _Centred(moved, across, level, float(np.count_nonzero(seen) / n))


def _edge(
    profiles: NDArray[np.float32], level: NDArray[np.float32], inside: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the distance at which each profile falls through the half-height of its edge.

    The edge is first met where the profile falls below a low fraction of the body's level; its
    height is then taken `inside` samples further in, because a body need not be equally dark
    across its width.
    """
    count, size = profiles.shape
    flat, row = profiles.reshape(-1), size * np.arange(count)
    foot = (profiles < (LOW * level)[:, None]).argmax(axis=1)
    found = foot > 0
    top = np.maximum(foot - inside, 0)
    at = row + top
    plateau = (flat[at] + flat[np.maximum(at - 1, row)]) / 2
    # Never above the body's own level: a bright rim must not narrow the body.
    half = 0.5 * np.minimum(np.maximum(plateau, 2 * LOW * level), level)
    # What darkens the water beside the body, a reflection say, is no part of it.
    beside = (flat[row + size - 1] + flat[row + size - 2] + flat[row + size - 3]) / 3
    half += np.where(beside < LOW * level, beside / 2, 0)
    below = profiles < half[:, None]
    below &= _counting(size) >= top[:, None]
    k = below.argmax(axis=1)
    found &= k > 0
    at = row + np.maximum(k, 1)
    high, low = flat[at - 1], flat[at]
    part = np.minimum(np.maximum((high - half) / np.maximum(high - low, 1e-6), 0.0), 1.0)
    return np.where(found, (k - 1 + part) * STEP_PX, 0.0), found


def _with_outermost(
    signal: NDArray[np.uint8], curve: Complex, level: float, width: float
) -> Complex:
    """Let a centred midline, which ends short of its tips, end at the outermost points.

    From a point within each end, edge distances are measured on a fan of rays. The tip's direction
    is their mean, weighed by a high power of the distance: sharp for a pointed end, along the axis
    for a round one.
    """
    s = arc(curve)
    length = float(s[-1])
    near, far = min(0.3 * width, 0.4 * length), min(1.1 * width, 0.4 * length)
    inner = np.interp(np.array([near, length - near, far, length - far]), s, curve)
    bases, axes = inner[:2], inner[:2] - inner[2:]
    axes = axes / np.maximum(np.abs(axes), 1e-9)
    rays = (axes[:, None] * _RAYS).ravel()
    size = int(2.4 * width / STEP_PX)
    profiles = _sample(signal, bases.repeat(len(FAN)), rays, _steps(0, size))
    levels = np.full(len(rays), level, np.float32)
    reach, found = _edge(profiles, levels, _inside(width))
    parts = [curve]
    for end in (0, 1):
        fan = slice(end * len(FAN), (end + 1) * len(FAN))
        tip = _farthest(complex(bases[end]), complex(axes[end]), reach[fan], found[fan])
        if tip is not None:
            parts.insert(0, tip) if end == 0 else parts.append(tip)
    return np.concatenate(parts)


def _farthest(
    base: complex, axis: complex, reach: Floats, found: NDArray[np.bool_]
) -> Complex | None:
    """Return the outermost edge point on a fan of rays, shape (1,); None where edges are rare."""
    if np.count_nonzero(found) < len(FAN) // 2:
        return None
    weight = (reach / reach.max()) ** FAN_POWER  # zero where nothing was found
    turn = float((weight @ FAN) / weight.sum())
    distance = float(np.interp(turn, FAN[found], reach[found]))
    return np.array([base + distance * axis * complex(cos(turn), sin(turn))])


def _sample(
    signal: NDArray[np.uint8], start: Complex, direction: Complex, t: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the signal along straight lines, shape (lines, len(t)); zero outside the window."""
    at = direction.astype(np.complex64)[:, None] * t
    at += start.astype(np.complex64)[:, None]
    where = at.view(np.float32).reshape(*at.shape, 2)
    sampled = cv2.remap(  # the stubs do not know that pairs need no second map
        signal,
        where,
        None,  # type: ignore[call-overload]
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
    )
    return np.asarray(sampled, np.float32)


@cache
def _steps(first: int, last: int) -> NDArray[np.float32]:
    """Return the distances from `first` to `last` steps."""
    return np.arange(first, last + 1, dtype=np.float32) * np.float32(STEP_PX)


@cache
def _counting(size: int) -> NDArray[np.int64]:
    return np.arange(size)


@cache
def _mean_of(size: int) -> NDArray[np.float32]:
    """Return the weights that average so many values: a product is faster than `mean`."""
    return np.full(size, 1 / size, np.float32)


def _inside(width: float) -> int:
    """Return how many samples inside its edge the body's level is read."""
    return max(1, round(PLATEAU * width / STEP_PX))


def _middle(values: NDArray[np.float32]) -> float:
    """Return the (upper) median; NumPy's own takes five times as long for so few values."""
    return float(np.sort(values)[len(values) // 2])


def _fill(values: Floats, found: NDArray[np.bool_], default: float) -> Floats:
    """Replace what was not found by its neighbours along the body."""
    if not found.any():
        return np.full_like(values, default)
    x = np.arange(len(values))
    return np.asarray(np.interp(x, x[found], values[found]))
