"""Cross-sections of a body that may lie on itself: where their middle is, and whether that is seen.

A cross-section with both edges a body's width apart tells its middle. One that merges with another
part of the body at one side still has its other edge, half a known width from the middle. One that
has no edge where the body's could be tells nothing.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.curve import tangents
from worm_tracker.midline.edges import PROFILE_STEP_PX


@dataclass(frozen=True, slots=True)
class CrossSectionSettings:
    """Where the edges of a body that may touch itself are looked for, and how far one is trusted.

    The standard deviations were measured on simulated coils.
    """

    edge_reach_widths: float = 0.95
    """How far to either side edges are looked for: as far as a body that moved sideways can be."""
    level_half_width_widths: float = 0.2
    """How far to either side of its middle the body's level is averaged."""
    level_half_width_at_tip_px: float = 1.0
    """The same where the body ends: a tip is narrow."""
    edge_over_body_level: float = 0.5
    """Part of the body's level at its edge: the half-height."""
    lowest_level_over_known: float = 0.4
    """Least level of the body over the known one that the edge's height is taken from."""
    two_edges_sd_widths: float = 0.03
    """Error of a cross-section's middle where both its edges are seen."""
    one_edge_sd_widths: float = 0.08
    """The same where only one is."""
    most_width_difference_widths: float = 0.3
    """Most that the distance of two edges differs from the known width, if both are the body's."""
    least_darkening: float = 0.15
    """Darkening of an overlap from which on edges within it are seen."""
    most_one_edge_shift_widths: float = 0.3
    """Most that one edge alone may be off its place: farther off it is another part's."""


@dataclass(frozen=True, eq=False, slots=True)
class Covers:
    """Where other parts of the body lie over the points of a path.

    Attributes
    ----------
    layers : ndarray of uint8, shape (n,)
        How many surely lie over the path itself.
    either : ndarray of bool, shape (n,)
        Where one lies over it perhaps: its edge is near.
    inside, outside : ndarray of bool, shape (n, 2)
        Just within and just beyond the body's edge, on the left and on the right.
    level, level_sd : float
        Signal of another part, grey levels, and how far that of some part differs from it.
    darkening : float
        What a part adds to the signal of one that it lies on, over its own; 0 where nothing.
    """

    layers: NDArray[np.uint8]
    either: Mask
    inside: Mask
    outside: Mask
    level: float
    level_sd: float
    darkening: float

    @property
    def middle(self) -> Mask:
        """Where one surely lies over the path itself, shape (n,)."""
        return self.layers > 0

    @classmethod
    def none(cls, n: int) -> "Covers":
        """Return that no part lies over another."""
        line, sides = np.zeros(n, np.bool_), np.zeros((n, 2), np.bool_)
        return cls(np.zeros(n, np.uint8), line, sides, sides, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, slots=True)
class CrossSections:
    """What is seen across a path, at each of its nodes.

    Attributes
    ----------
    shift : ndarray, shape (n,)
        How far to the side of the path the body's middle is, pixels; 0 where that is not seen.
    weight : ndarray, shape (n,)
        One over that number's variance; 0 where it is not seen.
    spine : ndarray, shape (n,)
        Signal on the path, grey levels.
    """

    shift: Floats
    weight: Floats
    spine: Floats32


def cross_sections(
    signal: Picture,
    path: Complex,
    half: Floats,
    level: Floats,
    width: float,
    tip_nodes: int,
    covers: Covers,
    settings: CrossSectionSettings,
) -> CrossSections:
    """Look for a body's edges across a path.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    path : ndarray of complex, shape (n,)
        u + iv in the signal's coordinates.
    half : ndarray, shape (n,)
        Half the width that the body is expected to have.
    level : ndarray, shape (n,)
        Signal that the midline is expected to have, grey levels.
    width : float
        The body's width, pixels.
    tip_nodes : int
        Nodes at either end at which the body may taper off in a way that is not known yet.
    covers : Covers
        Where other parts of the body lie over this one.
    settings : CrossSectionSettings
    """
    reach = int(settings.edge_reach_widths * width / PROFILE_STEP_PX) + 1
    offsets = PROFILE_STEP_PX * np.arange(-reach, reach + 1, dtype=np.float64)
    profiles = _across(signal, path, 1j * tangents(path), offsets)
    n = len(path)
    shift, weight, spine = np.zeros(n), np.zeros(n), np.empty(n, np.float32)
    seen = _Sections(profiles, half, level, covers.middle, covers.inside, covers.outside)
    _measure(*seen, _measuring(width, tip_nodes, covers, settings), shift, weight, spine)
    return CrossSections(shift, weight, spine)


