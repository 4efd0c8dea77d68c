"""From a first midline to one below a pixel: edges across and beyond the body.

The head tip (tail tip) is where the body ends on its axis: going out along the midline, the point
where the signal, which is the light that the body takes away, falls to half of its peak within the
end. The midline runs half-way between the two sides of the outline. A body is as wide as its
half-height edges are apart, which lie further in where its flanks are soft; its centroid is that of
the area between them.
"""

from dataclasses import dataclass, field, replace
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
    HalfHeightEdges,
    distance_powers,
    find_half_heights,
    find_outline,
    sample_lines,
)
from worm_tracker.midline.path import evenly, nodes_for
from worm_tracker.midline.sharp_bends import SharpBendSettings, bends_at_edges
from worm_tracker.midline.tips import TipSettings, with_tips

_CAP_AT = np.array([0.0, 0.05, 0.15, 0.35, 0.65])
_CAP = np.sqrt(1 - (1 - _CAP_AT) ** 2)
"""Widths of a round end at these parts of the way from the tip, relative."""
_LEVEL_MEDIAN_SECTIONS = 5
"""Cross-sections over which the body's level is steadied."""


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
    spine_half_width_widths: float = 0.1
    """The same where the body is narrower than it mostly is: the darker of both counts."""
    most_width_over_neighbours: float = 1.1
    """Width over the median of its neighbours from which a cross-section is not the worm's alone:
    a body tapers by less within that many sections."""
    neighbour_sections: int = 7
    """How many neighbours to either side that are."""
    sharp_edges_quantile: float = 0.8
    """Of the steepnesses of a body's edges, the one that is the lens's: bodies have soft edges."""
    least_width_times_steepness: float = 3.3
    """Width, times the slope of the edge over its height, from which a half-height width is right:
    4.2 standard deviations of the blur, of which such an edge has a slope of 0.8 over height."""
    line_over_area: float = 0.98
    """Half-height width times peak, over the area and the peak beside it, of what is narrower."""
    end_level_counts: float = 2.0
    """Times the level near a tip that the body's level counts there, at most: an end may be pale,
    or so thin that its level is low."""
    least_sharp_turn_rad: float = 0.8
    """Turn over a width from which on there may be a hairpin: most bodies need no closer look."""
    bend_measurements: int = 2
    """Times that hairpins are moved to their outer edges: the cross-sections cut them short."""
    bends: SharpBendSettings = field(default_factory=SharpBendSettings)
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
        Of the outline; NaN-free, zero at the tips.
    half_height_widths : ndarray, shape (TRACKED_POINTS,)
        The same of the half-height edges.
    levels : ndarray, shape (TRACKED_POINTS,)
        Signal on the midline; towards a tip that of the last cross-section.
    level : float
        Median signal on the midline.
    edges_found : float
        Fraction of the cross-sections in which both edges were found.
    area : float
        Within the outline.
    u, v : float
        Centroid of the area between the half-height edges.
    """

    points: Floats
    widths: Floats
    half_height_widths: Floats
    levels: Floats
    level: float
    edges_found: float
    area: float
    u: float
    v: float

    @property
    def width(self) -> float:
        """Mean distance of the half-height edges over the middle half of the body, pixels."""
        quarter = len(self.half_height_widths) // 4
        return float(self.half_height_widths[quarter:-quarter].mean())

    def reversed(self) -> "RefinedMidline":
        """Return the midline the other way round."""
        return replace(
            self,
            points=self.points[::-1],
            widths=self.widths[::-1],
            half_height_widths=self.half_height_widths[::-1],
            levels=self.levels[::-1],
        )


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
    nodes = (length := float(s[-1])) / (settings.section_spacing_widths * width)
    nodes = int(min(max(nodes, settings.fewest_sections), settings.most_sections))
    sigma = settings.smoothing_widths * width * (nodes - 1) / max(length, 1e-6)
    # The tips are found from within: the ends of a first midline are least to be trusted.
    margin = min(settings.start_before_tip_widths * width, 0.2 * length)
    curve = np.interp(margin + (length - 2 * margin) * unit_grid(nodes), s, curve)
    body = _centre(signal, _smooth(curve, sigma), width, 0.6 * sigma, settings)
    level = _upper_median(body.level)
    near_ends = np.minimum(level, settings.end_level_counts * body.level[[0, -1]])
    whole = with_tips(signal, body.curve, near_ends, width, settings.tips)
    s_whole = complex_arc_length(whole)
    s, across, half_height = _widths_to_tips(whole, s_whole, body)
    begins = 1 if whole[0] != body.curve[0] else 0
    centre = _centroid(np.interp(s, s_whole, whole), s, half_height)
    grid = s_whole[-1] * unit_grid(TRACKED_POINTS)
    line = _hairpins_extended(signal, whole, level, width, settings) + complex(*origin)
    return RefinedMidline(
        points=as_points(line),
        widths=np.interp(grid, s, across),
        half_height_widths=np.interp(grid, s, half_height),
        levels=np.interp(grid, s_whole[begins : begins + len(body.level)], body.level),
        level=level,
        edges_found=body.edges_found,
        area=float((across[1:] + across[:-1]) @ (s[1:] - s[:-1])) / 2,
        u=centre.real + origin[0],
        v=centre.imag + origin[1],
    )


def _hairpins_extended(
    signal: Picture, curve: Complex, level: float, width: float, settings: RefineSettings
) -> Complex:
    """Return the points of a midline whose hairpins reach to their outer edges."""
    s = complex_arc_length(curve)
    grid = s[-1] * unit_grid(TRACKED_POINTS)
    line = np.asarray(np.interp(grid, s, curve), np.complex128)
    turn = np.angle(np.diff(curve)[1:] * np.diff(curve)[:-1].conj())
    sections = max(1, round(width * len(curve) / s[-1]))
    if np.abs(np.convolve(turn, np.ones(sections), "same")).max() < settings.least_sharp_turn_rad:
        return line
    nodes = nodes_for(float(s[-1]), width)
    fine = first = evenly(curve, nodes)
    half, levels = np.full(nodes, width / 2), np.full(nodes, level)
    for _ in range(settings.bend_measurements):
        step = float(complex_arc_length(fine)[-1]) / (nodes - 1)
        fine = bends_at_edges(signal, fine, half, levels, width, step, settings.bends)
    return line if fine is first else evenly(fine, TRACKED_POINTS)


def _centroid(curve: Complex, s: Floats, widths: Floats) -> complex:
    """Return the centroid of the area that a body of some widths covers.

    Where the body bends, more of its area lies on the outer side: a cross-section of width w has
    its centroid κ w²/12 outwards of the midline, which sums up to w³/12 times the tangent's change.
    """
    step = s[1:] - s[:-1]
    weight = np.zeros(len(s))  # of each cross-section, by the trapezoidal rule
    weight[1:] = step
    weight[:-1] += step
    weight *= widths / 2
    d = curve[1:] - curve[:-1]
    d /= np.maximum(step, 1e-9)
    outwards = -(widths[1:-1] ** 3 * (d[1:] - d[:-1])).sum() / 12
    return complex(((weight * curve).sum() + outwards) / max(float(weight.sum()), 1e-9))


def _widths_to_tips(
    whole: Complex, s_whole: Floats, body: "_Centred"
) -> tuple[Floats, Floats, Floats]:
    """Return arc lengths from tip to tip and both widths there; the ends are round."""
    length, curve = float(s_whole[-1]), body.curve
    first_gap = abs(curve[0] - whole[0])
    last_gap = abs(curve[-1] - whole[-1])
    at = s_whole[1:] if first_gap > 0 else s_whole
    at = at[: len(curve)]
    first, last = _CAP_AT * first_gap, length - _CAP_AT[::-1] * last_gap
    outline, half_height = (
        np.concatenate([_CAP * widths[0], widths, _CAP[::-1] * widths[-1]])
        for widths in (body.outline, body.widths)
    )
    return np.concatenate([first, at, last]), outline, half_height


def _smooth(curve: Complex, sigma: float) -> Complex:
    """Smooth a curve along itself, if there is anything to smooth."""
    return curve if sigma < 0.3 else smooth_open_curve(curve, sigma)


class _Centred(NamedTuple):
    """A curve moved to the middle between its edges; widths, levels, fraction of edges seen."""

    curve: Complex
    outline: Floats
    widths: Floats
    level: Floats32
    edges_found: float


def _centre(
    signal: Picture, curve: Complex, width: float, sigma: float, settings: RefineSettings
) -> _Centred:
    """Move a curve to the middle between the outline's sides."""
    n = len(curve)
    normal = 1j * tangents(curve)
    half = max(4, int(settings.edge_reach_widths * width / PROFILE_STEP_PX) + 1)
    profiles = sample_lines(signal, [curve, normal], distance_powers(-half, half))
    level = _level(profiles, settings.level_half_width_widths * width)
    both = np.empty((2 * n, half + 1), np.float32)
    both[:n], both[n:] = profiles[:, half:], profiles[:, half::-1]
    out, found = find_outline(both, np.concatenate([level, level]), width, settings.edge)
    right, left = out[:n], out[n:]
    shift, across = (right - left) / 2, right + left
    seen = found[:n] & found[n:]
    trusted = seen & ~_too_wide(across, settings)
    if not trusted.all():
        shift, across = _fill(shift, trusted, 0.0), _fill(across, trusted, width)
    moved = _smooth(curve + normal * shift, sigma)
    darker = np.maximum(level, _level(profiles, settings.spine_half_width_widths * width))
    edges = find_half_heights(both, np.concatenate([darker, darker]), np.inf, settings.edge)
    trusted &= edges.found[:n] & edges.found[n:]
    widths = edges.distances[:n] + edges.distances[n:]
    if not trusted.all():
        widths = np.minimum(_fill(widths, trusted, width), across)
    widths = _without_blur(widths, edges, settings)
    return _Centred(moved, across, widths, level, float(np.count_nonzero(seen) / n))


