"""What the marks of a skin tell of where an end is.

The marks of what an end lies on differ by as much as the end adds to them, a pale one above all, so
that its darkness alone does not show where it ends; and where a pale one fades, the picture may
lack a part of it. Its marks tell: they are sought where it lies on another part, whose own marks
are known, and where it is seen alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
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

    def in_stretches(self, stop: int, length: int) -> "SeenOnPath":
        """Return the same of each stretch of so many nodes before `stop`, a row each."""
        return SeenOnPath(
            sliding_window_view(self.signal[:stop], length),
            sliding_window_view(self.below[:stop], length),
            sliding_window_view(self.own[:stop], length),
            sliding_window_view(self.border[:stop], length),
            sliding_window_view(self.odds[:stop], length),
        )


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
    so = darkening, level, most, settings, in_water
    behind = _node_odds(seen, seen.own, *so)[: middle + 1]
    inwards = np.append(np.cumsum(behind[::-1])[::-1], 0.0)
    of_end = _node_odds(seen.in_stretches(middle + 1, zone), profile, *so)
    by_darkness = np.cumsum(np.clip(seen.odds[: middle + 1], -most, most)[::-1])[::-1]
    more[:count] = of_end.sum(axis=1) + inwards[zone:] - by_darkness[:count]
    return more


def _node_odds(
    seen: SeenOnPath,
    own: Floats,
    darkening: float,
    level: float,
    most: float,
    settings: EndMarksSettings,
    in_water: bool,
) -> Floats:
    """Return the log odds of a part of such a signal being at each node, over those below it.

    Those by darkness alone where nothing lies below, unless marks count there, too.
    """
    below = seen.below
    adds = np.where(below > 0, darkening * own, own)
    sd2 = (settings.sd_relative * own) ** 2 + (settings.below_sd_relative * below) ** 2
    sd2 = sd2 + (settings.least_sd_relative * level) ** 2
    each = np.clip((seen.signal - below - adds / 2) * adds / sd2, -most, most)
    each = np.where(seen.border, np.minimum(each, 0.0), each)
    return np.where((below > 0) | in_water, each, np.clip(seen.odds, -most, most))


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