class _Sections(NamedTuple):
    """Profiles across a path, and what is expected at each of its nodes."""

    profiles: Floats32
    half: Floats
    level: Floats
    middle: Mask
    inside: Mask
    outside: Mask


class _Measuring(NamedTuple):
    """How profiles are measured: numbers of their steps, grey levels, pixels."""

    core_nodes: int
    spine_nodes: int
    tip_nodes: int
    width: float
    cover_level: float
    darkening: float
    edge_over_level: float
    lowest_over_level: float
    least_darkening: float
    most_width_difference_px: float
    most_one_edge_shift_px: float
    two_edges_weight: float
    one_edge_weight: float


def _measuring(
    width: float, tip_nodes: int, covers: Covers, settings: CrossSectionSettings
) -> _Measuring:
    core_nodes = round(settings.level_half_width_widths * width / PROFILE_STEP_PX)
    return _Measuring(
        max(1, core_nodes),
        round(settings.level_half_width_at_tip_px / PROFILE_STEP_PX),
        tip_nodes,
        width,
        covers.level,
        covers.darkening,
        settings.edge_over_body_level,
        settings.lowest_level_over_known,
        settings.least_darkening,
        settings.most_width_difference_widths * width,
        settings.most_one_edge_shift_widths * width,
        (settings.two_edges_sd_widths * width) ** -2,
        (settings.one_edge_sd_widths * width) ** -2,
    )


def _across(signal: Picture, path: Complex, normal: Complex, offsets: Floats) -> Floats32:
    """Return a signal at some distances from each node of a path, along its normal."""
    profiles = np.empty((len(path), len(offsets)), np.float32)
    _sample_across(signal, path, normal, offsets, profiles)
    return profiles


@compiled_for(
    array_read(types.uint8, 2),
    array_read(types.complex128),
    array_read(types.complex128),
    array_read(types.float64),
    array_written(types.float32, 2),
)
def _sample_across(
    signal: Picture, path: Complex, normal: Complex, offsets: Floats, profiles: Floats32
) -> None:
    """Fill in a signal at some distances from each node of a path, along its normal.

    In whole grey levels, between the pixels as OpenCV has it; zero outside.
    """
    h, w = signal.shape
    for node in range(len(path)):
        u0, v0, along_u, along_v = (
            path[node].real, path[node].imag, normal[node].real, normal[node].imag,
        )  # fmt: skip
        for k in range(len(offsets)):
            u, v = u0 + along_u * offsets[k], v0 + along_v * offsets[k]
            if not (-1 < u < w and -1 < v < h):
                profiles[node, k] = 0
                continue
            left, top = int(np.floor(u)), int(np.floor(v))
            part_u, part_v = u - left, v - top
            seen = 0.0
            if 0 <= left < w - 1 and 0 <= top < h - 1:
                upper = (1 - part_u) * signal[top, left] + part_u * signal[top, left + 1]
                lower = (1 - part_u) * signal[top + 1, left] + part_u * signal[top + 1, left + 1]
                seen = (1 - part_v) * upper + part_v * lower
            else:
                for row, part_row in ((top, 1 - part_v), (top + 1, part_v)):
                    for column, part in ((left, 1 - part_u), (left + 1, part_u)):
                        if 0 <= row < h and 0 <= column < w:
                            seen += part * part_row * signal[row, column]
            profiles[node, k] = np.rint(seen)


def interpolate(signal: Picture, where: Complex) -> Floats32:
    """Return a signal between its pixels, at u + iv; zero outside."""
    at = where.astype(np.complex64).view(np.float32).reshape(*where.shape, 2)
    return _interpolated(signal, at)


