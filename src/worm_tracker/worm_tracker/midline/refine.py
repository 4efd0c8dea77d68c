"""From a first midline to one below a pixel: half-height edges across and beyond the body.

The head tip (tail tip) is the outermost point of the body's end: going out along the midline, the
point where the signal, which is the light that the body takes away, falls to half of what it is
within the end. The sides are the points where it falls to half of what it is on the midline; the
midline runs half-way between them.
"""

from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask, Picture
from worm_tracker.midline.curve import (
    TRACKED_POINTS,
    as_complex,
    as_points,
    complex_arc_length,
    smooth_open_curve,
    tangents,
    unit_grid,
)
from worm_tracker.midline.edges import (
    PROFILE_STEP_PX,
    EdgeSettings,
    distance_powers,
    find_edges,
    sample_lines,
)
from worm_tracker.midline.tips import TipSettings, with_tips

_CAP_AT = np.array([0.0, 0.05, 0.15, 0.35, 0.65])
_CAP = np.sqrt(1 - (1 - _CAP_AT) ** 2)
"""Widths of a round end at these parts of the way from the tip, relative."""


@dataclass(frozen=True, slots=True)
class RefineSettings:
    """Where a body's edges are measured, and which of them are believed."""

    section_spacing_widths: float = 0.4
    """Distance of the cross-sections: closer ones share their pixels and tell little more."""
    fewest_sections: int = 40
    most_sections: int = 200
    """Bounds on their number: a stout body still bends, a long one must not take too long."""
    start_before_tip_widths: float = 0.35
    """How far from its ends the first midline is cut: the tips are looked for from within."""
    smoothing_widths: float = 0.35
    """Scale below which wiggles of the first midline are smoothed away."""
    edge_reach_widths: float = 0.9
    """How far to either side the edges are looked for: beyond them, short of the next turn."""
    level_half_width_widths: float = 0.3
    """How far to either side of the midline the body's level is averaged."""
    level_median_sections: int = 5
    """Cross-sections over which the body's level is steadied."""
    most_width_over_neighbours: float = 1.1
    """Width over the median of its neighbours from which a cross-section is not the worm's alone:
    a body tapers by less within that many sections."""
    neighbour_sections: int = 7
    """How many neighbours to either side that are."""
    tips: TipSettings = field(default_factory=TipSettings)
    edge: EdgeSettings = field(default_factory=EdgeSettings)


@dataclass(frozen=True, eq=False, slots=True)
class RefinedMidline:
    """A midline below a pixel.

    Attributes
    ----------
    points : ndarray, shape (TRACKED_POINTS, 2)
        (u, v) at equal steps from tip to tip.
    widths : ndarray, shape (TRACKED_POINTS,)
        Distance of the half-height edges; NaN-free, zero at the tips.
    levels : ndarray, shape (TRACKED_POINTS,)
        Signal on the midline; towards a tip that of the last cross-section.
    level : float
        Median signal on the midline.
    edges_found : float
        Fraction of the cross-sections in which both edges were found.
    area, u, v : float
        Area between the edges and its centroid.
    """

    points: Floats
    widths: Floats
    levels: Floats
    level: float
    edges_found: float
    area: float
    u: float
    v: float


