"""Moves a body's strands about a place until their flanks lie on an object's outline.

Where two strands lie on each other one of them hides the other's flank: what is not hidden lies on
the outline, and none lies beyond it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Floats32
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.object_outline import Outline

_Indices = NDArray[np.intp]


class _FitNumbers(NamedTuple):
    """What compiled functions ask for: lengths in pixels, `end_widths` in widths."""

    width: float
    end_widths: float
    strand_sd: float
    end_sd: float
    reach: float
    bend_of_shift_sd: float
    turn_sd: float
    edge_sd: float
    most_off: float
    apart_along: float
    hidden: float
    hidden_within: float
    prior: float

    @classmethod
    def of(cls, width: float, moves: "StrandMoves", settings: "FlankFitSettings") -> "_FitNumbers":
        """Return the numbers of a body so wide."""
        return cls(
            width=width,
            end_widths=moves.end_widths,
            strand_sd=moves.strand_sd_widths * width,
            end_sd=moves.end_sd_widths * width,
            reach=settings.reach_widths * width,
            bend_of_shift_sd=settings.bend_of_shift_sd_widths * width,
            turn_sd=settings.turn_sd_rad,
            edge_sd=settings.edge_sd_px,
            most_off=settings.most_off_widths * width,
            apart_along=settings.apart_along_widths * width,
            hidden=settings.hidden_px,
            hidden_within=settings.hidden_within_widths * width,
            prior=settings.prior_px2,
        )


_FIT_NUMBERS = types.NamedUniTuple(types.float64, len(_FitNumbers._fields), _FitNumbers)


@dataclass(frozen=True, slots=True)
class FlankFitSettings:
    """How far strands may be moved, and what of the outline counts."""

    reach_widths: float = 4.5
    """How far about the place flanks are compared with the outline."""
    bend_of_shift_sd_widths: float = 0.3
    """How much the way that a strand is moved aside may change its course from width to width."""
    turn_sd_rad: float = 0.25
    """How much an end turns over half a width."""
    edge_sd_px: float = 0.6
    """How far the outline may lie from where the body's widths have it."""
    most_off_widths: float = 0.35
    """What lies farther from the outline than that counts as that much."""
    hidden_px: float = 1.2
    """How near to another strand a flank is hidden by it: between two as near no water is seen."""
    apart_along_widths: float = 1.5
    hidden_within_widths: float = 0.12
    """How far along the body another strand is apart; nearer, a flank is hidden at a sharp bend,
    where it lies so far within the body."""
    prior_px2: float = 0.4
    """What a standard deviation more costs, over a squared pixel along a pixel of a flank."""


@dataclass(frozen=True, slots=True)
class StrandMoves:
    """How far a body's strands are moved aside.

    Attributes
    ----------
    end_widths : float
        How much of the body is its first end.
    strand_sd_widths, end_sd_widths : float
        How far other strands are moved, and that end.
    iterations : int
        How often.
    """

    end_widths: float
    strand_sd_widths: float
    end_sd_widths: float
    iterations: int


def fitted_to_flanks(
    curve: Complex,
    half: Floats,
    outline: Outline,
    place: complex,
    width: float,
    moves: StrandMoves,
    settings: FlankFitSettings,
) -> tuple[float, Complex]:
    """Move the strands about a place aside until their flanks lie on the outline.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        Where the body lies, from its first end on at equal steps.
    half : ndarray, shape (n,)
        Half its widths, pixels.
    outline : Outline
        What of it lies beyond all flanks costs, too.
    place : complex
    width : float
        The body's, pixels.
    moves : StrandMoves
    settings : FlankFitSettings

    Returns
    -------
    cost : float
        What is left, squared pixels times pixels of flank.
    line : ndarray of complex, shape (n,)
        Where the body lies so.
    """
    line = np.empty(len(curve), np.complex128)
    numbers = _FitNumbers.of(width, moves, settings)
    curve = np.ascontiguousarray(curve)
    distance, pixels = outline.distance, outline.pixels
    return _fit_strands(curve, half, distance, pixels, place, numbers, moves.iterations, line), line


@compiled
def _lengths_up_to(curve: Complex) -> Floats:
    """Return the length up to each node."""
    s = np.zeros(len(curve))
    for i in range(1, len(curve)):
        s[i] = s[i - 1] + abs(curve[i] - curve[i - 1])
    return s


