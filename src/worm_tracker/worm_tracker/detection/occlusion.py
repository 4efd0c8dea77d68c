"""Joins what is seen of a worm on both sides of a place where the picture cannot tell."""

from dataclasses import dataclass
from itertools import pairwise
from math import acos, pi

import cv2
import numpy as np

from worm_tracker.detection.blobs import Blob, Picture
from worm_tracker.midline.contour_midline import Floats, arc_length, resample, rough_midline

LEAST_PIECE = 0.3
"""Smallest area of a piece of the worm, in squared widths."""
NEAR = 1.2
"""How far from the body as it was a piece of it may lie, in widths."""
AT_THE_ZONE = 0.8
"""How far beyond an end the picture is looked at to tell whether it could see more, in widths."""
FADING = 0.8
"""The stretch of a piece before such an end whose midline is not believed, in widths."""
BEND = 1.2
"""Largest angle, radians, between an end's direction and the way to the next piece."""
TOUCHING = 1.5
"""A gap that is shorter, in widths, has no direction of its own."""
LONGEST_GAP = 0.4
"""Largest gap that is bridged, in lengths; in lengths of what is seen where none is known."""
IN_THE_ZONE = 0.6
"""Least part of a bridge that lies where the picture cannot tell."""
SPARE = 1.06
"""Length of the joined body over the known one that is not believed."""
MISSING = 1.5
"""A body shorter than the known one by so many widths goes on where the picture cannot tell."""
FADED = 0.55
"""Signal before an end, over that of the worm, below which the worm fades away there; a tip that is
seen is dark up to its edge."""
INSIDE = np.array([0.2, 0.35, 0.5])
"""Where before an end that is looked at, in widths."""
BACK = 1.0
"""The stretch before an end, in widths, over which its direction is taken."""


@dataclass(frozen=True, eq=False, slots=True)
class Joined:
    """A body put together.

    Attributes
    ----------
    pieces : list of ndarray, shape (n, 2)
        Midlines of what is seen, in order along the body, each in that direction.
    bridges : list of ndarray, shape (m, 2)
        What is put between them, and at the ends that are hidden.
    hidden : tuple of bool
        Whether the first, and the last, end of the body is hidden.
    """

    pieces: list[Floats]
    bridges: list[Floats]
    hidden: tuple[bool, bool]

    @property
    def ends(self) -> Floats:
        """The first and the last point that is seen, shape (2, 2)."""
        return np.stack([self.pieces[0][0], self.pieces[-1][-1]])


def join(
    blobs: list[Blob],
    signal: Picture,
    zone: Picture,
    width: float,
    length: float,
    level: float,
    body: Floats | None,
) -> Joined | None:
    """Put the pieces of a worm together.

    Parameters
    ----------
    blobs : list of Blob
        The objects in a window, in its coordinates.
    signal : ndarray of uint8, shape (h, w)
        Light that the worm takes away.
    zone : ndarray of uint8, shape (h, w)
        Not zero where the picture cannot tell.
    width, length, level : float
        Of the worm, pixels and grey levels; a length of 0 where none is known yet.
    body : ndarray, shape (n, 2), or None
        Its midline in the frame before.

    Returns
    -------
    Joined or None
        None where nothing of the worm is at a place where the picture cannot tell.
    """
    lines = [line for line in (_line(blob, width) for blob in blobs) if line is not None]
    if body is not None:
        lines = [line for line in lines if _is_near(line, body, width) or _cut(line, zone, width)]
        lines.sort(key=lambda line: not _is_near(line, body, width))
    if not lines:
        return None
    pieces = [_Piece.of(line, signal, zone, width, FADED * level) for line in lines]
    chain, rest = [pieces[0]], pieces[1:]
    most = length or 3.0 * _long(lines[0])
    while rest:
        found = _nearest(chain, rest, zone, width, most, SPARE * length)
        if found is None:
            break
        at_start, k, piece = found
        rest.pop(k)
        chain.insert(0, piece) if at_start else chain.append(piece)
    parts = _parts(chain, (False, False))
    bridges = [_bridge(one, other, width) for one, other in pairwise(parts)]
    seen = sum(map(_long, parts)) + sum(map(_long, bridges))
    short = not length or length - seen > MISSING * width
    first, last = chain[0].line[::-1], chain[-1].line
    hidden = (
        chain[0].fades[0] > 0 or (short and _is_cut(first, zone, width)),
        chain[-1].fades[1] > 0 or (short and _is_cut(last, zone, width)),
    )
    if not bridges and not any(hidden):
        return None
    if any(hidden):
        parts = _parts(chain, hidden)
        seen = sum(map(_long, parts)) + sum(map(_long, bridges))
        if length and body is not None:
            bridges += _continued(parts, hidden, length - seen, body, width)
    return Joined(parts, bridges, hidden)


