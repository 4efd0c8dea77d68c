"""Carries a midline on by sliding the body along itself, and mends it where its edges are seen.

A worm follows its own path: its head leads, and the body comes after along the midline that it had
(crawling backwards, the tail leads). The last midline, continued at both ends with the curvature
that it has there, is therefore where the body lies a frame later, save for what it moves sideways.
That is measured at each cross-section that has an edge, and smoothed along the body; where the body
lies on itself or beside itself there is no edge, and the path alone tells. The two tips are looked
for along the path; one that cannot be seen follows from the other and from the length.
"""

from dataclasses import dataclass
from math import log

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

from worm_tracker.midline.contour_midline import (
    Complex,
    Floats,
    arc,
    as_complex,
    as_points,
    tangents,
)
from worm_tracker.midline.cross_sections import EDGE, CrossSections, cross_sections, sampled
from worm_tracker.midline.path import Trail, continued, evenly, nodes_for

AHEAD = 1.6
"""How far the path is continued beyond the way that the body slid last, in widths."""
NEAR_TIP = 1.5
"""How near to where the body ended it may end now, in widths."""
ROUNDS = 3
"""Times that cross-sections are measured; the path is mended in between."""
PATH_SD = 0.35
"""How far an unseen part may lie beside the path, in widths."""
TURN_SD, BEND_SD = 0.25, 0.5
"""How far a stretch of a width may turn (radians), and its direction bend (radians a width)."""
SMOOTH = 0.3
"""Scale below which the path's wiggles are noise, in widths."""
BEHIND = (0.2, 1.2)
"""From where to where behind a tip the body must have sides, in widths."""
SEEN_SIDES = 0.6
"""Part of those cross-sections with an edge from which on the tip is one."""
MOST_LENGTHENED = 0.05
"""Log of the length over that expected beyond which two tips are not those of one body."""
LEAST_LENGTH = 0.5
"""Part of the expected length that must be on the path."""
TIP_SEARCH_PX, TIP_STEP_PX = 4.0, 0.25


@dataclass(frozen=True, eq=False, slots=True)
class Slender:
    """What is known of a body that is slid.

    Attributes
    ----------
    widths : ndarray, shape (POINTS,)
        Along the body, in the trail's order.
    level : float
        Signal on the midline, grey levels.
    length : float
        Expected length, pixels.
    """

    widths: Floats
    level: float
    length: float

    @property
    def width(self) -> float:
        """The width of most of the body."""
        return float(np.median(self.widths))


@dataclass(frozen=True, eq=False, slots=True)
class _Path:
    """The last trail with `beyond` nodes more at either end; the body is thought to slide `way`."""

    curve: Complex
    step: float
    beyond: int
    way: float


def slide(signal: NDArray[np.uint8], trail: Trail, body: Slender, frames: int = 1) -> Trail | None:
    """Slide a body along itself into a picture.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    trail : Trail
        Where the body was, in the window's coordinates.
    body : Slender
        The body.
    frames : int
        How many frames ago that was, 1 for the next.

    Returns
    -------
    Trail or None
        None where too little of the body is on the path.
    """
    way, width = trail.forward * frames, body.width
    beyond = int((AHEAD * width + abs(way)) / trail.step) + 2
    path = _Path(continued(trail, beyond, width), trail.step, beyond, way)
    for turn in range(ROUNDS):
        seen = _measured(signal, path, trail, body)
        if turn < ROUNDS - 1:
            path = _mended(path, seen, width)
    return _cut(signal, path, seen, trail, body)


def _measured(signal: NDArray[np.uint8], path: _Path, trail: Trail, body: Slender) -> CrossSections:
    """Measure the cross-sections, each against the width that the body has there."""
    nodes = np.arange(len(path.curve)) - path.beyond
    part = (path.step * nodes + path.way) / trail.length
    half = np.interp(part, np.linspace(0, 1, len(body.widths)), body.widths) / 2
    ends = path.beyond + int(NEAR_TIP * body.width / path.step)
    return cross_sections(signal, path.curve, half, body.level, body.width, ends)


def _mended(path: _Path, seen: CrossSections, width: float) -> _Path:
    """Move a path to the middle of its cross-sections, smoothly, and even its steps.

    The shifts minimise their squared misfits, each over its variance, plus those of the priors: an
    unseen part stays on the path, and shifts neither turn nor bend it much.
    """
    share = path.step / width  # of a width, between two nodes
    turn = share / (TURN_SD * path.step) ** 2
    bend = share / (BEND_SD * path.step * share) ** 2
    banded = np.zeros((3, len(path.curve)))
    banded[2] = seen.weight * share + share / (PATH_SD * width) ** 2
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
    moved = path.curve + 1j * tangents(path.curve) * shift
    # Smoothed once, a curve would be pulled inwards; smoothed back by the same, it keeps its bends.
    sigma = SMOOTH * width / path.step
    once = _blurred(moved, sigma)
    curve = evenly(2 * once - _blurred(once, sigma), len(moved))
    step = float(arc(curve)[-1]) / (len(curve) - 1)
    return _Path(curve, step, path.beyond, path.way)