@compiled
def _unknown_of_knots(s: Floats, near: _Indices, width: float) -> tuple[_Indices, int]:
    """Return which unknown each knot is, one a width along the body, and how many are asked.

    -1 for those that move nothing near the place.
    """
    at = np.full(int(s[-1] / width) + 3, -1, np.intp)
    for i in near:
        first = int(s[i] / width)
        at[first] = at[first + 1] = 0
    count = 0
    for knot in range(len(at)):
        if at[knot] == 0:
            at[knot] = count
            count += 1
    return at, count


@compiled
def _inverse_covariance(at: _Indices, count: int, numbers: _FitNumbers) -> Floats:
    """Return the inverse covariance of how far the knots are moved, and the outline's offset."""
    prior = np.zeros((count + 1, count + 1))
    bend = np.array([1.0, -2.0, 1.0])
    for knot in range(len(at)):
        j = at[knot]
        if j < 0:
            continue
        sd = numbers.end_sd if knot < numbers.end_widths else numbers.strand_sd
        prior[j, j] += 1 / sd**2
        if knot + 2 < len(at) and at[knot + 1] >= 0 and at[knot + 2] >= 0:
            for k in range(3):
                for m in range(3):
                    prior[j + k, j + m] += bend[k] * bend[m] / numbers.bend_of_shift_sd**2
    prior[count, count] = 1 / numbers.edge_sd**2
    prior *= numbers.prior
    return prior


