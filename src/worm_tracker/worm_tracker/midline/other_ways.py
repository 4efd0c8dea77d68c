"""Other ways in which a body may lie that no longer explains its picture.

What was followed the wrong way through a fold shows it later: an end comes out of the fold where
none was expected, or a loop opens that leads through water. Such an error is undone in one or two
steps: a loop is passed the other way round, or an end that was thought to lie further on, on
another strand, is where the path leaves the object.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Picture
from worm_tracker.midline.curve import TRACKED_POINTS
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.strand_exchange import exchanges, turned_at_end
from worm_tracker.midline.strand_meetings import StrandExchangeSettings


@dataclass(frozen=True, slots=True)
class OtherWaysSettings:
    """Which steps are taken, and which ways are told apart."""

    most_cut_widths: float = 12.0
    most_cut_lengths: float = 0.4
    """How much of a body may lie beyond the place where its path leaves the object."""
    least_cut_widths: float = 1.0
    """How much at least: the last stretch of a path is laid anew otherwise."""
    cut_within_widths: float = 0.3
    """How far within the object such a path is cut."""
    alike_widths: float = 0.5
    """Ways that lie as near to each other all along are the same."""


def other_ways(
    path: BodyPath,
    mask: Picture,
    width: float,
    exchange: StrandExchangeSettings,
    settings: OtherWaysSettings,
) -> list[BodyPath]:
    """Return the ways that are one step from a path, no two alike.

    Parameters
    ----------
    path : BodyPath
        In the mask's coordinates.
    mask : ndarray of uint8, shape (h, w)
        The object; 0 where it is not.
    width : float
        The body's, pixels.
    exchange : StrandExchangeSettings
        Where its strands meet.
    settings : OtherWaysSettings
    """
    ways = [path]
    for way in _one_step(path, mask, width, exchange, settings):
        add_if_new(ways, way, width, settings)
    return ways[1:]


def add_if_new(
    ways: list[BodyPath], way: BodyPath, width: float, settings: OtherWaysSettings
) -> bool:
    """Add a way to some others unless it is like one of them; tell whether it was added."""
    nearest = min((np.abs(way.points - known.points).max() for known in ways), default=np.inf)
    if nearest < settings.alike_widths * width:
        return False
    ways.append(way)
    return True


def _one_step(
    path: BodyPath,
    mask: Picture,
    width: float,
    exchange: StrandExchangeSettings,
    settings: OtherWaysSettings,
) -> Iterator[BodyPath]:
    for last_end in (False, True):
        for way in (
            turned_at_end(path, width, last_end, exchange),
            _ended_at_water(path, mask, width, last_end, settings),
        ):
            if way is not None:
                yield way
    yield from exchanges(path, width, exchange)


def _ended_at_water(
    path: BodyPath, mask: Picture, width: float, last_end: bool, settings: OtherWaysSettings
) -> BodyPath | None:
    """Return a path that ends where it leaves the object on its way to an end; None if it stays."""
    curve = path.curve if last_end else path.curve[::-1]
    height, across = mask.shape
    u = np.rint(curve.real).astype(int).clip(0, across - 1)
    v = np.rint(curve.imag).astype(int).clip(0, height - 1)
    most = settings.most_cut_widths * width / path.step
    first = len(curve) - int(min(most, settings.most_cut_lengths * len(curve)))
    in_water = np.flatnonzero(mask[v[first:], u[first:]] == 0)
    if not len(in_water):
        return None
    end = first + int(in_water[0]) - max(1, round(settings.cut_within_widths * width / path.step))
    if (len(curve) - 1 - end) * path.step < settings.least_cut_widths * width:
        return None
    nodes = max(nodes_for(end * path.step, width), TRACKED_POINTS)
    line = evenly(curve[: end + 1], nodes)
    return BodyPath(line if last_end else line[::-1])
