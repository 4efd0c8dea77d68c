"""Draws a body that may lie on itself: where it is, and where strands of it lie on each other."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.curve import as_complex, complex_arc_length

_MOST_PIECES = 250
"""Pieces of a body that a byte tells apart; a longer body's pieces are longer."""
FARTHEST_PX = 1e6
"""What is farther off, or no number, is not drawn: no whole number tells its pixel."""


@dataclass(frozen=True, slots=True)
class StrandDrawingSettings:
    """Which pieces of a body are other strands than each other."""

    piece_widths: float = 2.0
    """Length of the pieces that a body is drawn in: two that are not neighbours are two strands."""
    hairpin_half_widths: float = 0.6
    least_hairpin_rad: float = 2.0
    """Turn over twice that length from which on a bend is a hairpin: its sides are two strands."""
    beside_hairpin_widths: float = 5.0
    """How far along the body two strands are apart at most that lie beside each other there."""
    kink_rad: float = 0.25
    """Turn between two points of a midline from which on it is drawn with a round joint."""


class DrawnStrands(NamedTuple):
    """Where a body is, and how many of its strands; each a picture of 0 or 255.

    Near a hairpin two strands lie beside each other rather than on each other, however tight it is
    drawn: a body is as high as it is wide. Such a place may be dark or not.

    Attributes
    ----------
    body : ndarray of uint8, shape (h, w)
        Where it is.
    twice : ndarray of uint8, shape (h, w)
        Where two strands of it are.
    layered : ndarray of uint8, shape (h, w)
        Where they lie on each other, and not beside each other at a hairpin.
    thrice : ndarray of uint8, shape (h, w)
        Where three do.
    """

    body: Picture
    twice: Picture
    layered: Picture
    thrice: Picture


def drawn_strands(
    shape: tuple[int, ...],
    points: Floats,
    widths: Floats,
    width: float,
    settings: StrandDrawingSettings,
) -> DrawnStrands:
    """Draw a body and where strands of it lie on each other.

    Parameters
    ----------
    shape : tuple of int
        Height and width of the pictures, pixels.
    points : ndarray, shape (n, 2)
        The midline (u, v) in the pictures' coordinates.
    widths : ndarray, shape (n,)
        Width of the body there, pixels.
    width : float
        That of most of the body.
    settings : StrandDrawingSettings
    """
    line = as_complex(points)
    s = complex_arc_length(line)
    half = settings.hairpin_half_widths * width
    cuts = _cuts(line, s, half, settings.least_hairpin_rad, settings.piece_widths * width)
    beside = np.searchsorted(s[cuts], s[cuts] - settings.beside_hairpin_widths * width)
    return _drawn_in_pieces(shape, line, widths, cuts, beside, settings)


def drawn_body(
    shape: tuple[int, ...], line: Complex, widths: Floats, settings: StrandDrawingSettings
) -> Picture:
    """Draw a body, as `drawn_strands` does, and return where it is; 0 or 255."""
    one = np.array([0, len(line) - 1])
    return _drawn_in_pieces(shape, line, widths, one, np.zeros(2, np.intp), settings).body


def _drawn_in_pieces(
    shape: tuple[int, ...],
    line: Complex,
    widths: Floats,
    cuts: NDArray[np.intp],
    beside: NDArray[np.intp],
    settings: StrandDrawingSettings,
) -> DrawnStrands:
    """Draw a body that is cut into pieces, each with how many of the first lie not beside it."""
    number, twice, layered, thrice = np.zeros((4, *shape), np.uint8)
    _draw(line, widths, settings.kink_rad, cuts, beside, number, twice, layered, thrice)
    body = np.asarray((number > 0).view(np.uint8) * 255, np.uint8)
    return DrawnStrands(body, twice, layered, thrice)


@compiled
def _turns(line: Complex, s: Floats, half: float) -> Floats:
    """Return by how much a line turns from half a hairpin before each node to as much after it."""
    d = line[1:] - line[:-1]
    turned = np.zeros(len(d))
    for k in range(1, len(d)):
        turned[k] = turned[k - 1] + np.angle(d[k] * d[k - 1].conjugate())
    middle = (s[1:] + s[:-1]) / 2
    return np.abs(np.interp(s + half, middle, turned) - np.interp(s - half, middle, turned))


