"""How dark a body is at each of its places, as its open pictures show it, and where it is not.

A skin has marks: dark ones are no overlaps, and pale ones are no water. What one layer of the body
lets through is learned place by place, along the body and across it, and how far it scatters.
A place is darker than one layer, or paler than two, only against that.
"""

from dataclasses import dataclass
from math import ceil

import cv2
import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.cross_sections import interpolate
from worm_tracker.midline.curve import as_complex, median_of, tangents, unit_grid

ACROSS = np.linspace(-0.3, 0.3, 7)
"""Places across the body, in widths: short of its edges, which the lens blurs."""
_THREE_ACROSS = np.ones((1, 3), np.uint8)


@dataclass(frozen=True, slots=True)
class BodyShadeSettings:
    """When a place of a body has another shade than its layers give."""

    least_sd_relative: float = 0.05
    """Scatter at least, over the signal: a midline is not found better in a fold."""
    sure_sds: float = 3.0
    """How many standard deviations a place must be from one layer, or from two, not to be it."""
    end_widths: float = 1.0
    """How much of an end is left out: its signal falls so steeply that a pixel's way changes it."""
    other_part_widths: float = 1.5
    """Distance along the body from which on another part of it may lie on a place."""


@dataclass(frozen=True, eq=False, slots=True)
class BodyShade:
    """Signal of one layer of a body.

    Attributes
    ----------
    mean : ndarray, shape (n, len(ACROSS))
        Grey levels, along the body and across it.
    variance : ndarray, same shape
        Mean square of what a picture differs from that.
    frames : int
        How many pictures it rests on.
    """

    mean: Floats
    variance: Floats
    frames: int = 1

    @classmethod
    def of(cls, seen: Floats) -> "BodyShade":
        """Return what a first picture tells, (n, len(ACROSS))."""
        return cls(seen, np.zeros_like(seen))

    def updated(self, seen: Floats, least_weight: float) -> "BodyShade":
        """Return it with one picture more, (n, len(ACROSS)) in the same order of the ends."""
        off = seen - self.mean
        rate = max(1 / (self.frames + 1), least_weight)
        variance = self.variance + rate * (off**2 - self.variance)
        return BodyShade(self.mean + rate * off, variance, self.frames + 1)

    def turned_round(self) -> "BodyShade":
        """Return it from the other end on."""
        return BodyShade(self.mean[::-1, ::-1], self.variance[::-1, ::-1], self.frames)


@dataclass(frozen=True, eq=False, slots=True)
class ShadedObject:
    """A picture of an object, and what one layer of the body looks like in it.

    Attributes
    ----------
    signal : ndarray of uint8, shape (h, w)
    shade : BodyShade
        In the brightness of this picture.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    """

    signal: Picture
    shade: BodyShade
    darkening: float


def marks_of(levels: Floats) -> float:
    """Return how far a body's signal differs along it, its ends left out, over its median."""
    cut = len(levels) // 10
    inner = levels[cut : len(levels) - cut]
    return float(np.std(inner) / max(median_of(inner), 1.0))


def shade_along(signal: Picture, line: Complex, widths: Floats) -> Floats:
    """Return a picture's signal along a body and across it, shape (n, len(ACROSS)).

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
    line : ndarray of complex, shape (n,)
        The midline in the picture's coordinates, u + iv.
    widths : ndarray, shape (n,)
    """
    return np.asarray(interpolate(signal, places_across(line, widths)), np.float64)


def places_across(line: Complex, widths: Floats) -> Complex:
    """Return the places along a body and across it that its shade is known of, u + iv.

    Parameters
    ----------
    line : ndarray of complex, shape (n,)
        The midline.
    widths : ndarray, shape (n,)

    Returns
    -------
    ndarray of complex, shape (n, len(ACROSS))
    """
    normal = 1j * tangents(line) * widths
    return line[:, None] + normal[:, None] * ACROSS


