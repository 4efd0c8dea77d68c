"""Cross-sections of a body that may lie on itself: where their middle is, and whether that is seen.

A cross-section with both edges a body's width apart tells its middle. One that merges with another
part of the body at one side still has its other edge, half a known width from the middle. One that
has no edge where the body's could be tells nothing.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
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
    middle, either : ndarray of bool, shape (n,)
        On the path itself: surely, and perhaps (its edge is near).
    inside, outside : ndarray of bool, shape (n, 2)
        Just within and just beyond the body's edge, on the left and on the right.
    level, level_sd : float
        Signal of another part, grey levels, and how far that of some part differs from it.
    darkening : float
        What a part adds to the signal of one that it lies on, over its own; 0 where nothing.
    """

    middle: Mask
    either: Mask
    inside: Mask
    outside: Mask
    level: float
    level_sd: float
    darkening: float

    @classmethod
    def none(cls, n: int) -> "Covers":
        """Return that no part lies over another."""
        line, sides = np.zeros(n, np.bool_), np.zeros((n, 2), np.bool_)
        return cls(line, line, sides, sides, 0.0, 0.0, 0.0)


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
    core_nodes = round(settings.level_half_width_widths * width / PROFILE_STEP_PX)
    spine_nodes = round(settings.level_half_width_at_tip_px / PROFILE_STEP_PX)
    core, spine = (
        profiles[:, reach - k : reach + k + 1].mean(axis=1)
        for k in (max(1, core_nodes), spine_nodes)
    )
    node = np.arange(len(path))
    tip = (node < tip_nodes) | (node >= len(path) - tip_nodes)
    own = np.clip(core, settings.lowest_level_over_known * level, level)
    own = np.where(covers.middle, level, own)
    left, right = (
        _edges_of_profiles(outwards, *_edge_height(own, covers, side, settings), half, tip)
        for side, outwards in enumerate((profiles[:, reach::-1], profiles[:, reach:]))
    )
    body = core > settings.edge_over_body_level * level
    shift, weight = _middles(left, right, half, body, width, tip, settings)
    return CrossSections(shift, weight, spine)


def _middles(
    left: Floats,
    right: Floats,
    half: Floats,
    body: Mask,
    width: float,
    tip: Mask,
    settings: CrossSectionSettings,
) -> tuple[Floats, Floats]:
    """Return how far to the side the middle of each cross-section is, and one over its variance."""
    n = len(half)
    across = right + left
    gate = settings.most_width_difference_widths * width
    both = body & np.where(tip, across < width + gate, np.abs(across - 2 * half) < gate)
    shift = np.zeros(n)
    shift[both] = (right[both] - left[both]) / 2
    weight = np.where(both, (settings.two_edges_sd_widths * width) ** -2, 0.0)
    # Of two edges that do not make the body's width, the one nearer to its place is believed.
    off_right, off_left = right - half, half - left
    lone = np.where(np.abs(off_right) <= np.abs(off_left), off_right, off_left)
    one = body & ~both & ~tip & (np.abs(lone) < settings.most_one_edge_shift_widths * width)
    shift[one] = lone[one]
    weight[one] = (settings.one_edge_sd_widths * width) ** -2
    return shift, weight


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


def _edges_of_profiles(
    profiles: Floats32, threshold: Floats, seen: Mask, half: Floats, tip: Mask
) -> Floats:
    """Return where each profile, from the middle outwards, has its edge; infinity for none."""
    edges = np.empty(len(profiles))
    _find_edges(profiles, threshold, seen, half / PROFILE_STEP_PX, tip, edges)
    return PROFILE_STEP_PX * edges


def _edge_height(
    own: Floats, covers: Covers, side: int, settings: CrossSectionSettings
) -> tuple[Floats, Mask]:
    """Return the signal half-way over each edge of the body, and where there is none to be seen."""
    inside, outside = covers.inside[:, side], covers.outside[:, side]
    # Where the body lies on another part it is darker, and its edge is that of what it adds.
    above = np.where(inside, covers.level + covers.darkening * own, own)
    below = np.where(outside, covers.level, 0.0)
    seen = above - below > settings.least_darkening * own
    return below + settings.edge_over_body_level * (above - below), seen


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.float64),
    array_read(types.boolean),
    array_read(types.float64),
    array_read(types.boolean),
    array_written(types.float64),
)
def _find_edges(
    profiles: Floats32, threshold: Floats, seen: Mask, half: Floats, tip: Mask, edges: Floats
) -> None:
    """Fill in where each profile falls below its threshold, nearest to where its edge should be.

    At a tip, whose width is not known, where it first does; infinity where it does not. In steps of
    the profiles, as `half` the width is.
    """
    for node in range(len(profiles)):
        edges[node] = np.inf
        if not seen[node]:
            continue
        profile, height = profiles[node], threshold[node]
        expected = 0.0 if tip[node] else half[node] - 0.5
        nearest = np.inf
        for k in range(len(profile) - 1):
            if profile[k] >= height > profile[k + 1] and abs(k - expected) < nearest:
                nearest = abs(k - expected)
                part = (profile[k] - height) / (profile[k] - profile[k + 1])
                edges[node] = k + part
