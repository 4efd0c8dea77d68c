"""From a contour to a first midline: the two ends, the two sides, and what lies between them."""

from dataclasses import dataclass
from math import inf, log
from typing import NamedTuple

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.body_model import end_displacement
from worm_tracker.midline.curve import (
    TRACKED_POINTS,
    as_complex,
    as_points,
    complex_arc_length,
    smooth_padded,
)

_SIDE = np.linspace(0.0, 1.0, TRACKED_POINTS)
_FINE = np.linspace(0.0, 1.0, 4 * TRACKED_POINTS - 3)


@dataclass(frozen=True, slots=True)
class ContourMidlineSettings:
    """How the two ends of a contour are told from its bends."""

    steps_per_width: int = 7
    """Points of the smoothed contour in a width: enough for a round end, few enough to be fast."""
    smoothing_widths: float = 0.12
    """Scale below which the contour's pixel stairs are smoothed away, in widths."""
    most_end_candidates: int = 6
    """Sharpest turns that are compared as ends: two ends and a few sharp bends."""
    least_end_turn_rad: float = 0.6
    """Convex turn over two widths from which a point is a candidate: an end turns by about π."""
    most_end_turn_rad: float = 2.6
    """Turn beyond which an end is not taken for sharper: a thin tail turns by more than π."""
    unequal_sides_cost: float = 4.0
    """What the log ratio of the two sides' lengths costs, in radians of an end's turn."""
    displacement_cost_per_width: float = 0.15
    """What a width between the ends and the last ones costs, in radians of an end's turn."""
    most_displacement_widths: float = 12.0
    """Displacement beyond which it costs no more: the worm was lost, or mistaken."""
    least_slant_over_width: float = 1.75
    """From how long a line between the two sides on it does not cross the body squarely."""
    least_depth_widths: float = 0.25
    """How far within the contour the middle of such a line must be: what is nearer the edge is put
    right by no cross-section. In open bodies it was up to half a width off the middle."""
    most_lead_widths: float = 0.1
    """By how much one end of such a line may be ahead of the other."""
    most_step_widths: float = 0.5
    most_steps: int = 12
    """How far they are moved at once, and how often."""
    least_width_over_thickness: float = 0.7
    """What is thinner than so much of its object's thickest part touches itself there, or tapers
    much: by that part its inner edges are smoothed away."""


@dataclass(frozen=True, eq=False, slots=True)
class ContourMidline:
    """A midline to within a pixel or two.

    Attributes
    ----------
    points : ndarray, shape (TRACKED_POINTS, 2)
        (u, v); which end comes first means nothing.
    width : float
        Area over length, pixels.
    side_difference : float
        Difference of the sides' lengths, less what the bend of the body explains, over its length.
    """

    points: Floats
    width: float
    side_difference: float


def contour_midline(
    contour: NDArray[np.int32],
    width: float,
    last: Floats | None,
    settings: ContourMidlineSettings,
) -> ContourMidline | None:
    """Find the midline of a body that does not touch itself.

    Parameters
    ----------
    contour : ndarray, shape (n, 2)
        Its pixels in order.
    width : float
        The body's expected width, pixels.
    last : ndarray, shape (TRACKED_POINTS, 2), or None
        The last midline: of several candidates for the ends those near its ends are preferred.
    settings : ContourMidlineSettings

    Returns
    -------
    ContourMidline or None
        None where the contour has no two ends.

    Notes
    -----
    Over a stretch of two widths an end turns the contour by about π, a bend of the body by far
    less. The pair of turns is taken that makes both sides equally long, near the last ends.
    """
    loop, spacing = _smooth_loop(contour, width, settings)
    n = len(loop)
    step = max(2, round(width / spacing))
    if n < 4 * step:
        return None
    oriented = cv2.contourArea(contour, oriented=True)
    turn, ends = _end_candidates(loop, step, 1.0 if oriented > 0 else -1.0, settings)
    best = _best_pair(loop, turn, ends, width, last, settings)
    if best is None:
        return None
    i, j = best
    points = _between_sides(loop, i, j, width, spacing, settings)
    # The contour runs through the centres of edge pixels: half a pixel is missing all round.
    area = abs(oriented) + len(contour) / 2
    length = max(float(np.abs(points[1:] - points[:-1]).sum()), 1.0)
    difference = abs(n - 2 * (j - i)) * spacing
    return ContourMidline(
        points=as_points(points),
        width=area / length,
        side_difference=abs(difference - area / length * abs(_bend(points))) / length,
    )


