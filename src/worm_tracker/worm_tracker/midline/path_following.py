"""Propagates a midline by sliding the body along its path, corrected where its edges are seen.

A worm follows its own path: its head leads, and the body comes after along the midline that it had
(crawling backwards, the tail leads). The last midline, continued at both ends with the curvature
that it has there, is therefore where the body lies a frame later, save for what it moves sideways.
That is measured at each cross-section that has an edge, and smoothed along the body; where the body
lies on itself or beside itself there is no edge, and the path alone tells. The two tips are looked
for along the path; one that cannot be seen follows from the other and from the length.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.body_ends import BodyEnd, BodyEndsSettings, find_ends
from worm_tracker.midline.cross_sections import (
    Covers,
    CrossSections,
    CrossSectionSettings,
    cross_sections,
    interpolate,
)
from worm_tracker.midline.curve import (
    complex_arc_length,
    cubic_through,
    tangents,
    turn_about,
    unit_grid,
)
from worm_tracker.midline.end_marks import EndMarksSettings
from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.node_odds import ExpectedAtNodes, end_log_odds, node_log_odds
from worm_tracker.midline.path import (
    BodyPath,
    ContinuationSettings,
    continued,
    evenly,
    nodes_for,
)
from worm_tracker.midline.path_shift import PathShiftSettings, moved_to_middle
from worm_tracker.midline.self_cover import (
    SelfCoverSettings,
    lies_near_itself,
    parts_over,
)
from worm_tracker.midline.sharp_bends import SharpBendSettings, bends_at_edges


@dataclass(frozen=True, slots=True)
class PathFollowingSettings:
    """How far a body slides along its path, how far it leaves it, and where it ends."""

    continued_beyond_slide_widths: float = 1.6
    """How far the path is continued beyond the way that the body slid last."""
    tip_zone_widths: float = 1.5
    """How near to where the body ended it may end now: its width is not known there."""
    measurements: int = 3
    """Times that cross-sections are measured; the path is corrected in between."""
    least_length_over_expected: float = 0.5
    """Part of the expected length that must be on the path."""
    tip_search_px: float = 4.0
    tip_step_px: float = 0.25
    """How far about a tip found on the nodes, and how finely, its edge is sought."""
    bend_half_stretch_widths: float = 1.25
    sharpest_turn_with_inner_edge_rad: float = 1.9
    """Turn over that much to either side beyond which the body lies on itself within the bend."""
    edge_blur_px: float = 1.5
    """How far from an edge the picture is neither body nor water."""
    cover: SelfCoverSettings = field(default_factory=SelfCoverSettings)
    ends: BodyEndsSettings = field(default_factory=BodyEndsSettings)
    marks: EndMarksSettings = field(default_factory=EndMarksSettings)
    continuation: ContinuationSettings = field(default_factory=ContinuationSettings)
    bends: SharpBendSettings = field(default_factory=SharpBendSettings)
    sections: CrossSectionSettings = field(default_factory=CrossSectionSettings)
    shift: PathShiftSettings = field(default_factory=PathShiftSettings)


@dataclass(frozen=True, eq=False, slots=True)
class SlidBody:
    """A body slid along its path.

    Attributes
    ----------
    path : BodyPath
    ends : tuple of BodyEnd
        Where on the continued path it ends, and how surely.
    """

    path: BodyPath
    ends: tuple[BodyEnd, BodyEnd]


@dataclass(frozen=True, eq=False, slots=True)
class _Extended:
    """The last path with `beyond` nodes more at either end; its ends are thought to go `ways`."""

    curve: Complex
    step: float
    beyond: int
    ways: tuple[float, float]


@dataclass(frozen=True, eq=False, slots=True)
class _Along:
    """What the body is expected to be at each node of an extended path."""

    half: Floats
    level: Floats
    covers: Covers


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """The signal in a window, the body that is looked for in it, and how."""

    signal: Picture
    body: ExpectedBody
    settings: PathFollowingSettings


def slide_along_path(
    signal: Picture,
    path: BodyPath,
    end_sd: tuple[float, float],
    body: ExpectedBody,
    frames: int,
    settings: PathFollowingSettings,
) -> SlidBody | None:
    """Slide a body along itself into a picture.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    path : BodyPath
        Where the body was, in the window's coordinates.
    end_sd : tuple of float
        How surely its ends were there, pixels.
    body : ExpectedBody
    frames : int
        How many frames ago that was, 1 for the next.
    settings : PathFollowingSettings

    Returns
    -------
    SlidBody or None
        None where too little of the body is on the path.
    """
    ways, width = (path.ways[0] * frames, path.ways[1] * frames), body.width
    most = max(abs(ways[0]) + 2 * end_sd[0], abs(ways[1]) + 2 * end_sd[1])
    beyond = int((settings.continued_beyond_slide_widths * width + most) / path.step) + 2
    curve = continued(path, beyond, width, settings.continuation)
    view, extended = _View(signal, body, settings), _Extended(curve, path.step, beyond, ways)
    along = _expected_body(view, extended)
    seen = _measured(view, extended, along)
    for k in range(settings.measurements - 1):
        extended = _bends_moved(view, _in_middle(extended, seen, width, settings), along)
        if k == 0 or k == settings.measurements - 2:
            along = _expected_body(view, extended)
        seen = _measured(view, extended, along)
    return _cut_at_ends(view, extended, along, seen, end_sd, frames)


def _expected_body(view: _View, extended: _Extended) -> _Along:
    """Return what the body is expected to be along a path, and where it covers itself."""
    body, settings = view.body, view.settings
    n, curve, step = len(extended.curve), extended.curve, extended.step
    first = extended.beyond - extended.ways[0] / step
    last = n - 1 - extended.beyond - extended.ways[1] / step
    part = (np.arange(n) - first) / max(last - first, 1.0)
    grid = unit_grid(len(body.widths))
    half = np.interp(part, grid, body.widths) / 2
    level = np.interp(part, grid, body.levels)
    if not lies_near_itself(curve, body.width, step):
        return _Along(half, level, Covers.none(n))
    blur, at = settings.edge_blur_px, np.empty((n, 6), np.complex128)
    _fill_beside(curve, 1j * tangents(curve), half, blur, at)
    margins = blur * np.array([-2.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    extent = slice(max(round(first), 0), max(round(last), 0) + 1)
    over = parts_over(at, curve, half, extent, step, margins, settings.cover)
    covered = over > 0
    inside, outside = covered[:, 2::2], covered[:, 3::2]  # on the left and on the right
    _fill_within_bend(curve, body.width, step, settings, outside)
    covers = Covers(
        layers=over[:, 0],
        either=covered[:, 1],
        inside=inside,
        outside=outside,
        level=body.level,
        level_sd=body.level_sd,
        darkening=body.darkening,
    )
    return _Along(half, level, covers)


@compiled_for(
    array_read(types.complex128),
    array_read(types.complex128),
    array_read(types.float64),
    types.float64,
    array_written(types.complex128, 2),
)
def _fill_beside(curve: Complex, normal: Complex, half: Floats, blur: float, at: Complex) -> None:
    """Fill in, for each node, itself twice, and points within and beyond its left and right edge.

    These are a blur off the edge.
    """
    for k in range(len(curve)):
        within, beyond = normal[k] * (half[k] - blur), normal[k] * (half[k] + blur)
        at[k, 0] = at[k, 1] = curve[k]
        at[k, 2], at[k, 3] = curve[k] - within, curve[k] - beyond
        at[k, 4], at[k, 5] = curve[k] + within, curve[k] + beyond


def _fill_within_bend(
    curve: Complex, width: float, step: float, settings: PathFollowingSettings, unseen: Mask
) -> None:
    """Note on which side, left or right, a bend is so tight that its inner edge is not seen."""
    over = max(1, round(settings.bend_half_stretch_widths * width / step))
    turn = turn_about(curve, over)
    most = settings.sharpest_turn_with_inner_edge_rad
    unseen[:, 0] |= turn < -most
    unseen[:, 1] |= turn > most


def _measured(view: _View, extended: _Extended, along: _Along) -> CrossSections:
    """Measure the cross-sections, each against the width that the body has there."""
    body, settings = view.body, view.settings
    tip_nodes = extended.beyond + int(settings.tip_zone_widths * body.width / extended.step)
    return cross_sections(
        view.signal,
        extended.curve,
        along.half,
        along.level,
        body.width,
        tip_nodes,
        along.covers,
        settings.sections,
    )


def _in_middle(
    extended: _Extended, seen: CrossSections, width: float, settings: PathFollowingSettings
) -> _Extended:
    """Move a path to the middle of its cross-sections."""
    curve = moved_to_middle(extended.curve, extended.step, seen, width, settings.shift)
    step = float(complex_arc_length(curve)[-1]) / (len(curve) - 1)
    return _Extended(curve, step, extended.beyond, extended.ways)


def _bends_moved(view: _View, extended: _Extended, along: _Along) -> _Extended:
    """Move a path's sharp bends to where the picture ends beyond them."""
    curve = bends_at_edges(
        view.signal,
        extended.curve,
        along.half,
        along.level,
        view.body.width,
        extended.step,
        view.settings.bends,
    )
    if curve is extended.curve:
        return extended
    step = float(complex_arc_length(curve)[-1]) / (len(curve) - 1)
    return replace(extended, curve=curve, step=step)