def _interpolated(signal: Picture, at: Floats32) -> Floats32:
    """Return a signal between its pixels, at (u, v); zero outside."""
    values = cv2.remap(  # the stubs do not know that pairs need no second map
        signal,
        at,
        None,  # type: ignore[call-overload]
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
    )
    return np.asarray(values, np.float32)


@compiled
def _mean_about(profile: Floats32, middle: int, reach: int) -> np.float32:
    """Return the mean of a profile about its middle; its values are whole, so that sums are."""
    total = np.float32(0.0)
    for k in range(middle - reach, middle + reach + 1):
        total += profile[k]
    return np.float32(total / np.float32(2 * reach + 1))


@compiled
def _edge_height(own: float, inside: bool, outside: bool, how: _Measuring) -> float:
    """Return the signal half-way over an edge of the body; infinity where none is to be seen."""
    # Where the body lies on another part it is darker, and its edge is that of what it adds.
    above = how.cover_level + how.darkening * own if inside else own
    below = how.cover_level if outside else 0.0
    if above - below > how.least_darkening * own:
        return below + how.edge_over_level * (above - below)
    return np.inf


@compiled
def _edge(profile: Floats32, outwards: int, height: float, half: float, tip: bool) -> float:
    """Return where a profile falls below a height, nearest to where its edge should be, in steps.

    At a tip, whose width is not known, where it first does; infinity where it does not. From its
    middle to the one side or the other (`outwards` 1 or -1).
    """
    middle = len(profile) // 2
    expected = 0.0 if tip else half - 0.5
    nearest, edge = np.inf, np.inf
    for k in range(middle):
        near, next_one = profile[middle + outwards * k], profile[middle + outwards * (k + 1)]
        if near >= height > next_one and abs(k - expected) < nearest:
            nearest = abs(k - expected)
            edge = k + (near - height) / (near - next_one)
    return edge


@compiled
def _middle_of(
    left: float, right: float, half: float, tip: bool, how: _Measuring
) -> tuple[float, float]:
    """Return how far to the side the middle of a cross-section is, and one over its variance."""
    across, gate = right + left, how.most_width_difference_px
    both = across < how.width + gate if tip else abs(across - 2 * half) < gate
    if both:
        return (right - left) / 2, how.two_edges_weight
    # Of two edges that do not make the body's width, the one nearer to its place is believed.
    off_right, off_left = right - half, half - left
    lone = off_right if abs(off_right) <= abs(off_left) else off_left
    if not tip and abs(lone) < how.most_one_edge_shift_px:
        return lone, how.one_edge_weight
    return 0.0, 0.0


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.float64),
    array_read(types.float64),
    array_read(types.boolean),
    array_read(types.boolean, 2),
    array_read(types.boolean, 2),
    types.NamedTuple((types.int64,) * 3 + (types.float64,) * 10, _Measuring),
    array_written(types.float64),
    array_written(types.float64),
    array_written(types.float32),
)
def _measure(
    profiles: Floats32,
    half: Floats,
    level: Floats,
    covered: Mask,
    inside: Mask,
    outside: Mask,
    how: _Measuring,
    shift: Floats,
    weight: Floats,
    spine: Floats32,
) -> None:
    """Fill in what is seen across each node; `shift` and `weight` are zero before."""
    n, middle = len(profiles), profiles.shape[1] // 2
    for k in range(n):
        profile, tip = profiles[k], k < how.tip_nodes or k >= n - how.tip_nodes
        core = _mean_about(profile, middle, how.core_nodes)
        spine[k] = _mean_about(profile, middle, how.spine_nodes)
        if not core > how.edge_over_level * level[k]:
            continue
        own = min(max(core, how.lowest_over_level * level[k]), level[k])
        own = level[k] if covered[k] else own
        steps = half[k] / PROFILE_STEP_PX
        height = _edge_height(own, inside[k, 0], outside[k, 0], how)
        left = PROFILE_STEP_PX * _edge(profile, -1, height, steps, tip)
        height = _edge_height(own, inside[k, 1], outside[k, 1], how)
        right = PROFILE_STEP_PX * _edge(profile, 1, height, steps, tip)
        shift[k], weight[k] = _middle_of(left, right, half[k], tip, how)