def _level(profiles: Floats32, reach: float) -> Floats32:
    """Return the mean signal within a reach of each profile's middle, steadied along the body."""
    half = profiles.shape[1] // 2
    core = max(1, int(reach / PROFILE_STEP_PX))
    level = profiles[:, half - core : half + core + 1] @ _mean_of(2 * core + 1)
    steady = cv2.medianBlur(level[None], _LEVEL_MEDIAN_SECTIONS)[0]
    return np.asarray(np.maximum(steady, 1.0), np.float32)


def _without_blur(across: Floats, edges: HalfHeightEdges, settings: RefineSettings) -> Floats:
    """Return the widths of a body whose ends are narrower than what the lens makes of a line.

    There the half-height edges stay apart however narrow the body is, but its peak falls: what is
    as dark as the body beside it has the area under its profile, nearly height times width.
    """
    if not edges.found.any():
        return across
    steepest = np.sort((edges.slopes / edges.heights)[edges.found])
    sharp = steepest[int(settings.sharp_edges_quantile * (len(steepest) - 1))]
    wide = np.flatnonzero(across * sharp > settings.least_width_times_steepness)
    if not len(wide) or len(wide) == len(across):
        return across
    n, beside = len(across), _LEVEL_MEDIAN_SECTIONS
    heights = (edges.heights[:n] + edges.heights[n:]) / 2
    across = across.copy()
    for end, inside in (
        (slice(0, wide[0]), slice(wide[0], wide[0] + beside)),
        (slice(wide[-1] + 1, n), slice(max(wide[-1] + 1 - beside, 0), wide[-1] + 1)),
    ):
        height = settings.line_over_area * np.median(heights[inside])
        across[end] *= np.minimum(heights[end] / height, 1.0)
    return across


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