def misjudged_layers(
    seen: ShadedObject,
    points: Floats,
    widths: Floats,
    once: Picture,
    twice: Picture,
    settings: BodyShadeSettings,
) -> float:
    """Return where a body has other layers than the picture, the largest pieces, square pixels.

    Parameters
    ----------
    seen : ShadedObject
    points : ndarray, shape (n, 2)
        The body's midline at equal steps, in the picture's coordinates.
    widths : ndarray, shape (n,)
    once, twice : ndarray of uint8, shape (h, w)
        Where it lies surely once, and twice; not zero there.
    settings : BodyShadeSettings
    """
    line, width = as_complex(points), median_of(widths)
    step = float(np.abs(np.diff(line)).mean())
    at, shade = places_across(line, widths), seen.shade
    apart = max(ceil(settings.other_part_widths * width / step), 0)
    level = median_of(shade.mean.ravel())
    part = unit_grid(len(line))
    one = at_parts(shade.mean, part)
    variance = at_parts(shade.variance, part) + (settings.least_sd_relative * level) ** 2
    signal, sure = interpolate(seen.signal, at), settings.sure_sds * np.sqrt(variance)
    single, double = np.zeros((2, *at.shape), np.uint8)
    half_added = 0.5 * seen.darkening * level
    _mark_darker(signal, at, one + np.maximum(half_added, sure), once, single)
    _mark_paler(signal, at, one, sure, twice, apart, seen.darkening, double)
    ends = round(settings.end_widths * width / step)
    for cells in (single, double):
        cells[:ends] = cells[len(line) - ends :] = 0
    count = _largest(single) + _largest(double)
    return count * step * width * float(ACROSS[1] - ACROSS[0])


def at_parts(mean: Floats, part: Floats) -> Floats:
    """Return values along a body, (k, len(ACROSS)), at parts of its length from 0 to 1, (n,)."""
    at = part * (len(mean) - 1)
    before = np.minimum(at.astype(np.intp), len(mean) - 2)
    beyond = (at - before)[:, None]
    return np.asarray((1 - beyond) * mean[before] + beyond * mean[before + 1], np.float64)


@compiled
def _other_part(line: Complex, node: int, apart: int) -> int:
    """Return the node nearest to one of a line of those that are so many nodes from it, or 0."""
    nearest, least = 0, np.inf
    for k in range(len(line)):
        du, dv = line[node].real - line[k].real, line[node].imag - line[k].imag
        if abs(node - k) >= apart and du * du + dv * dv < least:
            nearest, least = k, du * du + dv * dv
    return nearest


@compiled
def _shows(mask: Picture, at: complex) -> bool:
    """Tell whether a mask is not zero at the pixel nearest to a place."""
    h, w = mask.shape
    u, v = int(np.rint(at.real)), int(np.rint(at.imag))
    return bool(mask[min(max(v, 0), h - 1), min(max(u, 0), w - 1)])


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.complex128, 2),
    array_read(types.float64, 2),
    array_read(types.uint8, 2),
    array_written(types.uint8, 2),
)
def _mark_darker(
    signal: Floats32, at: Complex, most: Floats, once: Picture, single: Picture
) -> None:
    """Mark the places, (nodes, across), darker than one layer where the body lies surely once."""
    nodes, across = at.shape
    for k in range(nodes):
        for a in range(across):
            single[k, a] = signal[k, a] > most[k, a] and _shows(once, at[k, a])


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.complex128, 2),
    array_read(types.float64, 2),
    array_read(types.float64, 2),
    array_read(types.uint8, 2),
    types.intp,
    types.float64,
    array_written(types.uint8, 2),
)
def _mark_paler(
    signal: Floats32,
    at: Complex,
    one: Floats,
    sure: Floats,
    twice: Picture,
    apart: int,
    darkening: float,
    double: Picture,
) -> None:
    """Mark the places paler than two layers where the body lies surely twice.

    The middle of a row of places is the midline; what lies on it is the nearest other part.
    """
    nodes, across = at.shape
    for k in range(nodes):
        other = -1
        for a in range(across):
            if not _shows(twice, at[k, a]):
                continue
            other = _other_part(at[:, across // 2], k, apart) if other < 0 else other
            more = darkening * one[other, across // 2]
            double[k, a] = signal[k, a] < one[k, a] + min(0.5 * more, more - sure[k, a])


def _largest(cells: Picture) -> float:
    """Return how many cells the largest connected piece has, but for what is a cell across."""
    image = np.asarray(cv2.erode(cells, _THREE_ACROSS))
    if not image.any():
        return 0.0
    _, _, stats, _ = cv2.connectedComponentsWithStats(image, connectivity=8)
    return float(stats[1:, cv2.CC_STAT_AREA].max())