def _cut_at_ends(
    view: _View,
    extended: _Extended,
    along: _Along,
    seen: CrossSections,
    end_sd: tuple[float, float],
    frames: int,
) -> SlidBody | None:
    """Cut the path where the body ends."""
    body, settings, step = view.body, view.settings, extended.step
    curve = extended.curve
    total = step * (len(curve) - 1)
    was = BodyEnd(extended.beyond * step, end_sd[0])
    last = was, BodyEnd(total - was.at, end_sd[1])
    expected = last[0].at - extended.ways[0], last[1].at - extended.ways[1]
    at_nodes = ExpectedAtNodes(along.level, along.covers, expected, step)
    odds = node_log_odds(seen.spine, at_nodes, settings.ends.level_sd_relative)
    most = settings.ends.most_log_odds_per_width * step / body.width
    of_ends = end_log_odds(seen.spine, curve, at_nodes, odds, body, most, settings.marks)
    length = body.length, body.length_sd
    ends = find_ends(odds, step, body.width, expected, last, length, frames, settings.ends, of_ends)
    start = _sharpened(view, curve, along, ends[0].at, total)
    stop = total - _sharpened(view, curve[::-1], along, total - ends[1].at, total, turned=True)
    if stop - start < settings.least_length_over_expected * body.length:
        return None
    cut = evenly(curve, nodes_for(stop - start, body.width), max(start, 0.0), min(stop, total))
    ways = (last[0].at - start) / frames, (last[1].at - stop) / frames
    return SlidBody(BodyPath(cut, ways), ends)