@compiled_for(
    array_read(types.complex128),
    array_read(types.float64),
    types.float64,
    types.float64,
    types.float64,
)
def _cuts(
    line: Complex, s: Floats, half: float, least_hairpin_rad: float, piece: float
) -> NDArray[np.intp]:
    """Return the nodes at which a body is cut into pieces; each hairpin is the middle of one.

    So what comes to a hairpin and what leaves it are two strands, wherever along the body it lies.
    """
    turn = _turns(line, s, half)
    ends = [0.0, s[-1]]
    while turn.max() > least_hairpin_rad:
        apex = s[turn.argmax()]
        turn[np.abs(s - apex) < 4 * half] = 0.0
        ends += [end for end in (apex - half, apex + half) if 0 <= end <= s[-1]]
    ends.sort()
    piece = max(piece, s[-1] / (_MOST_PIECES - len(ends)))
    cuts = [0]
    for k in range(len(ends) - 1):
        way = ends[k + 1] - ends[k]
        pieces = max(1, round(way / piece))
        for stop in range(1, pieces + 1):
            at = ends[k] + way * stop / pieces if stop < pieces else ends[k + 1]
            node = min(np.searchsorted(s, at), len(s) - 1)
            if node > cuts[-1]:
                cuts.append(node)
    return np.array(cuts)


class _Drawing(NamedTuple):
    """What is drawn: at each pixel the number of its last piece and 2; and where strands lie."""

    number: Picture
    twice: Picture
    layered: Picture
    thrice: Picture


@compiled
def _mark(
    drawing: _Drawing,
    v: int,
    first: int,
    last: int,
    piece: int,
    beside: int,
) -> None:
    """Note that a piece of the body covers the pixels of a row from one to another one.

    The piece before is the same strand, and so is this one itself.
    """
    number, twice = drawing.number[v], drawing.twice[v]
    layered, thrice = drawing.layered[v], drawing.thrice[v]
    for u in range(first, last + 1):
        before = number[u]
        if before == piece + 2:
            continue
        if 1 <= before <= piece:
            twice[u] = 255
        if 1 <= before <= beside:
            thrice[u] = layered[u]
            layered[u] = 255
        number[u] = piece + 2


@compiled
def _fill_polygon(
    corners_u: Floats,
    corners_v: Floats,
    count: int,
    edges: Floats,
    drawing: _Drawing,
    piece: int,
    beside: int,
) -> None:
    """Mark the pixels that lie in a convex polygon, or nearer than half a pixel to its edge.

    `edges`, shape (3, 4), is written over: to make room for each polygon would take longer.
    """
    h, w = drawing.number.shape
    area, least_u, most_u, least_v, most_v = 0.0, np.inf, -np.inf, np.inf, -np.inf
    for k in range(count):
        if not max(abs(corners_u[k]), abs(corners_v[k])) < FARTHEST_PX:
            return
        least_u, most_u = min(least_u, corners_u[k]), max(most_u, corners_u[k])
        least_v, most_v = min(least_v, corners_v[k]), max(most_v, corners_v[k])
        m = k + 1 if k + 1 < count else 0
        area += corners_u[k] * corners_v[m] - corners_u[m] * corners_v[k]
    least_u, most_u, least_v, most_v = least_u - 0.5, most_u + 0.5, least_v - 0.5, most_v + 0.5
    if most_u < 0 or least_u > w - 1 or most_v < 0 or least_v > h - 1:
        return
    turn = 1.0 if area >= 0 else -1.0
    # Within an edge, or beyond it by half a pixel: dv (u - u_k) <= du (v - v_k) + rim. Where that
    # is as u <= (du v + rest) / dv, or as >=, what does not change from row to row is worked out.
    slope, rest, side = edges
    for k in range(count):
        m = k + 1 if k + 1 < count else 0
        du, dv = turn * (corners_u[m] - corners_u[k]), turn * (corners_v[m] - corners_v[k])
        slope[k], rest[k], side[k] = du, 0.5 * max(abs(du), abs(dv)) - du * corners_v[k], dv
        if dv != 0:
            slope[k], rest[k] = du / dv, corners_u[k] + rest[k] / dv
    for v in range(max(int(np.ceil(least_v)), 0), min(int(np.floor(most_v)), h - 1) + 1):
        low, high = max(least_u, 0.0), min(most_u, w - 1.0)
        for k in range(count):
            most = slope[k] * v + rest[k]
            if side[k] > 0:
                high = min(high, most)
            elif side[k] < 0:
                low = max(low, most)
            elif most < 0:
                high = low - 1.0
        _mark(drawing, v, int(np.ceil(low)), int(np.floor(high)), piece, beside)


