"""Moves the sharp bends of a path to where the picture ends beyond them.

A hairpin travels: a worm that stretches pushes it on, and one that crawls out of it takes it along.
Its inner edge is not seen, and cross-sections, which fan out there, tell little; its outer edge,
ahead of it, tells where it lies.
"""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Picture
from worm_tracker.midline.cross_sections import interpolate
from worm_tracker.midline.curve import turn_about
from worm_tracker.midline.path import evenly


@dataclass(frozen=True, slots=True)
class SharpBendSettings:
    """Which bends are sharp, and how far one is moved."""

    half_stretch_widths: float = 0.6
    least_turn_rad: float = 1.4
    """Turn over twice that stretch from which on a bend is sharp: its inner edge is not seen."""
    reach_widths: float = 1.0
    """How far to either side of its middle a bend moves."""
    most_move_widths: float = 1.2
    """How far it can be off its place: what smooths a path pulls a hairpin in."""
    slit_behind_widths: float = 0.6
    """How far within a bend there is water, if its inner edge is seen."""
    least_move_with_slit_widths: float = 0.15
    """How far outwards it is moved at least where water within it tells its inner edge: there the
    cross-sections tell its place but for the sharpest bends."""
    beside_widths: float = 0.15
    """How far beside its axis it is looked at, too."""
    step_px: float = 0.5
    edge_over_body_level: float = 0.5
    """Part of the body's level at its edge: the half-height."""


def bends_at_edges(
    signal: Picture,
    curve: Complex,
    half: Floats,
    level: Floats,
    width: float,
    step: float,
    settings: SharpBendSettings,
) -> Complex:
    """Return a path whose sharp bends lie half a width within the edge ahead of them.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    curve : ndarray of complex, shape (n,)
        The path at equal steps, in the window's coordinates.
    half, level : ndarray, shape (n,)
        Half the body's width there, pixels, and the signal on its midline, grey levels.
    width, step : float
        The body's, and the distance of the nodes, pixels.
    settings : SharpBendSettings
    """
    moved = curve
    reach = max(2, round(settings.reach_widths * width / step))
    for k in _sharpest(curve, width, step, settings):
        if not reach <= k < len(curve) - reach:
            continue
        ahead = curve[k] - (curve[k - reach] + curve[k + reach]) / 2
        if abs(ahead) < 0.1 * width:
            continue
        ahead /= abs(ahead)
        bend, way = complex(curve[k]), complex(ahead)
        edge, has_slit = _edge_ahead(signal, bend, way, level[k], width, settings)
        if edge is None:
            continue
        least = settings.least_move_with_slit_widths if has_slit else -settings.most_move_widths
        if not least < (edge - half[k]) / width < settings.most_move_widths:
            continue
        weight = np.sqrt(np.clip(1 - np.abs(np.arange(len(curve)) - k) / reach, 0.0, None))
        moved = moved + weight * (edge - half[k]) * ahead
    return curve if moved is curve else evenly(moved, len(curve))


def _sharpest(curve: Complex, width: float, step: float, settings: SharpBendSettings) -> list[int]:
    """Return the nodes in the middle of each sharp bend."""
    over = max(1, round(settings.half_stretch_widths * width / step))
    within = np.abs(turn_about(curve, over))
    middles: list[int] = []
    if within.max() <= settings.least_turn_rad:
        return middles
    turn = turn_about(curve, 0)
    while within.max() > settings.least_turn_rad:
        k = int(within.argmax())
        near = slice(max(k - over, 0), k + over + 1)
        sizes = np.abs(turn[near])
        middles.append(round(near.start + float(sizes @ np.arange(len(sizes))) / sizes.sum()))
        within[max(k - 3 * over, 0) : k + 3 * over + 1] = 0.0
    return middles


def _edge_ahead(
    signal: Picture,
    bend: complex,
    ahead: complex,
    level: float,
    width: float,
    settings: SharpBendSettings,
) -> tuple[float | None, bool]:
    """Return how far ahead of a bend the picture of the body ends, and whether there is a slit.

    None where it does not end. Water within the bend tells its inner edge.
    """
    most = (0.6 + settings.most_move_widths) * width
    at = np.arange(-settings.slit_behind_widths * width, most, settings.step_px)
    beside = 1j * ahead * settings.beside_widths * width * np.array([-1.0, 0.0, 1.0])
    seen = interpolate(signal, bend + at[:, None] * ahead + beside).mean(axis=1)
    edge = settings.edge_over_body_level * level
    above = seen >= edge
    has_slit = not above[0]
    first = int((at < 0).sum()) if has_slit else 0
    if not above[first] or above[-1]:
        return None, has_slit
    j = first + int((~above[first:]).argmax())
    low, high = float(seen[j]), float(seen[j - 1])
    return float(at[j]) - settings.step_px * (edge - low) / max(high - low, 1e-6), has_slit
