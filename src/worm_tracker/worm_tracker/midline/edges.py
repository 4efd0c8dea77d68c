"""The signal along straight or bent lines, and where on them the body's edge is.

The signal is the light that the body takes away: background minus picture. An edge is the point
where it falls to half of what it is just inside, above what darkens the water beside the body.
"""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.midline.contour_midline import Complex, Floats

Profiles = NDArray[np.float32]

STEP_PX = 0.5
"""Distance of the samples on a line."""
PLATEAU = 0.25
"""How far inside its edge the body's level is read, in widths."""
LOW = 0.25
"""Fraction of the body's level below which there is no body."""
BESIDE = 3
"""Samples at a line's far end that tell what darkens the water there."""
_HALF_MEAN = np.full(BESIDE, 0.5 / BESIDE, np.float32)


@cache
def steps(first: int, last: int, powers: int = 2) -> Profiles:
    """Return the powers 0, 1, … of the distances from `first` to `last` samples, one a row."""
    t = np.arange(first, last + 1) * STEP_PX
    return np.stack([t**power for power in range(powers)]).astype(np.float32)


def sample(signal: NDArray[np.uint8], lines: list[Complex], t: Profiles) -> Profiles:
    """Return the signal along lines, shape (lines, samples); zero outside the window.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
    lines : list of ndarray of complex
        Where each line starts, its direction, and (for bent lines) what goes with the distance's
        square: the terms of a polynomial whose values are u + iv.
    t : ndarray of float32, shape (len(lines), samples)
        Powers of the distance along the line, see `steps`.
    """
    n = len(lines[0])
    terms = np.empty((2 * n, len(lines)), np.float32)
    for k, term in enumerate(lines):
        terms[:n, k], terms[n:, k] = term.real, term.imag
    places = terms @ t
    return cv2.remap(
        signal, places[:n], places[n:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT
    ).astype(np.float32)


def edges(profiles: Profiles, level: Profiles, width: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the distance at which each profile falls through the half-height of its edge.

    The edge is first met where the profile falls below a low fraction of the body's level; its
    height is then taken a quarter of a width further in, because a body need not be equally dark
    across its width.

    Parameters
    ----------
    profiles : ndarray of float32, shape (n, samples)
        From within the body outwards.
    level : ndarray of float32, shape (n,)
        The signal in the body there.
    width : float
        The body's expected width, pixels.

    Returns
    -------
    distances : ndarray, shape (n,)
        Pixels; zero where no edge was found.
    found : ndarray of bool, shape (n,)
    """
    count, size = profiles.shape
    inside = min(max(1, round(PLATEAU * width / STEP_PX)), size - 1)
    flat, row = profiles.reshape(-1), _rows(count, size)
    low = LOW * level
    foot = (profiles < low[:, None]).argmax(axis=1)
    top = np.maximum(foot - inside, 0)
    top += row
    plateau = flat.take(top)
    plateau += flat.take(np.maximum(top - 1, row))
    # Never above the body's own level: a bright rim must not narrow the body.
    half = np.minimum(np.maximum(plateau / 4, low), level / 2)
    # What darkens the water beside the body, a reflection say, is no part of it.
    beside = profiles[:, size - BESIDE :] @ _HALF_MEAN
    beside *= beside < low / 2
    half += beside
    # The signal falls through half the height between the plateau and the foot.
    near = flat.take(top[:, None] + _counting(inside + 1))
    at = top + (near < half[:, None]).argmax(axis=1)
    found = foot > 0
    found &= at > row
    np.maximum(at, row + 1, out=at)
    high = flat.take(at - 1)
    part = (high - half) / np.maximum(high - flat.take(at), 1e-6)
    np.minimum(np.maximum(part, 0.0, out=part), 1.0, out=part)
    distances = (at - row - 1 + part) * STEP_PX
    distances *= found
    return distances, found


@cache
def _rows(count: int, size: int) -> NDArray[np.int64]:
    """Return where each profile begins."""
    return size * np.arange(count)


@cache
def _counting(size: int) -> NDArray[np.int64]:
    return np.arange(size)