@compiled
def _turn_cost(line: Complex, step: float, numbers: _FitNumbers) -> float:
    """Return what the turns of an end cost."""
    over = max(1, int(np.rint(numbers.width / step)))
    stride = max(over // 2, 1)
    last = min(int((numbers.end_widths + 2) * over), len(line))
    total = 0.0
    for i in range(stride, last - stride, stride):
        turn = np.angle((line[i + stride] - line[i]) * (line[i] - line[i - stride]).conjugate())
        total += (turn / numbers.turn_sd) ** 2
    return float(total * numbers.prior)


@compiled
def _distance_at(distance: Floats32, x: float, y: float) -> float:
    """Return the distance between pixels."""
    u, v = int(x), int(y)
    fu, fv = x - u, y - v
    above = distance[v, u] * (1 - fu) + distance[v, u + 1] * fu
    below = distance[v + 1, u] * (1 - fu) + distance[v + 1, u + 1] * fu
    return float(above * (1 - fv) + below * fv)


@compiled
def _is_within(point: complex, x: Floats, y: Floats, squared_radii: Floats) -> bool:
    """Tell whether a point lies within one of some discs.

    All are asked, so that the machine asks several at once.
    """
    u, v, count = point.real, point.imag, 0
    for m in range(len(x)):
        a, b = x[m] - u, y[m] - v
        count += a * a + b * b < squared_radii[m]
    return count > 0


@compiled
def _fill_off(
    line: Complex,
    half: Floats,
    s: Floats,
    near: _Indices,
    about: _Indices,
    edge: float,
    distance: Floats32,
    numbers: _FitNumbers,
    off: Floats,
    side: Floats,
) -> float:
    """Fill in how far each flank near the place is off, and to which side it is; sum that up.

    None where it lies within another strand, or within its own at a bend.
    """
    height, across = distance.shape
    last, most, total = len(line) - 1, numbers.most_off, 0.0
    x, y = line.real[about], line.imag[about]
    squared = (half[about] + numbers.hidden) ** 2
    own = np.maximum(half[about] - numbers.hidden_within, 0.0) ** 2
    other = squared.copy()
    first = after = 0
    for row in range(len(near)):
        i = near[row]
        while after < len(about) and s[about[after]] <= s[i] + numbers.apart_along:
            squared[after] = own[after]
            after += 1
        while s[about[first]] < s[i] - numbers.apart_along:
            squared[first] = other[first]
            first += 1
        along = line[min(i + 1, last)] - line[max(i - 1, 0)]
        normal = 1j * along / max(abs(along), 1e-9)
        for j in range(2):
            off[row, j] = side[row, j] = 0.0
            sign = 1.0 - 2.0 * j
            point = line[i] + sign * half[i] * normal
            if not (0 <= point.real < across - 1 and 0 <= point.imag < height - 1):
                continue
            away = _distance_at(distance, point.real, point.imag) + edge
            if away < 0 and _is_within(point, x, y, squared):
                continue
            off[row, j], side[row, j] = away, sign
            total += min(away * away, most * most)
    return total


@compiled
def _add_flanks(
    a: Floats,
    b: Floats,
    s: Floats,
    near: _Indices,
    at: _Indices,
    off: Floats,
    side: Floats,
    step: float,
    numbers: _FitNumbers,
) -> None:
    """Add to the normal equations what each flank says."""
    width, most, last = numbers.width, numbers.most_off, len(b) - 1
    for row in range(len(near)):
        knot = s[near[row]] / width
        first = int(knot)
        j, k, part = at[first], at[first + 1], knot - first
        for flank in range(2):
            sign, away = side[row, flank], off[row, flank]
            if sign == 0:
                continue
            weight = step * (1.0 if abs(away) < most else most / abs(away))
            one, other = sign * (1 - part), sign * part
            a[j, j] += weight * one * one
            a[k, k] += weight * other * other
            a[j, k] += weight * one * other
            a[k, j] += weight * one * other
            for m, slope in ((j, one), (k, other)):
                a[m, last] += weight * slope
                a[last, m] += weight * slope
                b[m] -= weight * slope * away
            a[last, last] += weight
            b[last] -= weight * away


@compiled
def _beyond_flanks(
    line: Complex, half: Floats, outline: Complex, place: complex, numbers: _FitNumbers
) -> float:
    """Return what the outline near a place costs that lies beyond all flanks."""
    about = np.flatnonzero(np.abs(line - place) < numbers.reach + numbers.width)
    x, y, radius, total = line.real[about], line.imag[about], half[about] + 0.5, 0.0
    within, near = radius**2, (radius + numbers.most_off) ** 2
    away2 = np.empty(len(about))
    for point in outline:
        du, dv = point.real - place.real, point.imag - place.imag
        if du * du + dv * dv > numbers.reach**2:
            continue
        discs = 0
        for m in range(len(about)):
            a, b = x[m] - point.real, y[m] - point.imag
            away2[m] = a * a + b * b
            discs += away2[m] < within[m]
        if discs > 0:
            continue
        away = numbers.most_off
        for m in range(len(about)):
            if away2[m] < near[m] and away2[m] < (radius[m] + away) ** 2:
                away = np.sqrt(away2[m]) - radius[m]
        total += away * away
    return float(total)


@compiled_for(
    array_read(types.complex128),
    array_read(types.float64),
    array_read(types.float32, 2),
    array_read(types.complex128),
    types.complex128,
    _FIT_NUMBERS,
    types.intp,
    array_written(types.complex128),
)
def _fit_strands(
    curve: Complex,
    half: Floats,
    distance: Floats32,
    outline: Complex,
    place: complex,
    numbers: _FitNumbers,
    iterations: int,
    best: Complex,
) -> float:
    """Fill in the best line, and return its cost."""
    width, reach = numbers.width, numbers.reach
    s = _lengths_up_to(curve)
    step = s[-1] / (len(curve) - 1)
    away = np.abs(curve - place)
    near, about = np.flatnonzero(away < reach), np.flatnonzero(away < reach + width)
    at, count = _unknown_of_knots(s, near, width)
    prior = _inverse_covariance(at, count, numbers)
    x, least = np.zeros(count + 1), np.inf
    off, side = np.zeros((len(near), 2)), np.zeros((len(near), 2))
    line = curve.copy()
    for i in range(iterations + 1):
        for node in near:
            knot = s[node] / width
            first = int(knot)
            aside = x[at[first]] * (first + 1 - knot) + x[at[first + 1]] * (knot - first)
            before, after = max(int(node) - 1, 0), min(int(node) + 1, len(curve) - 1)
            along = curve[after] - curve[before]
            line[node] = curve[node] + aside * 1j * along / max(abs(along), 1e-9)
        total = _fill_off(line, half, s, near, about, x[count], distance, numbers, off, side)
        cost = total * step + x @ (prior @ x) + _turn_cost(line, step, numbers)
        if cost < least:
            least = cost
            best[:] = line
        if i < iterations:
            a, b = prior.copy(), -(prior @ x)
            _add_flanks(a, b, s, near, at, off, side, step, numbers)
            x = x + np.linalg.solve(a, b)
    return least + _beyond_flanks(best, half, outline, place, numbers)
