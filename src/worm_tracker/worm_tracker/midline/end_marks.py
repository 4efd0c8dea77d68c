"""What the marks of a skin tell of where an end is.

The marks of what an end lies on differ by as much as the end adds to them, a pale one above all, so
that its darkness alone does not show where it ends; and where a pale one fades, the picture may
lack a part of it. Its marks tell: they are sought where it lies on another part, whose own marks
are known, and where it is seen alone.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.cross_sections import interpolate


@dataclass(frozen=True, slots=True)
class EndMarksSettings:
    """How much of an end is compared, and how far it may differ from what is known of it."""

    widths: float = 4.0
    """How much of an end is compared."""
    sd_relative: float = 0.2
    below_sd_relative: float = 0.1
    least_sd_relative: float = 0.06
    """How far a place of the end scatters over its signal, one of what it lies on over that, and
    any over the signal of most of the body."""
    tip_widths: float = 0.4
    """How much of the tip is left out where it is seen alone: the lens blurs it."""
    least_relative: float = 0.15
    """How far the signal of an end differs along it, over itself, from which on it has marks."""
    step_widths: float = 0.25
    """Distance of the places that are compared there."""
    seen_sd_relative: float = 0.12
    seen_sd_grey: float = 3.0
    """Scatter of the signal there, over it, and at least."""
    most_brighter: float = 1.6
    """How many times as strong as is known the signal may be there, or over how many times."""
    least_cut_widths: float = 1.0
    most_cut_widths: float = 15.0
    most_cut_lengths: float = 0.4
    """How much of the end may be lacking."""


def has_marks(levels: Floats, length: float, width: float, settings: EndMarksSettings) -> bool:
    """Tell whether the first end of a body has marks, by the signal along it from that end."""
    step = length / (len(levels) - 1)
    first, last = (
        round(widths * width / step) for widths in (settings.tip_widths, settings.widths)
    )
    end = levels[max(first, 1) : last + 1]
    if len(end) < 2:
        return False
    return float(np.std(end)) > settings.least_relative * max(float(np.median(end)), 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class SeenOnPath:
    """What is seen at the nodes of a path, and known of them; of its first half at least.

    Attributes
    ----------
    signal : ndarray, shape (n,)
        On the path.
    below : ndarray, shape (n,)
        Signal of the parts that lie over it; 0 where none does.
    own : ndarray, shape (n,)
        Signal of the part that is thought to be there.
    border : ndarray of bool, shape (n,)
        Where the edge of another part is so near that nothing speaks for a body.
    odds : ndarray, shape (n,)
        Log odds of a body being there by its darkness alone.
    """

    signal: Floats
    below: Floats
    own: Floats
    border: Mask
    odds: Floats

    def turned(self) -> "SeenOnPath":
        """Return the same from the path's other end."""
        return SeenOnPath(
            self.signal[::-1], self.below[::-1], self.own[::-1], self.border[::-1], self.odds[::-1]
        )


class _NodeNumbers(NamedTuple):
    """What compiled functions ask for, as of `more_by_marks` and its settings."""

    darkening: float
    sd_relative: float
    below_sd_relative: float
    least_sd2: float
    most: float
    in_water: bool


def more_by_marks(
    seen: SeenOnPath,
    profile: Floats,
    darkening: float,
    level: float,
    most: float,
    settings: EndMarksSettings,
    *,
    in_water: bool = True,
) -> Floats:
    """Return for each node what marks say more of a path's first end being there than its odds do.

    Parameters
    ----------
    seen : SeenOnPath
    profile : ndarray, shape (m,)
        Signal of one layer at the nodes from an end onwards.
    darkening, level, most : float
        What a part adds to what it lies on, over its own signal; that of most of the body; and the
        most that a node speaks for or against.
    settings : EndMarksSettings
    in_water : bool
        Whether they count where no other part lies, too.

    Returns
    -------
    ndarray, shape (n,)
        Log odds; 0 beyond the nodes that can be an end.
    """
    n, zone = len(seen.signal), len(profile)
    middle = n // 2
    count = middle + 2 - zone
    more = np.zeros(n)
    if count <= 0:
        return more
    numbers = _NodeNumbers(
        darkening,
        settings.sd_relative,
        settings.below_sd_relative,
        (settings.least_sd_relative * level) ** 2,
        most,
        in_water,
    )
    behind, of_end = np.empty(middle + 1), np.empty((count, zone))
    on_path = seen.signal, seen.below, seen.own, seen.border, seen.odds
    _fill_odds(*on_path, profile, numbers, behind, of_end)
    inwards = np.append(np.cumsum(behind[::-1])[::-1], 0.0)
    by_darkness = np.cumsum(np.clip(seen.odds[: middle + 1], -most, most)[::-1])[::-1]
    more[:count] = of_end.sum(axis=1) + inwards[zone:] - by_darkness[:count]
    return more


