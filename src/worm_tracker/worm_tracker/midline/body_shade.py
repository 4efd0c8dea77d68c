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
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.cross_sections import interpolate
from worm_tracker.midline.curve import as_complex, median_of, tangents

ACROSS = np.linspace(-0.3, 0.3, 7)
"""Places across the body, in widths: short of its edges, which the lens blurs."""


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
    once: cv2.typing.MatLike,
    twice: cv2.typing.MatLike,
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
    line = as_complex(points)
    n, width = len(line), median_of(widths)
    step = float(np.abs(np.diff(line)).mean())
    signal, shade = shade_along(seen.signal, line, widths), seen.shade
    one, level = at_nodes(shade.mean, n), median_of(shade.mean.ravel())
    sure = settings.sure_sds * np.sqrt(
        at_nodes(shade.variance, n) + (settings.least_sd_relative * level) ** 2
    )
    at = np.rint(places_across(line, widths).view(np.float64)).astype(np.intp)
    h, w = once.shape
    u, v = at[:, 0::2].clip(0, w - 1), at[:, 1::2].clip(0, h - 1)
    dark = signal > one + np.maximum(0.5 * seen.darkening * level, sure)
    single, double = dark & (once[v, u] > 0), twice[v, u] > 0
    ends = round(settings.end_widths * width / step)
    single[:ends] = single[n - ends :] = double[:ends] = double[n - ends :] = False
    cells = _largest(single)
    if double.any():
        other = _other_part(line, step, settings.other_part_widths * width)
        more = seen.darkening * one[other, len(ACROSS) // 2][:, None]
        least = np.minimum(0.5 * more, more - sure)
        cells += _largest(double & (signal < one + least))
    return cells * step * width * float(ACROSS[1] - ACROSS[0])


def at_nodes(mean: Floats, n: int) -> Floats:
    """Return values along a body at so many nodes of it."""
    at = np.linspace(0, len(mean) - 1, n)
    before = np.minimum(at.astype(np.intp), len(mean) - 2)
    part = (at - before)[:, None]
    return np.asarray((1 - part) * mean[before] + part * mean[before + 1], np.float64)


def _other_part(line: Complex, step: float, least_px: float) -> NDArray[np.intp]:
    """Return for each node the nearest one that is not of the same part of the body."""
    nearest = np.zeros(len(line), np.intp)
    _find_other_part(line, max(ceil(least_px / step), 0), nearest)
    return nearest


@compiled_for(array_read(types.complex128), types.intp, array_written(types.intp))
def _find_other_part(line: Complex, apart: int, nearest: NDArray[np.intp]) -> None:
    """Fill in for each node the nearest one that is so many nodes from it."""
    for k in range(len(line)):
        least = np.inf
        for m in range(len(line)):
            if abs(k - m) < apart:
                continue
            du, dv = line[k].real - line[m].real, line[k].imag - line[m].imag
            if du * du + dv * dv < least:
                least = du * du + dv * dv
                nearest[k] = m


def _largest(cells: Mask) -> float:
    """Return how many cells the largest connected piece has, but for what is a cell across."""
    image = cv2.erode(cells.astype(np.uint8), np.ones((1, 3), np.uint8))
    if not image.any():
        return 0.0
    _, _, stats, _ = cv2.connectedComponentsWithStats(image, connectivity=8)
    return float(stats[1:, cv2.CC_STAT_AREA].max())