def first_contour_midline(
    contour: NDArray[np.int32],
    thickness: float,
    last: Floats | None,
    settings: ContourMidlineSettings,
) -> ContourMidline | None:
    """Find the midline of a body whose width is not known, by its object's thickness.

    See `contour_midline`. Where it turns out to be far thinner it is sought again by its own width,
    between the same ends.
    """
    found = contour_midline(contour, thickness, last, settings)
    if found is None or found.width > settings.least_width_over_thickness * thickness:
        return found
    anew = contour_midline(contour, found.width, found.points, settings)
    if anew is None:
        return found
    return anew if end_displacement(anew.points, found.points) < thickness else found


def ends_of_contour(
    contour: NDArray[np.int32], width: float, settings: ContourMidlineSettings, *, is_hole: bool
) -> list[tuple[complex, complex]]:
    """Return where the ends of a body may be on a contour, the sharpest first.

    Parameters
    ----------
    contour : ndarray, shape (n, 2)
        Its pixels in order.
    width : float
        The body's, pixels.
    settings : ContourMidlineSettings
    is_hole : bool
        Whether it is that of a hole in the body, into which an end may reach.

    Returns
    -------
    list of (complex, complex)
        Each tip, u + iv, and the direction from it into the body, of length 1.
    """
    loop, spacing = _smooth_loop(contour, width, settings)
    step = max(2, round(width / spacing))
    if len(loop) < 4 * step:
        return []
    outwards = (cv2.contourArea(contour, oriented=True) > 0) != is_hole
    _, ends = _end_candidates(loop, step, 1.0 if outwards else -1.0, settings)
    inwards = loop.take(ends - step, mode="wrap") + loop.take(ends + step, mode="wrap")
    inwards = inwards / 2 - loop[ends]
    inwards /= np.maximum(np.abs(inwards), 1e-9)
    return list(zip(loop[ends].tolist(), inwards.tolist(), strict=True))


def _between_sides(
    loop: Complex, i: int, j: int, width: float, spacing: float, settings: ContourMidlineSettings
) -> Complex:
    """Return the curve half-way between a loop's two sides, from its point i to its point j."""
    n = len(loop)
    # The loop's points are at equal steps: half of these go one way round, half the other.
    at = np.concatenate([i + (j - i) * _SIDE, i + n - (i + n - j) * _SIDE])
    first = _middle(_on_loop(loop, at))
    if not _leaves_body(first, loop, width, settings):
        return first.points
    # Around the tip of a hairpin the sides are far apart from one pair of points to the next.
    sides = np.split(_opposite(loop, at, width, spacing, settings), 2)
    finely = np.concatenate([np.interp(_FINE, _SIDE, side) for side in sides])
    opposite = _middle(_on_loop(loop, finely))
    s = complex_arc_length(opposite.points)
    return np.asarray(np.interp(s[-1] * _SIDE, s, opposite.points))


class _Middle(NamedTuple):
    """The points half-way between two sides, and how far the sides are apart there."""

    points: Complex
    apart: Floats


def _middle(sides: Complex) -> _Middle:
    one, other = np.split(sides, 2)
    return _Middle(np.asarray((one + other) / 2), np.abs(one - other))


def _leaves_body(
    middle: _Middle, loop: Complex, width: float, settings: ContourMidlineSettings
) -> bool:
    """Tell whether points between the sides come near the edge, where their lines are slanted."""
    slanted = middle.points[middle.apart > settings.least_slant_over_width * width]
    if not len(slanted):  # nearly always
        return False
    outline = as_points(loop).astype(np.float32)
    depth = min(cv2.pointPolygonTest(outline, (p.real, p.imag), True) for p in slanted.tolist())
    return depth < settings.least_depth_widths * width


def _opposite(
    loop: Complex, at: Floats, width: float, spacing: float, settings: ContourMidlineSettings
) -> Floats:
    """Return where on the two sides of a loop points lie opposite each other.

    Past a bend the outer side is the longer one, by the width times the turn: what is as far along
    it lags behind. Each pair is moved along both sides until the line between them is square to
    these.
    """
    at, bounds = at.copy(), at[[0, TRACKED_POINTS - 1, TRACKED_POINTS, -1]]
    one, other = at[:TRACKED_POINTS], at[TRACKED_POINTS:]
    for _ in range(settings.most_steps):
        here, ahead, behind = (_on_loop(loop, at + shift) for shift in (0.0, 0.5, -0.5))
        along = ahead - behind
        along = along[:TRACKED_POINTS] - along[TRACKED_POINTS:]  # the other side runs back
        along /= np.maximum(np.abs(along), 1e-9)
        across = here[:TRACKED_POINTS] - here[TRACKED_POINTS:]
        lead = (across * along.conj()).real
        if np.abs(lead[1:-1]).max() < settings.most_lead_widths * width:
            break
        most = settings.most_step_widths * width
        moved = np.clip(lead / 2, -most, most) / spacing
        one -= moved
        other -= moved
        np.maximum.accumulate(np.clip(one, bounds[0], bounds[1], out=one), out=one)
        np.minimum.accumulate(np.clip(other, bounds[3], bounds[2], out=other), out=other)
        one[[0, -1]], other[[0, -1]] = bounds[:2], bounds[2:]
    return at


