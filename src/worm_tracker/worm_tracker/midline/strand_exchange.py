"""Tells by its bends whether two strands of a body that meet cross each other or turn back.

Both cover the same of the picture. A body goes on as straight as it can: where its strands bend to
get past each other, it is the other way, and what lies between them is passed the other way round;
or two strands that lead to the same places are passed in the other order (`strand_order.py`).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_meetings import (
    StrandExchangeSettings,
    joint_nodes,
    meetings,
    turn_nodes,
    turned2,
    window_nodes,
)
from worm_tracker.midline.strand_order import other_orders


@dataclass(frozen=True, slots=True)
class DoubtfulLoop:
    """A loop of which the picture does not tell which way round it is passed.

    Or a part of the body of which it does not tell in which order it is.

    Attributes
    ----------
    first, last : float
        Where it begins and ends, parts of the body's length: the rest lies alike either way.
    breadth_px : float
        How far a part of the body lies elsewhere the other way.
    """

    first: float
    last: float
    breadth_px: float


def exchanged_strands(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> tuple[BodyPath | None, float]:
    """Return a path that goes on straighter where two of its strands meet; None where none does.

    How much straighter is returned, too: the sum of the squared turns there that it has less, rad².

    Parameters
    ----------
    path : BodyPath
    width : float
        The body's, pixels.
    settings : StrandExchangeSettings
    """
    best, exchanged = settings.least_gain_rad2, None
    for gain, _, again in _loops_between_strands(path, width, settings):
        if gain > best:
            best, exchanged = gain, again
    return (None, 0.0) if exchanged is None else (BodyPath(exchanged), best)


def exchanges(path: BodyPath, width: float, settings: StrandExchangeSettings) -> list[BodyPath]:
    """Return the paths with two strands exchanged, one for each place where two meet.

    And those that pass two strands in the other order.
    """
    return [BodyPath(again) for _, _, again in _loops_between_strands(path, width, settings)]


def doubtful_loops(
    path: BodyPath,
    width: float,
    settings: StrandExchangeSettings,
    least_gain_rad2: float = 0.0,
    least_breadth_widths: float = 1.0,
) -> list[DoubtfulLoop]:
    """Return the loops that are straighter if passed the other way round.

    The picture shows the same then, but a part of the body lies elsewhere. A loop may lie between
    two strands that meet, or between an end and the strand that it lies on.

    Parameters
    ----------
    path : BodyPath
    width : float
        The body's, pixels.
    settings : StrandExchangeSettings
    least_gain_rad2 : float
        How much straighter at least: less than 0 for ways that bend little more, too.
    least_breadth_widths : float
        Breadth of the loops that are left out.
    """
    return [
        loop
        for gain, loop, _ in _loops(path, width, settings)
        if gain > least_gain_rad2 and loop.breadth_px > least_breadth_widths * width
    ]


def loops_otherwise(
    path: BodyPath, width: float, settings: StrandExchangeSettings, least_breadth_widths: float
) -> list[tuple[DoubtfulLoop, BodyPath]]:
    """Return all loops broader than that, each with the path that passes it the other way round."""
    return [
        (loop, BodyPath(again))
        for _, loop, again in _loops(path, width, settings)
        if loop.breadth_px > least_breadth_widths * width
    ]


def part_of(loops: list[DoubtfulLoop]) -> tuple[float, float] | None:
    """Return the part of the body's length that lies in some loops, or between them."""
    if not loops:
        return None
    return min(loop.first for loop in loops), max(loop.last for loop in loops)


def turned_at_end(
    path: BodyPath, width: float, last_end: bool, settings: StrandExchangeSettings
) -> BodyPath | None:
    """Return a path whose loop between an end and the strand under it is passed the other way.

    It ends then where that strand went on into the loop.

    Parameters
    ----------
    path : BodyPath
    width : float
        The body's, pixels.
    last_end : bool
        Whether its last end is meant, rather than its first.
    settings : StrandExchangeSettings

    Returns
    -------
    BodyPath or None
        None where the end lies on no strand.
    """
    curve = path.curve if last_end else path.curve[::-1]
    met = _met_by_end(curve, width, path.step, settings)
    if met is None:
        return None
    line = _passed_other_way(curve, met, joint_nodes(width, path.step, settings))
    return BodyPath(line if last_end else line[::-1])


