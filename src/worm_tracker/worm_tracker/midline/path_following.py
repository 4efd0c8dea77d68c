"""Propagates a midline by sliding the body along its path, corrected where its edges are seen.

A worm follows its own path: its head leads, and the body comes after along the midline that it had
(crawling backwards, the tail leads). The last midline, continued at both ends with the curvature
that it has there, is therefore where the body lies a frame later, save for what it moves sideways.
That is measured at each cross-section that has an edge, and smoothed along the body; where the body
lies on itself or beside itself there is no edge, and the path alone tells. The two tips are looked
for along the path; one that cannot be seen follows from the other and from the length.
"""

from dataclasses import dataclass, field
from math import log

import cv2
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

from worm_msgs_py.arrays import Complex, Floats, Picture
from worm_tracker.midline.cross_sections import (
    CrossSections,
    CrossSectionSettings,
    cross_sections,
    interpolate,
)
from worm_tracker.midline.curve import (
    as_complex,
    as_points,
    complex_arc_length,
    reflected_ends,
    tangents,
)
from worm_tracker.midline.path import (
    BodyPath,
    ContinuationSettings,
    continued,
    evenly,
    nodes_for,
)


@dataclass(frozen=True, slots=True)
class PathFollowingSettings:
    """How far a body slides along its path, how far it leaves it, and where it ends."""

    continued_beyond_slide_widths: float = 1.6
    """How far the path is continued beyond the way that the body slid last."""
    tip_zone_widths: float = 1.5
    """How near to where the body ended it may end now: its width is not known there."""
    measurements: int = 3
    """Times that cross-sections are measured; the path is corrected in between."""
    unseen_offset_sd_widths: float = 0.35
    """How far an unseen part may lie beside the path."""
    turn_sd_rad: float = 0.25
    """How far a stretch of a width may turn against the path."""
    bend_sd_rad_per_width: float = 0.5
    """How far its direction may bend against the path's within a width."""
    smoothing_widths: float = 0.3
    """Scale below which the path's wiggles are noise."""
    sides_near_tip_widths: float = 0.2
    sides_far_from_tip_widths: float = 1.2
    """From where to where behind a tip the body must have sides: an edge without them is another
    part's, that lies across."""
    least_part_with_sides: float = 0.6
    """Part of those cross-sections with an edge from which on the tip is one."""
    tip_start_inside_widths: float = 0.8
    """How far within the last end the search for where the path leaves the body begins."""
    most_log_length_over_expected: float = 0.05
    """Log of the length over that expected beyond which two tips are not those of one body."""
    least_length_over_expected: float = 0.5
    """Part of the expected length that must be on the path."""
    tip_search_px: float = 4.0
    tip_step_px: float = 0.25
    """How far about a tip found on the nodes, and how finely, its edge is sought."""
    continuation: ContinuationSettings = field(default_factory=ContinuationSettings)
    sections: CrossSectionSettings = field(default_factory=CrossSectionSettings)


@dataclass(frozen=True, eq=False, slots=True)
class ExpectedBody:
    """What a body that slides along its path is expected to be.

    Attributes
    ----------
    widths : ndarray, shape (TRACKED_POINTS,)
        Along the body, in the path's order.
    level : float
        Signal on the midline, grey levels.
    length : float
        Pixels.
    """

    widths: Floats
    level: float
    length: float

    @property
    def width(self) -> float:
        """The width of most of the body."""
        return float(np.median(self.widths))


@dataclass(frozen=True, eq=False, slots=True)
class _Extended:
    """The last path with `beyond` nodes more at either end; the body is thought to slide `way`."""

    curve: Complex
    step: float
    beyond: int
    way: float


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """The signal in a window, the body that is looked for in it, and how."""

    signal: Picture
    body: ExpectedBody
    settings: PathFollowingSettings