def _on_loop(loop: Complex, at: Floats) -> Complex:
    """Return a closed curve between its points."""
    points = np.empty(len(at), np.complex128)
    _fill_on_loop(loop, at, points)
    return points


@compiled_for(
    array_read(types.complex128), array_read(types.float64), array_written(types.complex128)
)
def _fill_on_loop(loop: Complex, at: Floats, points: Complex) -> None:
    """Fill in the places of a closed curve at so many of its points from the first one."""
    for j in range(len(at)):
        k = int(np.floor(at[j]))
        part = at[j] - k
        points[j] = (1 - part) * loop[k % len(loop)] + part * loop[(k + 1) % len(loop)]


def _bend(points: Complex) -> float:
    """Return the angle by which a curve turns from end to end, its very ends left out."""
    thin = points[4:-4:4]
    d = thin[1:] - thin[:-1]
    return float(np.angle(d[1:] * d[:-1].conj()).sum())


def _smooth_loop(
    contour: NDArray[np.int32], width: float, settings: ContourMidlineSettings
) -> tuple[Complex, float]:
    """Return the contour at equal steps, its pixel stairs smoothed away, and the step."""
    fine = max(1.0, width / settings.steps_per_width)
    closed = as_complex(np.concatenate([contour[:: int(fine)], contour[:1]]).astype(np.float64))
    s = complex_arc_length(closed)
    length = float(s[-1])
    count = max(16, round(length / fine))
    spacing = length / count
    sigma = max(settings.smoothing_widths * width / spacing, 0.8)
    pad = min(int(3 * sigma) + 2, count)
    at = spacing * np.arange(-pad, count + pad)
    at[:pad] += length
    at[count + pad :] -= length
    return smooth_padded(np.interp(at, s, closed), sigma, pad), spacing


def _end_candidates(
    loop: Complex, step: int, sign: float, settings: ContourMidlineSettings
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the contour's convex turn at each point, and its sharpest turns a width apart.

    The turn is that over a stretch of `step` points to either side.
    """
    n = len(loop)
    pad = 2 * step
    around = np.concatenate([loop[n - pad :], loop, loop[:pad]])
    chord = around[step:] - around[:-step]
    turned = chord[step:] * chord[:-step].conj()
    signed = np.arctan2(sign * turned.imag, turned.real).astype(np.float32)
    # Past a half turn (a thin tail) the angle wraps: a sharp end is convex, never concave.
    signed[signed < -settings.most_end_turn_rad] += 2 * np.pi
    top = cv2.dilate(signed[None], np.ones((1, 2 * step + 1), np.uint8))[0]
    turn = signed[step : step + n]
    peaks = np.flatnonzero((turn == top[step : step + n]) & (turn > settings.least_end_turn_rad))
    return turn, peaks[np.argsort(-turn[peaks], kind="stable")][: settings.most_end_candidates]


def _best_pair(
    loop: Complex,
    turn: Floats,
    ends: NDArray[np.int64],
    width: float,
    last: Floats | None,
    settings: ContourMidlineSettings,
) -> tuple[int, int] | None:
    """Return the pair of candidates that make the most likely worm, in the contour's order."""
    best, most = None, -inf
    n = len(loop)
    where = ends.tolist()
    if len(where) == 2:  # nearly always: there is nothing to choose from
        return min(where), max(where)
    sharpness = np.minimum(turn[ends], settings.most_end_turn_rad).tolist()
    away = [[0.0, 0.0]] * len(where)
    if last is not None:
        tips = as_complex(last[[0, -1]])
        away = np.abs(loop[ends][:, None] - tips).tolist()
    for a in range(len(where)):
        for b in range(a + 1, len(where)):
            side = abs(where[a] - where[b])
            unequal = abs(log(side / (n - side)))
            score = sharpness[a] + sharpness[b] - settings.unequal_sides_cost * unequal
            moved = min(away[a][0] + away[b][1], away[a][1] + away[b][0])
            far = min(moved / width, settings.most_displacement_widths)
            score -= settings.displacement_cost_per_width * far
            if score > most:
                best, most = (min(where[a], where[b]), max(where[a], where[b])), score
    return best