@compiled
def _is_convex(corners_u: Floats, corners_v: Floats) -> bool:
    """Tell whether four corners turn the same way all round."""
    left, right = 0, 0
    for k in range(4):
        m, n = (k + 1) % 4, (k + 2) % 4
        turn = (corners_u[m] - corners_u[k]) * (corners_v[n] - corners_v[m])
        turn -= (corners_v[m] - corners_v[k]) * (corners_u[n] - corners_u[m])
        left += turn >= 0
        right += turn <= 0
    return left == 4 or right == 4


@compiled
def _fill_disc(
    centre: complex,
    radius: float,
    drawing: _Drawing,
    piece: int,
    beside: int,
) -> None:
    """Mark the pixels of a disc: a joint is round on its outer side."""
    h, w = drawing.number.shape
    if not abs(centre) + radius < FARTHEST_PX:
        return
    for v in range(
        max(int(centre.imag - radius), 0), min(int(centre.imag + radius) + 1, h - 1) + 1
    ):
        for u in range(
            max(int(centre.real - radius), 0), min(int(centre.real + radius) + 1, w - 1) + 1
        ):
            if (u - centre.real) ** 2 + (v - centre.imag) ** 2 <= radius**2:
                _mark(drawing, v, u, u, piece, beside)


@compiled
def _flanks(line: Complex, widths: Floats, kink_rad: float) -> tuple[Complex, Complex, Floats]:
    """Return a body's left and right flank, and the radii of the joints at its kinks."""
    n = len(line)
    left, right, joint = np.empty(n, np.complex128), np.empty(n, np.complex128), np.zeros(n)
    for k in range(n):
        before, after = line[max(k - 1, 0)], line[min(k + 1, n - 1)]
        half = max(widths[k], 1.0) / 2
        along = after - before
        side = 1j * along / max(abs(along), 1e-9) * half
        left[k], right[k] = line[k] + side, line[k] - side
        if 0 < k < n - 1:
            turn = np.angle((after - line[k]) * (line[k] - before).conjugate())
            joint[k] = half if abs(turn) > kink_rad else 0.0
    return left, right, joint


@compiled_for(
    array_read(types.complex128),
    array_read(types.float64),
    types.float64,
    array_read(types.intp),
    array_read(types.intp),
    array_written(types.uint8, 2),
    array_written(types.uint8, 2),
    array_written(types.uint8, 2),
    array_written(types.uint8, 2),
)
def _draw(
    line: Complex,
    widths: Floats,
    kink_rad: float,
    cuts: NDArray[np.intp],
    beside: NDArray[np.intp],
    number: Picture,
    twice: Picture,
    layered: Picture,
    thrice: Picture,
) -> None:
    """Draw a body piece by piece, each of quadrilaterals from node to node, and discs at kinks."""
    drawing = _Drawing(number, twice, layered, thrice)
    left, right, joint = _flanks(line, widths, kink_rad)
    corners_u, corners_v, edges = np.empty(4), np.empty(4), np.empty((3, 4))
    for piece in range(len(cuts) - 1):
        far = beside[piece]
        for k in range(cuts[piece], cuts[piece + 1]):
            if joint[k] > 0:
                _fill_disc(line[k], joint[k], drawing, piece, far)
            for corner, z in enumerate((left[k], left[k + 1], right[k + 1], right[k])):
                corners_u[corner], corners_v[corner] = z.real, z.imag
            if _is_convex(corners_u, corners_v):
                _fill_polygon(corners_u, corners_v, 4, edges, drawing, piece, far)
                continue
            _fill_polygon(corners_u, corners_v, 3, edges, drawing, piece, far)
            corners_u[1], corners_v[1] = corners_u[3], corners_v[3]
            _fill_polygon(corners_u, corners_v, 3, edges, drawing, piece, far)
