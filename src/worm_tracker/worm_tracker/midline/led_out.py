"""Leads an end of a body to a piece of its object that is left over: where it has come out.

An end that crosses another part of the body unseen comes out on its far side, where what was
followed does not lie: there it is seen, tip and all.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

import numpy as np

from worm_msgs_py.arrays import Complex, Picture
from worm_tracker.midline.largest_piece import largest_piece
from worm_tracker.midline.path import BodyPath, evenly, nodes_for


@dataclass(frozen=True, slots=True)
class LedOutSettings:
    """Which pieces an end may have come out in, and how it is led there."""

    least_piece_widths2: float = 0.08
    """Area of a piece that may be an end, squared widths."""
    within_tip_px: float = 1.0
    """How far within a piece its end is laid: its outline is beyond what is left of the body."""
    most_cut_widths: float = 10.0
    most_cut_lengths: float = 0.4
    cut_step_widths: float = 0.5
    """How much of an end may be laid anew, and in which steps."""
    most_bend_per_width: float = 1.2
    """How tightly it may bend, radians in a width."""
    most_log_length: float = 0.16
    """How far its length may differ from the body's."""


def led_out(
    path: BodyPath, wanted: Picture, width: float, length: float, settings: LedOutSettings
) -> list[BodyPath]:
    """Return ways of a body either end of which is led to the largest piece that is left over.

    Each on an arc from where it leaves the path that was followed.

    Parameters
    ----------
    path : BodyPath
        In the picture's coordinates.
    wanted : ndarray of uint8, shape (h, w)
        Not zero where a part of the body is missing.
    width, length : float
        The body's, pixels.
    settings : LedOutSettings
    """
    tip = _tip_of_piece(path.curve, wanted, width, settings)
    if tip is None:
        return []
    ways = list[BodyPath]()
    for last_end in (False, True):
        curve = path.curve[::-1] if last_end else path.curve
        for line in _arcs_to(curve, tip, path.step, width, length, settings):
            ways.append(BodyPath(line[::-1] if last_end else line, path.ways))
    return ways


def _tip_of_piece(
    curve: Complex, wanted: Picture, width: float, settings: LedOutSettings
) -> complex | None:
    """Return the point of the largest piece that is farthest from the body; None without one."""
    pixels = largest_piece(wanted)
    if not len(pixels) or len(pixels) < settings.least_piece_widths2 * width**2:
        return None
    near = np.abs(pixels[:, None] - curve[::2]).min(axis=1)
    tip = pixels[near.argmax()]
    inwards = pixels.mean() - tip
    return cast(complex, tip + settings.within_tip_px * inwards / max(abs(inwards), 1e-9))


def _arcs_to(
    curve: Complex,
    tip: complex,
    step: float,
    width: float,
    length: float,
    settings: LedOutSettings,
) -> Iterator[Complex]:
    """Yield the curve with its first end led to a point, cut at one place after the other."""
    most = min(settings.most_cut_widths * width / step, settings.most_cut_lengths * len(curve))
    for cut in np.arange(0, most, settings.cut_step_widths * width / step).astype(int):
        start, behind = curve[cut], curve[min(cut + 3, len(curve) - 1)]
        chord = tip - start
        turn = float(np.angle(chord * (start - behind).conj()))
        distance = abs(chord)
        bend = 2 * np.sin(turn) / max(distance, 1e-9)
        if abs(turn) > np.pi / 2 or abs(bend) * width > settings.most_bend_per_width:
            continue
        way = distance * turn / np.sin(turn) if abs(turn) > 1e-6 else distance
        whole = way + step * (len(curve) - 1 - cut)
        if abs(np.log(whole / length)) > settings.most_log_length:
            continue
        n = max(3, round(way / step) + 1)
        along = np.linspace(0.0, way, n)
        heading = np.angle(start - behind) + bend * (along[1:] + along[:-1]) / 2
        arc = start + np.cumsum(np.exp(1j * heading) * np.diff(along))
        line = np.concatenate([arc[::-1], curve[cut:]])
        yield evenly(line, nodes_for(whole, width))