def _sharpened(
    view: _View, curve: Complex, along: _Along, at: float, total: float, turned: bool = False
) -> float:
    """Return the arc length of a path's first end below a pixel, where it is in clear water."""
    n = len(curve)
    k = min(max(round(at / total * (n - 1)), 0), n - 1)
    k = n - 1 - k if turned else k
    return at if along.covers.either[k] else _entry_into_body(view, curve, at, along.level[k])


def _entry_into_body(view: _View, curve: Complex, at: float, level: float) -> float:
    """Return the arc length at which a path enters the body, sought near one found on its nodes."""
    settings = view.settings
    edge = settings.sections.edge_over_body_level * level
    reach, step = settings.tip_search_px, settings.tip_step_px
    s = complex_arc_length(curve)
    k = min(max(int(np.searchsorted(s, at)), 4), len(curve) - 4)
    fine = np.arange(at - reach, at + reach, step)
    line = cubic_through(s[k - 4 : k + 4], curve[k - 4 : k + 4], fine)
    beside = 1j * tangents(line)[:, None] * np.array([-0.5, 0.0, 0.5])
    along = interpolate(view.signal, line[:, None] + beside).mean(axis=1)
    above = along >= edge
    if above[0] or not above[-1]:
        return at
    j = len(above) - int((~above[::-1]).argmax())
    low, high = float(along[j - 1]), float(along[j])
    return float(fine[j - 1]) + step * (edge - low) / max(high - low, 1e-6)