def _blurred(curve: Complex, sigma: float) -> Complex:
    """Smooth a curve along itself, its ends reflected oddly."""
    pad = min(int(3 * sigma) + 2, len(curve) - 1)
    low = 2 * curve[0] - curve[pad:0:-1]
    high = 2 * curve[-1] - curve[-2 : -pad - 2 : -1]
    padded = as_points(np.concatenate([low, curve, high]))
    blurred = cv2.GaussianBlur(padded, (1, 2 * pad + 1), sigma, sigmaY=sigma)
    return as_complex(np.asarray(blurred[pad:-pad], np.float64))


def _cut(
    signal: NDArray[np.uint8], path: _Path, seen: CrossSections, trail: Trail, body: Slender
) -> Trail | None:
    """Cut the path where the body ends."""
    total = float(arc(path.curve)[-1])
    first = _tip(signal, path.curve, path, seen, body)
    last = _tip(signal, path.curve[::-1], path, seen.turned, body)
    was_first, was_last = path.beyond * path.step, total - path.beyond * path.step
    start = first
    stop = None if last is None else total - last
    if (
        start is not None
        and stop is not None
        and abs(log(max(stop - start, 1.0) / body.length)) > MOST_LENGTHENED
    ):
        # One of both is the edge of another part: that which is farther from where it should be.
        off_first = abs(start - (was_first - path.way))
        off_last = abs(stop - (was_last - path.way))
        start, stop = (start, None) if off_first < off_last else (None, stop)
    if start is None:
        if stop is None:
            stop = was_last - path.way + 0.5 * (body.length - trail.length)
        start = _hidden(stop - body.length, path, seen, body)
    elif stop is None:
        stop = total - _hidden(total - start - body.length, path, seen.turned, body)
    start, stop = max(start, 0.0), min(stop, total)
    if stop - start < LEAST_LENGTH * body.length:
        return None
    curve = evenly(path.curve, nodes_for(stop - start, body.width), start, stop)
    return Trail(curve, 0.5 * ((was_first - start) + (was_last - stop)))


def _leaving(path: _Path, seen: CrossSections, body: Slender) -> float | None:
    """Return at which node, between nodes, the path leaves the object beyond the first end."""
    inside = path.beyond + round((0.8 * body.width + abs(path.way)) / path.step)
    edge = EDGE * body.level
    below = seen.spine[inside::-1] < edge
    if below[0] or not below.any():
        return None
    node = inside - int(below.argmax())
    high, low = float(seen.spine[node + 1]), float(seen.spine[node])
    return node + (edge - low) / max(high - low, 1e-6)


def _tip(
    signal: NDArray[np.uint8], curve: Complex, path: _Path, seen: CrossSections, body: Slender
) -> float | None:
    """Return the arc length at which the body's first end is seen; None where it is not.

    It is where the path leaves the object, if the body has sides before it. Without them that is
    the edge of a part that lies across.
    """
    node = _leaving(path, seen, body)
    if node is None:
        return None
    near, far = (int(node) + 1 + round(part * body.width / path.step) for part in BEHIND)
    sides = seen.seen[near:far]
    if not len(sides) or sides.mean() < SEEN_SIDES:
        return None
    return _sharper(signal, curve, node * path.step, EDGE * body.level)


def _hidden(at: float, path: _Path, seen: CrossSections, body: Slender) -> float:
    """Return the arc length of a first end that is not seen: where the length has it, but hidden.

    It cannot lie in the open, beyond the object.
    """
    node = _leaving(path, seen, body)
    return at if node is None else max(at, node * path.step)


def _sharper(signal: NDArray[np.uint8], curve: Complex, at: float, edge: float) -> float:
    """Return the arc length at which a path enters the body, sought near one found on its nodes."""
    s = arc(curve)
    k = min(max(int(np.searchsorted(s, at)), 4), len(curve) - 4)
    fine = np.arange(at - TIP_SEARCH_PX, at + TIP_SEARCH_PX, TIP_STEP_PX)
    line = CubicSpline(s[k - 4 : k + 4], curve[k - 4 : k + 4])(fine)
    beside = 1j * tangents(line)[:, None] * np.array([-0.5, 0.0, 0.5])
    along = sampled(signal, line[:, None] + beside).mean(axis=1)
    above = along >= edge
    if above[0] or not above[-1]:
        return at
    j = len(above) - int((~above[::-1]).argmax())
    low, high = float(along[j - 1]), float(along[j])
    return float(fine[j - 1]) + TIP_STEP_PX * (edge - low) / max(high - low, 1e-6)
