"""Where a body ends on its path: by what is seen of it, by its length, and by where the ends were.

Going outwards along the path each node speaks for the body or against it, as far as its darkness
can: in clear water a body is dark and none is bright, over another part it is darker than that part
alone (or, where overlaps are no darker, nothing can be told). An end is where the body changes to
no body; both are found together, since the length ties them. How wide the likely places are
scattered is how unsure an end is.
"""

from dataclasses import dataclass
from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, slots=True)
class BodyEndsSettings:
    """How much a node's darkness counts, and how an end and a length may change."""

    level_sd_relative: float = 0.2
    """How far the body's darkness scatters, relative to itself."""
    most_log_odds_per_width: float = 12.0
    """Most that a stretch of a width speaks for or against the body: its nodes err together."""
    end_sd_widths: float = 0.4
    """How far an end gets from where its last way takes it, in a frame."""
    back_widths: float = 3.5
    """How far within its last place an end is looked for."""


class BodyEnd(NamedTuple):
    """One end of a body: arc length on the path, and its standard deviation, in pixels."""

    at: float
    sd: float


def find_ends(
    log_odds: Floats,
    step: float,
    width: float,
    expected: tuple[float, float],
    last: tuple[BodyEnd, BodyEnd],
    length: tuple[float, float],
    frames: int,
    settings: BodyEndsSettings,
    end_log_odds: tuple[Floats, Floats] | None = None,
) -> tuple[BodyEnd, BodyEnd]:
    """Find both ends of a body on its path.

    Parameters
    ----------
    log_odds : ndarray, shape (n,)
        Of the body being at each node of the path, by its darkness.
    step, width : float
        Distance of the nodes and width of the body, pixels.
    expected : tuple of float
        Arc lengths at which the two ends are expected.
    last : tuple of BodyEnd
        Where they were, so many `frames` ago, and how surely.
    length : tuple of float
        Expected length and its standard deviation, pixels.
    settings : BodyEndsSettings
    end_log_odds : tuple of ndarray, shape (n,), or None
        What else speaks for either end being at each node.
    """
    n = len(log_odds)
    most = settings.most_log_odds_per_width * step / width
    odds = np.clip(log_odds, -most, most)
    moved = settings.end_sd_widths * width * sqrt(frames)
    sd = hypot(moved, last[0].sd), hypot(moved, last[1].sd)
    back = settings.back_widths * width * sqrt(frames)
    middle = n // 2
    first_back = (max(last[0].at, expected[0]) + max(back, 2 * sd[0])) / step
    stop_back = (min(last[1].at, expected[1]) - max(back, 2 * sd[1])) / step
    first = np.arange(0, int(min(first_back, middle)) + 1)
    stop = np.arange(int(max(stop_back, middle)), n)
    inwards = np.cumsum(odds[: middle + 1][::-1])[::-1]  # sum from a node to the middle
    outwards = np.cumsum(odds[middle:])
    at_first, at_stop = np.asarray(first * step), np.asarray(stop * step)
    for_first = inwards[first] - ((at_first - expected[0]) / sd[0]) ** 2 / 2
    for_stop = outwards[stop - middle] - ((at_stop - expected[1]) / sd[1]) ** 2 / 2
    if end_log_odds is not None:
        for_first = for_first + end_log_odds[0][first]
        for_stop = for_stop + end_log_odds[1][stop]
    return _together(at_first, for_first, at_stop, for_stop, length)


def _together(
    at_first: Floats,
    for_first: Floats,
    at_stop: Floats,
    for_stop: Floats,
    length: tuple[float, float],
) -> tuple[BodyEnd, BodyEnd]:
    """Return the likeliest pair of ends, by what speaks for each and by their distance."""
    off = (at_stop[None, :] - at_first[:, None] - length[0]) / length[1]
    together = for_first[:, None] + for_stop[None, :] - off**2 / 2
    together -= together.max()
    weight = np.exp(together)
    i, j = np.unravel_index(int(together.argmax()), together.shape)
    return (
        BodyEnd(float(at_first[i]), _spread(at_first, weight.sum(axis=1), float(at_first[i]))),
        BodyEnd(float(at_stop[j]), _spread(at_stop, weight.sum(axis=0), float(at_stop[j]))),
    )


def _spread(at: Floats, weight: Floats, best: float) -> float:
    """Return the root mean square distance from the best place."""
    return float(np.sqrt((weight @ (at - best) ** 2) / weight.sum()))