def slide_along_path(
    signal: Picture,
    path: BodyPath,
    body: ExpectedBody,
    frames: int,
    settings: PathFollowingSettings,
) -> BodyPath | None:
    """Slide a body along itself into a picture.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    path : BodyPath
        Where the body was, in the window's coordinates.
    body : ExpectedBody
    frames : int
        How many frames ago that was, 1 for the next.
    settings : PathFollowingSettings

    Returns
    -------
    BodyPath or None
        None where too little of the body is on the path.
    """
    way, width = path.forward * frames, body.width
    beyond = int((settings.continued_beyond_slide_widths * width + abs(way)) / path.step) + 2
    curve = continued(path, beyond, width, settings.continuation)
    view, extended = _View(signal, body, settings), _Extended(curve, path.step, beyond, way)
    seen = _measured(view, extended, path.length)
    for _ in range(settings.measurements - 1):
        extended = _corrected(extended, seen, width, settings)
        seen = _measured(view, extended, path.length)
    return _cut_at_tips(view, extended, seen, path.length)


def _measured(view: _View, extended: _Extended, length: float) -> CrossSections:
    """Measure the cross-sections, each against the width that the body has there."""
    body, settings = view.body, view.settings
    nodes = np.arange(len(extended.curve)) - extended.beyond
    part = (extended.step * nodes + extended.way) / length
    half = np.interp(part, np.linspace(0, 1, len(body.widths)), body.widths) / 2
    tip_nodes = extended.beyond + int(settings.tip_zone_widths * body.width / extended.step)
    return cross_sections(
        view.signal, extended.curve, half, body.level, body.width, tip_nodes, settings.sections
    )


def _corrected(
    extended: _Extended, seen: CrossSections, width: float, settings: PathFollowingSettings
) -> _Extended:
    """Move a path to the middle of its cross-sections, smoothly, and even its steps.

    The shifts minimise their squared misfits, each over its variance, plus those of the priors: an
    unseen part stays on the path, and shifts neither turn nor bend it much.
    """
    share = extended.step / width  # of a width, between two nodes
    turn = share / (settings.turn_sd_rad * extended.step) ** 2
    bend = share / (settings.bend_sd_rad_per_width * extended.step * share) ** 2
    banded = np.zeros((3, len(extended.curve)))
    banded[2] = seen.weight * share + share / (settings.unseen_offset_sd_widths * width) ** 2
    banded[2, 1:] += turn
    banded[2, :-1] += turn
    banded[1, 1:] -= turn
    banded[2, 2:] += bend
    banded[2, 1:-1] += 4 * bend
    banded[2, :-2] += bend
    banded[1, 1:-1] -= 2 * bend
    banded[1, 2:] -= 2 * bend
    banded[0, 2:] += bend
    shift = solveh_banded(banded, seen.weight * share * seen.shift)
    moved = extended.curve + 1j * tangents(extended.curve) * shift
    # Smoothed once, a curve would be pulled inwards; smoothed back by the same, it keeps its bends.
    sigma = settings.smoothing_widths * width / extended.step
    once = _smoothed(moved, sigma)
    curve = evenly(2 * once - _smoothed(once, sigma), len(moved))
    step = float(complex_arc_length(curve)[-1]) / (len(curve) - 1)
    return _Extended(curve, step, extended.beyond, extended.way)


def _smoothed(curve: Complex, sigma: float) -> Complex:
    """Smooth a curve along itself without pulling its ends in."""
    padded, pad = reflected_ends(curve, sigma)
    size = (1, 2 * pad + 1)
    blurred = cv2.GaussianBlur(as_points(padded), size, sigma, sigmaY=sigma)
    return as_complex(np.asarray(blurred[pad:-pad], np.float64))


