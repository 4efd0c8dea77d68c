"""The signal along straight or bent lines, and where on them the body's edge is.

The signal is the light that the body takes away: background minus picture. Two edges are told
apart. The outline is where it falls to half of what it is just inside: all that is body lies within
it, soft flanks included. The half-height edge is where it falls to half of its peak: it tells how
wide a body is, and where it ends.
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask, Picture

PROFILE_STEP_PX = 0.5
"""Distance of the samples on a line: the half-height is found between them."""
_SAMPLES_BESIDE = 3
"""Samples at a line's far end that tell what darkens the water there."""
_HALF_MEAN = np.full(_SAMPLES_BESIDE, 0.5 / _SAMPLES_BESIDE, np.float32)


@dataclass(frozen=True, slots=True)
class EdgeSettings:
    """What counts as the edge of a body on a line across it."""

    plateau_inside_edge_widths: float = 0.25
    """How far inside its edge the body's level is read: a body need not be equally dark across."""
    lowest_signal_over_body_level: float = 0.25
    """Part of the body's level below which there is no body: above noise and reflections."""
    most_peak_over_body_level: float = 1.15
    """What is darker than this, over the level on the midline, counts as this: a dark rim, or
    debris, must not narrow the body."""


class HalfHeightEdges(NamedTuple):
    """Where a body's half-height edge is on each of some lines.

    Attributes
    ----------
    distances : ndarray, shape (n,)
        Pixels; zero where no edge was found.
    found : ndarray of bool, shape (n,)
    heights : ndarray, shape (n,)
        Signal there, grey levels.
    slopes : ndarray, shape (n,)
        How fast it falls there, grey levels a pixel.
    """

    distances: Floats
    found: Mask
    heights: Floats32
    slopes: Floats32


@cache
def distance_powers(first: int, last: int, powers: int = 2) -> Floats32:
    """Return the powers 0, 1, … of the distances from `first` to `last` samples, one a row."""
    t = np.arange(first, last + 1) * PROFILE_STEP_PX
    return np.stack([t**power for power in range(powers)]).astype(np.float32)