@dataclass(frozen=True, eq=False, slots=True)
class _Piece:
    """A piece's midline, and how long the stretches are in which it fades at either end."""

    line: Floats
    fades: tuple[float, float]

    @classmethod
    def of(
        cls, line: Floats, signal: Picture, zone: Picture, width: float, faint: float
    ) -> "_Piece":
        first, last = (
            FADING * width if _is_faded(way, signal, zone, width, faint) else 0.0
            for way in (line[::-1], line)
        )
        return cls(line, (first, last))

    def turned(self) -> "_Piece":
        return _Piece(self.line[::-1], self.fades[::-1])

    def sure(self, first: bool, last: bool) -> Floats:
        """Return the line without the stretches in which it fades, at the ends that are asked for.

        A piece that would hardly be longer than these stays as it is.
        """
        s = arc_length(self.line)
        start, end = first * self.fades[0], s[-1] - last * self.fades[1]
        if end - start < 0.5 * s[-1]:
            return self.line
        at = np.linspace(start, end, len(self.line))
        return np.stack([np.interp(at, s, self.line[:, k]) for k in (0, 1)], axis=1)


def _parts(chain: list[_Piece], hidden: tuple[bool, bool]) -> list[Floats]:
    """Return the lines of what is seen for sure: also the ends of the body where these are seen."""
    last = len(chain) - 1
    return [piece.sure(k > 0 or hidden[0], k < last or hidden[1]) for k, piece in enumerate(chain)]


def _line(blob: Blob, width: float) -> Floats | None:
    """Return the midline of a piece; None where it is none of a worm."""
    if blob.area < LEAST_PIECE * width**2:
        return None
    rough = rough_midline(blob.contour, width, None) if blob.area > 3 * width**2 else None
    if rough is not None:
        return rough.points if rough.width < 1.6 * width else None
    centre, (a, b), turn = cv2.minAreaRect(blob.contour)
    along = np.radians(turn if a >= b else turn + 90)
    way = 0.5 * max(a, b) * np.array([np.cos(along), np.sin(along)])
    return np.linspace(centre - way, centre + way, 9)


def _is_near(line: Floats, body: Floats, width: float) -> bool:
    """Tell whether most of a piece lies along the body as it was."""
    away = np.hypot(*(line[:, None] - body[None]).T).min(axis=0)
    return bool((away < NEAR * width).mean() > 0.5)


def _cut(line: Floats, zone: Picture, width: float) -> bool:
    """Tell whether an end of a piece is where the picture cannot tell more."""
    return _is_cut(line, zone, width) or _is_cut(line[::-1], zone, width)


def _is_faded(line: Floats, signal: Picture, zone: Picture, width: float, faint: float) -> bool:
    """Tell whether a body fades away towards a line's last end."""
    if not _is_cut(line, zone, width):
        return False
    u, v = np.rint(line[-1] - INSIDE[:, None] * width * _direction(line, width)).astype(int).T
    seen = signal[v.clip(0, zone.shape[0] - 1), u.clip(0, zone.shape[1] - 1)]
    return bool(np.median(seen) < faint)


def _is_cut(line: Floats, zone: Picture, width: float) -> bool:
    """Tell whether a line's last end lies before a place where the picture cannot tell."""
    ahead = np.linspace(0.0, AT_THE_ZONE + FADING, 8)[:, None] * width * _direction(line, width)
    return _part_in(zone, line[-1] + ahead) > 0


def _direction(line: Floats, width: float) -> Floats:
    """Return the unit vector along a line at its last end."""
    s = arc_length(line)
    before = max(s[-1] - BACK * width, 0.0)
    way = line[-1] - np.array([np.interp(before, s, line[:, k]) for k in (0, 1)])
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))