def _cut_at_tips(
    view: _View, extended: _Extended, seen: CrossSections, last_length: float
) -> BodyPath | None:
    """Cut the path where the body ends."""
    body, settings = view.body, view.settings
    total = float(complex_arc_length(extended.curve)[-1])
    start = _tip(view, extended.curve, extended, seen)
    from_end = _tip(view, extended.curve[::-1], extended, seen.from_other_end)
    stop = None if from_end is None else total - from_end
    was_first, was_last = extended.beyond * extended.step, total - extended.beyond * extended.step
    if (
        start is not None
        and stop is not None
        and abs(log(max(stop - start, 1.0) / body.length)) > settings.most_log_length_over_expected
    ):
        # One of both is the edge of another part: that which is farther from where it should be.
        off_first = abs(start - (was_first - extended.way))
        off_last = abs(stop - (was_last - extended.way))
        start, stop = (start, None) if off_first < off_last else (None, stop)
    if start is None:
        if stop is None:
            stop = was_last - extended.way + 0.5 * (body.length - last_length)
        start = _unseen_tip(stop - body.length, view, extended, seen)
    elif stop is None:
        from_end = total - start - body.length
        stop = total - _unseen_tip(from_end, view, extended, seen.from_other_end)
    start, stop = max(start, 0.0), min(stop, total)
    if stop - start < settings.least_length_over_expected * body.length:
        return None
    curve = evenly(extended.curve, nodes_for(stop - start, body.width), start, stop)
    return BodyPath(curve, 0.5 * ((was_first - start) + (was_last - stop)))


def _leaving(view: _View, extended: _Extended, seen: CrossSections) -> float | None:
    """Return at which node, between nodes, the path leaves the object beyond the first end."""
    body, settings = view.body, view.settings
    inside = settings.tip_start_inside_widths * body.width + abs(extended.way)
    last = extended.beyond + round(inside / extended.step)
    edge = settings.sections.edge_over_body_level * body.level
    below = seen.spine[last::-1] < edge
    if below[0] or not below.any():
        return None
    node = last - int(below.argmax())
    high, low = float(seen.spine[node + 1]), float(seen.spine[node])
    return node + (edge - low) / max(high - low, 1e-6)


def _tip(view: _View, curve: Complex, extended: _Extended, seen: CrossSections) -> float | None:
    """Return the arc length at which the body's first end is seen; None where it is not.

    It is where the path leaves the object, if the body has sides before it. Without them that is
    the edge of a part that lies across.
    """
    node = _leaving(view, extended, seen)
    if node is None:
        return None
    settings = view.settings
    near, far = (
        int(node) + 1 + round(widths * view.body.width / extended.step)
        for widths in (settings.sides_near_tip_widths, settings.sides_far_from_tip_widths)
    )
    sides = seen.has_edge[near:far]
    if not len(sides) or sides.mean() < settings.least_part_with_sides:
        return None
    return _entry(view, curve, node * extended.step)


def _unseen_tip(at: float, view: _View, extended: _Extended, seen: CrossSections) -> float:
    """Return the arc length of a first end that is not seen: where the length has it, but occluded.

    It cannot lie in the open, beyond the object.
    """
    node = _leaving(view, extended, seen)
    return at if node is None else max(at, node * extended.step)


def _entry(view: _View, curve: Complex, at: float) -> float:
    """Return the arc length at which a path enters the body, sought near one found on its nodes."""
    settings = view.settings
    edge = settings.sections.edge_over_body_level * view.body.level
    reach, step = settings.tip_search_px, settings.tip_step_px
    s = complex_arc_length(curve)
    k = min(max(int(np.searchsorted(s, at)), 4), len(curve) - 4)
    fine = np.arange(at - reach, at + reach, step)
    line = CubicSpline(s[k - 4 : k + 4], curve[k - 4 : k + 4])(fine)
    beside = 1j * tangents(line)[:, None] * np.array([-0.5, 0.0, 0.5])
    along = interpolate(view.signal, line[:, None] + beside).mean(axis=1)
    above = along >= edge
    if above[0] or not above[-1]:
        return at
    j = len(above) - int((~above[::-1]).argmax())
    low, high = float(along[j - 1]), float(along[j])
    return float(fine[j - 1]) + step * (edge - low) / max(high - low, 1e-6)
