"""Places in which an end of a body may lie that lies on it: bodies with their first end otherwise.

Shorter and longer along the strand that it lies on; bent to where the outline is that no
other part of the body explains; and straight on.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.spatial.distance import cdist

from worm_msgs_py.arrays import Complex, Floats
from worm_tracker.midline.curve import as_points, complex_arc_length, tangents, unit_grid


@dataclass(frozen=True, slots=True)
class EndPlacesSettings:
    """Which places are tried."""

    longer_widths: tuple[float, ...] = (-2.4, -1.6, -0.8, 0.0, 0.8, 1.6, 2.4)
    """How much longer than it is the body is tried."""
    bent_widths: tuple[float, ...] = (1.5, 3.0, 4.5)
    least_beyond_widths: float = 0.15
    most_turn_rad: float = 2.4
    most_bend_per_width: float = 1.2
    """How much of it is bent to where the outline lies so far beyond the rest's flanks; by how much
    it turns at most then, and within a width."""
    straightened_widths: float = 2.5
    """How far to both sides the strand beside it goes straight by it then: an end that lay
    elsewhere has bent that, too."""
    least_nodes: int = 12
    """How many nodes must be left of a body."""
    least_apart_along_widths: float = 2.5
    most_beside_widths: float = 2.0
    least_cosine_of_strand: float = -0.3
    least_cosine_along_strand: float = 0.9
    """How far along the body another strand is apart, and how near it is to an end; how an end must
    head that goes on along it, and from when on it is not tried straight on, too."""


def places_along(curve: Complex, width: float, settings: EndPlacesSettings) -> Iterator[Complex]:
    """Yield bodies that are shorter and longer.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, u + iv.
    width : float
        The body's, pixels.
    settings : EndPlacesSettings
    """
    step = _node_distance(curve)
    ways = _ways_on(curve, step, width, max(settings.longer_widths), settings)
    for longer in settings.longer_widths:
        for on in ways if longer > 0 else ways[:1]:
            left_out = len(on) - round(longer * width / step)
            whole = np.concatenate([on[::-1], curve])
            if 0 <= left_out <= len(whole) - settings.least_nodes:
                yield whole[left_out:]


def places_beyond_flanks(
    curve: Complex, half: Floats, outline: Complex, width: float, settings: EndPlacesSettings
) -> Iterator[Complex]:
    """Yield bodies bent to where the outline lies beyond the rest's flanks, and straight on.

    To the farthest of it from where that end begins, at several places of the body.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, u + iv.
    half : ndarray, shape (n,)
        Half its widths, pixels.
    outline : ndarray of complex, shape (m,)
        Pixels of the object's outline, in the same coordinates.
    width : float
        The body's, pixels.
    settings : EndPlacesSettings
    """
    step = _node_distance(curve)
    straight = _with_strand_straightened(curve, step, width, settings)
    away = cdist(as_points(outline), as_points(straight)) - half
    for end_widths in settings.bent_widths:
        cut = round(end_widths * width / step)
        if len(curve) - cut < settings.least_nodes:
            continue
        start = complex(curve[cut])
        heading = start - curve[min(cut + 3, len(curve) - 1)]
        heading /= abs(heading)
        beyond = outline[away[:, cut:].min(axis=1) > settings.least_beyond_widths * width]
        longest = (end_widths + max(settings.longer_widths)) * width
        chord = _longest_spanned((beyond - start) / heading, longest, width, settings)
        if chord is not None:
            end = start + heading * _arc_over(chord, step)[:0:-1]
            yield np.concatenate([end, straight[cut:]])
            yield np.concatenate([end, curve[cut:]])
        end = start + heading * _arc_over(complex(end_widths * width), step)[:0:-1]
        yield np.concatenate([end, straight[cut:]])


def lengthened(
    curve: Complex, widths: float, width: float, settings: EndPlacesSettings
) -> Complex | None:
    """Return a body longer or shorter at its first end by some widths; None where little is left.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, u + iv.
    widths : float
    width : float
        The body's, pixels.
    settings : EndPlacesSettings
    """
    step = _node_distance(curve)
    nodes = round(widths * width / step)
    line = curve[-nodes:]
    if nodes >= 0:
        on = _ways_on(curve, step, width, widths, settings)[0]
        line = np.concatenate([on[:nodes][::-1], curve])
    return line if len(line) >= settings.least_nodes else None


def _longest_spanned(
    chords: Complex, longest: float, width: float, settings: EndPlacesSettings
) -> complex | None:
    """Return the longest chord that an end which heads along the real axis can span."""
    turn, length = 2 * np.angle(chords), np.abs(chords)
    spanned = (np.abs(turn) < settings.most_turn_rad) & (length < longest)
    spanned &= np.abs(turn) * width < settings.most_bend_per_width * length
    return complex(chords[np.argmax(length * spanned)]) if spanned.any() else None


def _arc_over(chord: complex, step: float) -> Complex:
    """Return the nodes of an arc from 0 on that goes off along the real axis and spans a chord."""
    angle = float(np.angle(chord))
    if abs(angle) < 1e-6:
        return np.asarray(np.linspace(0, chord, max(round(abs(chord) / step), 1) + 1))
    length, radius = abs(chord) * angle / np.sin(angle), abs(chord) / (2 * np.sin(angle))
    part = np.linspace(0, 1, max(round(length / step), 1) + 1)
    return np.asarray(radius * 1j * (1 - np.exp(2j * angle * part)))


def _with_strand_straightened(
    curve: Complex, step: float, width: float, settings: EndPlacesSettings
) -> Complex:
    """Return a body whose strand beside its first end goes by it as a cubic."""
    reach = round(settings.straightened_widths * width / step)
    beside = _strand_beside(curve, step, width, settings)
    if beside is None or not 3 <= beside - reach < beside + reach <= len(curve) - 4:
        return curve
    first, last = beside - reach, beside + reach
    along = (last - first) / 3
    slopes = along * (curve[first] - curve[first - 3]), along * (curve[last + 3] - curve[last])
    line = curve.copy()
    line[first : last + 1] = _cubic_between(curve[first], curve[last], slopes, last - first + 1)
    return line


def _cubic_between(
    start: complex, stop: complex, slopes: tuple[complex, complex], nodes: int
) -> Complex:
    """Return the cubic from one place to another: SciPy's Hermite spline takes 50 times as long.

    Its slopes there are those over all of the way.
    """
    part, way = unit_grid(nodes), stop - start
    bend = slopes[0] + slopes[1] - 2 * way
    bow = way - slopes[0] - bend
    return np.asarray(start + slopes[0] * part + bow * part**2 + bend * (part**2 * part))


def _strand_beside(
    curve: Complex, step: float, width: float, settings: EndPlacesSettings
) -> int | None:
    """Return the node of another strand that is nearest to a body's first end; None if none is."""
    apart = round(settings.least_apart_along_widths * width / step)
    if len(curve) <= apart:
        return None
    away = np.abs(curve[apart:] - curve[0])
    is_beside = away.min() < settings.most_beside_widths * width
    return apart + int(away.argmin()) if is_beside else None