def refine(
    signal: Picture,
    origin: tuple[int, int],
    first: Floats,
    width: float,
    settings: RefineSettings,
) -> RefinedMidline:
    """Refine a midline on the signal.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window, not smoothed.
    origin : (int, int)
        (u, v) of the window's first pixel.
    first : ndarray, shape (n, 2)
        A midline that lies within the body, in the picture's coordinates.
    width : float
        The body's expected width, pixels.
    settings : RefineSettings
    """
    curve = as_complex(first) - complex(*origin)
    s = complex_arc_length(curve)
    length = float(s[-1])
    nodes = length / (settings.section_spacing_widths * width)
    nodes = int(min(max(nodes, settings.fewest_sections), settings.most_sections))
    sigma = settings.smoothing_widths * width * (nodes - 1) / max(length, 1e-6)
    # The tips are found from within: the ends of a first midline are least to be trusted.
    margin = min(settings.start_before_tip_widths * width, 0.2 * length)
    curve = np.interp(margin + (length - 2 * margin) * unit_grid(nodes), s, curve)
    body = _centre(signal, _smooth(curve, sigma), width, 0.6 * sigma, settings)
    level = _upper_median(body.level)
    whole = with_tips(signal, body.curve, level, width, settings.tips)
    s_whole = complex_arc_length(whole)
    s, across = _widths_to_tips(whole, s_whole, body)
    begins = 1 if whole[0] != body.curve[0] else 0
    area, centre = _area(np.interp(s, s_whole, whole), s, across)
    grid = s_whole[-1] * unit_grid(TRACKED_POINTS)
    return RefinedMidline(
        points=as_points(np.interp(grid, s_whole, whole) + complex(*origin)),
        widths=np.interp(grid, s, across),
        levels=np.interp(grid, s_whole[begins : begins + len(body.level)], body.level),
        level=level,
        edges_found=body.edges_found,
        area=area,
        u=centre.real + origin[0],
        v=centre.imag + origin[1],
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
    """Smooth a curve along itself, if there is anything to smooth."""
    return curve if sigma < 0.3 else smooth_open_curve(curve, sigma)


class _Centred(NamedTuple):
    """A curve moved to the middle between its edges; widths, levels, fraction of edges seen."""

    curve: Complex
    widths: Floats
    level: Floats32
    edges_found: float


def _centre(
    signal: Picture, curve: Complex, width: float, sigma: float, settings: RefineSettings
) -> _Centred:
    """Move a curve to the middle between the half-height edges across it."""
    n = len(curve)
    normal = 1j * tangents(curve)
    half = max(4, int(settings.edge_reach_widths * width / PROFILE_STEP_PX) + 1)
    profiles = sample_lines(signal, [curve, normal], distance_powers(-half, half))
    core = max(1, int(settings.level_half_width_widths * width / PROFILE_STEP_PX))
    level = profiles[:, half - core : half + core + 1] @ _mean_of(2 * core + 1)
    level = np.maximum(cv2.medianBlur(level[None], settings.level_median_sections)[0], 1.0)
    both = np.empty((2 * n, half + 1), np.float32)
    both[:n], both[n:] = profiles[:, half:], profiles[:, half::-1]
    out, found = find_edges(both, np.concatenate([level, level]), width, settings.edge)
    right, left = out[:n], out[n:]
    shift, across = (right - left) / 2, right + left
    seen = found[:n] & found[n:]
    trusted = seen & ~_too_wide(across, settings)
    if not trusted.all():
        shift, across = _fill(shift, trusted, 0.0), _fill(across, trusted, width)
    moved = _smooth(curve + normal * shift, sigma)
    return _Centred(moved, across, level, float(np.count_nonzero(seen) / n))


@cache
def _mean_of(size: int) -> Floats32:
    """Return the weights that average so many values: a product is faster than `mean`."""
    return np.full(size, 1 / size, np.float32)


def _upper_median(values: Floats32) -> float:
    """Return the upper median; NumPy's own takes five times as long for so few values."""
    return float(np.sort(values)[len(values) // 2])


def _too_wide(across: Floats, settings: RefineSettings) -> Mask:
    """Return which cross-sections, and their neighbours, have something lying against them.

    These are wider than the median of those about them.
    """
    odd = np.zeros(len(across), bool)
    most, beside = settings.most_width_over_neighbours, settings.neighbour_sections
    if across.max() <= most * np.sort(across)[len(across) // 2]:
        return odd
    around = np.pad(across, beside, "reflect")
    around = np.lib.stride_tricks.sliding_window_view(around, 2 * beside + 1)
    odd |= across > most * np.median(around, axis=1)
    wide = odd.copy()
    wide[1:] |= odd[:-1]
    wide[:-1] |= odd[1:]
    return wide


def _fill(values: Floats, found: Mask, default: float) -> Floats:
    """Replace what was not found by its neighbours along the body."""
    if not found.any():
        return np.full_like(values, default)
    x = np.arange(len(values))
    return np.asarray(np.interp(x, x[found], values[found]))