def _met_by_end(
    curve: Complex, width: float, step: float, settings: StrandExchangeSettings
) -> int | None:
    """Return the node of a strand that a curve's last end lies on; None where it lies on none."""
    apart = round(settings.least_apart_along_widths * width / step)
    strand = curve[: max(len(curve) - apart, 0)]
    if not len(strand):
        return None
    away = np.abs(strand - curve[-1])
    i = int(away.argmin())
    if (
        away[i] > settings.most_end_apart_widths * width
        or i < joint_nodes(width, step, settings) + 2
    ):
        return None
    return i


def _passed_other_way(curve: Complex, i: int, joint: int) -> Complex:
    """Return a curve that ends where it met its end, what lies between passed the other way."""
    return evenly(np.concatenate([curve[: i - joint], curve[i + joint :][::-1]]), len(curve))


@lru_cache(maxsize=2)  # several ask in turn for those of the body that they are about to take
def _loops(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> list[tuple[float, DoubtfulLoop, Complex]]:
    """Return each loop, how much straighter it is the other way round, and the curve that way."""
    return [
        *_loops_between_strands(path, width, settings),
        *_loops_at_ends(path, width, settings),
    ]


def _loops_between_strands(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> Iterator[tuple[float, DoubtfulLoop, Complex]]:
    """Yield each loop between two strands that meet, as of `_loops`; and each other order."""
    curve, step, last = path.curve, path.step, len(path.curve) - 1
    joint = joint_nodes(width, step, settings)
    window, reach = window_nodes(width, step, settings), turn_nodes(width, step, settings)
    met = meetings(curve, width, step, settings)
    met = [(i, j) for i, j in met if i >= joint and j <= last - joint]
    for i, j in met:
        if j - i <= 2 * joint:
            continue
        again = _exchanged(curve, i, j, joint)
        gain = turned2(curve, i, j, window, reach) - turned2(again, i, j, window, reach)
        loop = DoubtfulLoop((i - joint) / last, (j + joint) / last, _breadth(curve[i : j + 1]))
        yield gain, loop, again
    for i, j, gain, again in other_orders(curve, met, width, step, settings):
        breadth = float(np.abs(again - curve).max())
        yield gain, DoubtfulLoop((i - joint) / last, (j + joint) / last, breadth), again


def _loops_at_ends(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> Iterator[tuple[float, DoubtfulLoop, Complex]]:
    """Yield each loop between an end and the strand under it, as of `_loops`.

    Less straight by what an end must tell more.
    """
    last, joint = len(path.curve) - 1, joint_nodes(width, path.step, settings)
    window, reach = window_nodes(width, path.step, settings), turn_nodes(width, path.step, settings)
    for last_end in (False, True):
        curve = path.curve if last_end else path.curve[::-1]
        i = _met_by_end(curve, width, path.step, settings)
        if i is None:
            continue
        again = _passed_other_way(curve, i, joint)
        gain = turned2(curve, i, last, window, reach) - turned2(again, i, last, window, reach)
        gain -= settings.least_gain_at_end_rad2
        beyond = (i - joint) / last
        part = (beyond, 1.0) if last_end else (0.0, 1 - beyond)
        loop = DoubtfulLoop(*part, _breadth(curve[i:]))
        yield gain, loop, again if last_end else again[::-1]


def _breadth(loop: Complex) -> float:
    """Return how far a part of a loop lies elsewhere if it is passed the other way."""
    return float(np.abs(loop - loop[::-1]).max())


def _exchanged(curve: Complex, i: int, j: int, joint: int) -> Complex:
    """Return a curve on which what lies between two nodes is passed the other way round."""
    between = curve[i + joint : j - joint + 1][::-1]
    return evenly(np.concatenate([curve[: i - joint], between, curve[j + joint :]]), len(curve))