@compiled
def _odds_of_node(
    signal: float, below: float, own: float, border: bool, odds: float, how: _NodeNumbers
) -> float:
    """Return the log odds of a part of such a signal being at a node, over those below it.

    Those by darkness alone where nothing lies below, unless marks count there, too.
    """
    if not (below > 0 or how.in_water):
        return float(min(max(odds, -how.most), how.most))
    adds = how.darkening * own if below > 0 else own
    sd2 = (how.sd_relative * own) ** 2 + (how.below_sd_relative * below) ** 2 + how.least_sd2
    speaks = min(max((signal - below - adds / 2) * adds / sd2, -how.most), how.most)
    return float(min(speaks, 0.0) if border else speaks)


@compiled_for(
    array_read(types.float64),
    array_read(types.float64),
    array_read(types.float64),
    array_read(types.boolean),
    array_read(types.float64),
    array_read(types.float64),
    types.NamedTuple((types.float64,) * 5 + (types.boolean,), _NodeNumbers),
    array_written(types.float64),
    array_written(types.float64, 2),
)
def _fill_odds(
    signal: Floats,
    below: Floats,
    own: Floats,
    border: Mask,
    odds: Floats,
    profile: Floats,
    how: _NodeNumbers,
    behind: Floats,
    of_end: Floats,
) -> None:
    """Fill in the log odds of a node, and those of the end's nodes where it begins at each."""
    for k in range(len(behind)):
        behind[k] = _odds_of_node(signal[k], below[k], own[k], border[k], odds[k], how)
    first_nodes, zone = of_end.shape
    for first in range(first_nodes):
        for node in range(zone):
            k = first + node
            of_end[first, node] = _odds_of_node(
                signal[k], below[k], profile[node], border[k], odds[k], how
            )


def log_odds_of_whole_end(
    signal: Picture,
    curve: Complex,
    levels: Floats,
    length: float,
    width: float,
    settings: EndMarksSettings,
) -> float:
    """Return the log odds of a path's first end being that of the body, and not one cut short.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
    curve : ndarray of complex, shape (n,)
        At equal steps in the signal's coordinates.
    levels : ndarray, shape (m,)
        Signal of one layer on the midline at equal steps from that end.
    length, width : float
        The body's, pixels.
    settings : EndMarksSettings
    """
    behind = np.arange(settings.tip_widths, settings.widths, settings.step_widths) * width
    at = np.arange(len(curve)) * float(np.abs(np.diff(curve)).mean())
    line = np.interp(behind, at, curve.real) + 1j * np.interp(behind, at, curve.imag)
    seen = interpolate(signal, line[:, None])[:, 0].astype(np.float64)
    most = min(settings.most_cut_widths * width, settings.most_cut_lengths * length)
    cut = np.append(0.0, np.arange(settings.least_cut_widths * width, most, 0.5 * width))
    known = np.interp(behind + cut[:, None], np.linspace(0, length, len(levels)), levels)
    brighter = (known @ seen) / np.maximum((known**2).sum(axis=1), 1e-9)
    brighter = np.clip(brighter, 1 / settings.most_brighter, settings.most_brighter)
    off = ((seen - brighter[:, None] * known) ** 2).sum(axis=1)
    sd2 = (settings.seen_sd_relative * float(np.median(seen))) ** 2 + settings.seen_sd_grey**2
    return float(off[1:].min(initial=np.inf) - off[0]) / (2 * sd2)