def _nearest(
    chain: list[_Piece],
    rest: list[_Piece],
    zone: Picture,
    width: float,
    most: float,
    spare: float,
) -> tuple[bool, int, _Piece] | None:
    """Return the piece that continues a chain best: at its start?, which, turned the right way."""
    best, least = None, np.inf
    so_far = sum(_long(piece.line) for piece in chain)
    for at_start in (True, False):
        end = (chain[0].turned() if at_start else chain[-1]).sure(False, True)
        for k, piece in enumerate(rest):
            for way in (piece, piece.turned()):  # from the gap on
                line = way.sure(True, False)
                gap = line[0] - end[-1]
                far = float(np.hypot(*gap))
                if far > LONGEST_GAP * most or (spare and so_far + far + _long(line) > spare):
                    continue
                one, other = _direction(end, width), -_direction(line[::-1], width)
                if far < TOUCHING * width:  # the way across says nothing
                    turn = 2 * _angle(one, other)
                else:
                    turn = _angle(one, gap) + _angle(other, gap)
                if turn > 2 * BEND or far * (1 + turn) >= least:
                    continue
                if _part_in(zone, np.linspace(end[-1], line[0], 16)) < IN_THE_ZONE:
                    continue
                best, least = (at_start, k, way.turned() if at_start else way), far * (1 + turn)
    return best


def _angle(one: Floats, other: Floats) -> float:
    scale = float(np.hypot(*one) * np.hypot(*other))
    return acos(min(max(float(one @ other) / scale, -1.0), 1.0)) if scale > 1e-9 else pi


def _part_in(zone: Picture, points: Floats) -> float:
    """Return the part of some points that lie in a zone, or beyond the window."""
    u, v = np.rint(points).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < zone.shape[1]) & (v < zone.shape[0])
    hit = zone[v.clip(0, zone.shape[0] - 1), u.clip(0, zone.shape[1] - 1)] > 0
    return float((hit & inside).mean())


def _long(line: Floats) -> float:
    return float(arc_length(line)[-1])


def _bridge(one: Floats, other: Floats, width: float) -> Floats:
    """Return the smooth curve from the end of one line to the start of another."""
    p, q = one[-1], other[0]
    far = float(np.hypot(*(q - p)))
    a, b = far * _direction(one, width), -far * _direction(other[::-1], width)
    t = np.linspace(0.0, 1.0, 24)[:, None]
    return np.asarray(
        (2 * t**3 - 3 * t**2 + 1) * p
        + (t**3 - 2 * t**2 + t) * a
        + (3 * t**2 - 2 * t**3) * q
        + (t**3 - t**2) * b
    )


def _continued(
    chain: list[Floats], hidden: tuple[bool, bool], missing: float, body: Floats, width: float
) -> list[Floats]:
    """Return the hidden ends, as the body went on in the frame before."""
    if np.hypot(*(body[0] - chain[0][0])) > np.hypot(*(body[-1] - chain[0][0])):
        body = body[::-1]
    parts = []
    share = max(missing / sum(hidden) - width / 2, 1.0)  # it is drawn with a round end
    if hidden[0]:
        parts.append(_onward(chain[0][::-1], body[::-1], share, width))
    if hidden[1]:
        parts.append(_onward(chain[-1], body, share, width))
    return parts


def _onward(line: Floats, body: Floats, far: float, width: float) -> Floats:
    """Return a line's continuation beyond its last end, over a distance, along a body."""
    nearest = int(np.hypot(*(body - line[-1]).T).argmin())
    way = body[nearest:] + (line[-1] - body[nearest])
    way = np.concatenate([way, [way[-1] + 2 * far * _direction(body, width)]])
    s = arc_length(way)
    at = np.linspace(0.0, far, 24)
    return np.stack([np.interp(at, s, way[:, k]) for k in (0, 1)], axis=1)


def paint(picture: Picture, lines: list[Floats], width: float, level: float) -> Picture:
    """Return a signal with bodies drawn into it that have a width and a level."""
    strip = np.zeros_like(picture)
    for line in lines:
        fine = np.rint(16 * resample(line, 48)).astype(np.int32)
        cv2.polylines(strip, [fine], False, min(level, 255.0), max(1, round(width)), 16, 4)
    return np.asarray(cv2.max(picture, cv2.GaussianBlur(strip, (3, 3), 0)), np.uint8)