def sample_lines(signal: Picture, lines: list[Complex], t: Floats32) -> Floats32:
    """Return the signal along lines, shape (lines, samples); zero outside the window.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
    lines : list of ndarray of complex
        Where each line starts, its direction, and (for bent lines) what goes with the distance's
        square: the terms of a polynomial whose values are u + iv.
    t : ndarray of float32, shape (len(lines), samples)
        Powers of the distance along the line, see `distance_powers`.
    """
    n = len(lines[0])
    terms = np.empty((2 * n, len(lines)), np.float32)
    for k, term in enumerate(lines):
        terms[:n, k], terms[n:, k] = term.real, term.imag
    places = terms @ t
    return cv2.remap(
        signal, places[:n], places[n:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT
    ).astype(np.float32)


def find_half_heights(
    profiles: Floats32,
    level: Floats32,
    reach_px: float,
    settings: EdgeSettings,
    height: float = 0.5,
) -> HalfHeightEdges:
    """Find where each profile first falls below half of its peak.

    Parameters
    ----------
    profiles : ndarray of float32, shape (n, samples)
        From within the body outwards.
    level : ndarray of float32, shape (n,)
        The signal in the body there.
    reach_px : float
        How far inside an edge its peak may be; infinity for anywhere on the profile.
    settings : EdgeSettings
    """
    low = settings.lowest_signal_over_body_level * level
    most = height * settings.most_peak_over_body_level * level
    half = _peaks(profiles, reach_px)
    half *= height
    np.maximum(half, low[:, None], out=half)
    np.minimum(half, most[:, None], out=half)
    half += _half_reflection(profiles, low)[:, None]
    at = (profiles < half).argmax(axis=1)
    found = at > 0
    np.maximum(at, 1, out=at)
    row = _rows(*profiles.shape)
    at += row
    level_there = half[:, 0] if half.shape[1] == 1 else half.reshape(-1).take(at)
    flat = profiles.reshape(-1)
    high = flat.take(at - 1)
    fall = np.maximum(high - flat.take(at), 1e-6)
    part = np.minimum(np.maximum((high - level_there) / fall, 0.0), 1.0)
    distances = (at - row - 1 + part) * PROFILE_STEP_PX
    distances *= found
    return HalfHeightEdges(distances, found, level_there, fall / PROFILE_STEP_PX)


def _peaks(profiles: Floats32, reach_px: float) -> Floats32:
    """Return the peak within a reach before each sample, or, shape (n, 1), of all of a profile."""
    if np.isinf(reach_px):  # every second sample: a peak is flat
        pairs = profiles[:, 1::2] + profiles[:, : profiles.shape[1] - 1 : 2]
        return np.asarray(pairs.max(axis=1, keepdims=True) / 2, np.float32)
    reach = min(round(reach_px / PROFILE_STEP_PX), profiles.shape[1] - 1)
    pairs = profiles.copy()
    pairs[:, 1:] += profiles[:, :-1]
    pairs[:, 0] *= 2
    kernel = np.full((1, reach + 1), 1, np.uint8)
    return np.asarray(cv2.dilate(pairs, kernel, anchor=(reach, 0)) / 2, np.float32)


def find_outline(
    profiles: Floats32, level: Floats32, width: float, settings: EdgeSettings
) -> tuple[Floats, Mask]:
    """Return the distance at which each profile falls through half of what it is just inside.

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
    settings : EdgeSettings

    Returns
    -------
    distances : ndarray, shape (n,)
        Pixels; zero where no edge was found.
    found : ndarray of bool, shape (n,)
    """
    size = profiles.shape[1]
    inside = settings.plateau_inside_edge_widths * width / PROFILE_STEP_PX
    inside = min(max(1, round(inside)), size - 1)
    low = settings.lowest_signal_over_body_level * level
    foot = (profiles < low[:, None]).argmax(axis=1)
    row = _rows(*profiles.shape)
    top = np.maximum(foot - inside, 0)
    top += row
    half = _half_heights(profiles, top, level, low)
    # The signal falls through half the height between the plateau and the foot.
    flat = profiles.reshape(-1)
    near = flat.take(top[:, None] + _counting(inside + 1))
    at = top + (near < half[:, None]).argmax(axis=1)
    found = foot > 0
    found &= at > row
    np.maximum(at, row + 1, out=at)
    high = flat.take(at - 1)
    part = (high - half) / np.maximum(high - flat.take(at), 1e-6)
    np.minimum(np.maximum(part, 0.0, out=part), 1.0, out=part)
    distances = (at - row - 1 + part) * PROFILE_STEP_PX
    distances *= found
    return distances, found


def _half_heights(
    profiles: Floats32, top: NDArray[np.int64], level: Floats32, low: Floats32
) -> Floats32:
    """Return half of each profile's signal just within its edge, above what lies beside."""
    count, size = profiles.shape
    flat = profiles.reshape(-1)
    plateau = flat.take(top)
    plateau += flat.take(np.maximum(top - 1, _rows(count, size)))
    # Never above the body's own level: a bright rim must not narrow the body.
    half = np.minimum(np.maximum(plateau / 4, low), level / 2)
    half += _half_reflection(profiles, low)
    return half


def _half_reflection(profiles: Floats32, low: Floats32) -> Floats32:
    """Return half of what darkens the water beside the body, a reflection say: no part of it."""
    beside = profiles[:, profiles.shape[1] - _SAMPLES_BESIDE :] @ _HALF_MEAN
    beside *= beside < low / 2
    return np.asarray(beside, np.float32)


@cache
def _rows(count: int, size: int) -> NDArray[np.int64]:
    """Return where each profile begins."""
    return size * np.arange(count)


@cache
def _counting(size: int) -> NDArray[np.int64]:
    return np.arange(size)