def _ways_on(
    curve: Complex, step: float, width: float, longest_widths: float, settings: EndPlacesSettings
) -> list[Complex]:
    """Return ways on which a body may go on beyond its first end, the likeliest first.

    Along the strand that it lies on, either way, as far aside as it lies; and straight on.
    """
    count = ceil(longest_widths * width / step)
    heading = curve[0] - curve[min(3, len(curve) - 1)]
    heading /= max(abs(heading), 1e-9)
    ways = list[tuple[float, Complex]]()
    beside = _strand_beside(curve, step, width, settings)
    if beside is not None:
        along = curve[min(beside + 2, len(curve) - 1)] - curve[max(beside - 2, 0)]
        along /= max(abs(along), 1e-9)
        for sign in (1, -1):
            cosine = sign * float((along * heading.conjugate()).real)
            strand = curve[beside::sign][: count + 1]
            if cosine > settings.least_cosine_of_strand and len(strand) > 3:
                ways.append((cosine, _along_strand(strand, complex(curve[0]))))
    if not any(cosine > settings.least_cosine_along_strand for cosine, _ in ways):
        ways.append((1.0, curve[0] + heading * step * np.arange(1, count + 1)))
    return [way for _, way in sorted(ways, key=lambda each: -each[0])]


def _along_strand(strand: Complex, place: complex) -> Complex:
    """Return a way on along a strand, as far aside as a place beside its first node."""
    tangent = tangents(strand)
    aside = ((place - strand[0]) / tangent[0]).imag
    return np.asarray((strand + 1j * aside * tangent)[1:])


def _node_distance(curve: Complex) -> float:
    """Return how far apart a body's nodes are, pixels."""
    return float(complex_arc_length(curve)[-1]) / (len(curve) - 1)
