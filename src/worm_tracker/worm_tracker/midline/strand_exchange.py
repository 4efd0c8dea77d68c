"""Tells by its bends whether two strands of a body that meet cross each other or turn back.

Both cover the same of the picture. A body goes on as straight as it can: where its strands bend to
get past each other, it is the other way, and what lies between them is passed the other way round.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.path import BodyPath, evenly


@dataclass(frozen=True, slots=True)
class StrandExchangeSettings:
    """Which strands meet, and how much straighter the other way must be."""

    least_apart_along_widths: float = 2.5
    """How far along the body two strands are apart at least."""
    most_apart_widths: float = 0.6
    """How far apart they may be where they meet."""
    direction_stretch_widths: float = 0.5
    """Length of the stretches between which a strand's turn is taken."""
    window_widths: float = 2.0
    """How much of a strand to either side of the place where they meet is compared."""
    joint_widths: float = 0.8
    """How much of it is laid anew."""
    most_end_apart_widths: float = 1.0
    """How far from a strand an end may be that lies on it."""
    least_gain_rad2: float = 0.2
    """Sum of the squared turns that the other way must have less in a frame."""
    least_gain_at_end_rad2: float = 0.35
    """How much straighter than asked of others a loop must be the other way that an end closes:
    an end that lies on a strand hardly shows how it bends."""
    least_gain_in_all_rad2: float = 1.0
    kept_gain: float = 0.8
    """Sum of that over the last frames from which on it is believed, and what is kept of it in a
    frame: strands that slide past each other bend for a moment."""


@dataclass(frozen=True, slots=True)
class DoubtfulLoop:
    """A loop of which the picture does not tell which way round it is passed.

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
    for _, _, gain, again in _other_ways(path.curve, width, path.step, settings):
        if gain > best:
            best, exchanged = gain, again
    return (None, 0.0) if exchanged is None else (BodyPath(exchanged), best)


def exchanges(path: BodyPath, width: float, settings: StrandExchangeSettings) -> list[BodyPath]:
    """Return the paths with two strands exchanged, one for each place where two meet."""
    return [
        BodyPath(again) for _, _, _, again in _other_ways(path.curve, width, path.step, settings)
    ]


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
    line = _passed_other_way(curve, met, _joint(width, path.step, settings))
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
    if away[i] > settings.most_end_apart_widths * width or i < _joint(width, step, settings) + 2:
        return None
    return i


def _passed_other_way(curve: Complex, i: int, joint: int) -> Complex:
    """Return a curve that ends where it met its end, what lies between passed the other way."""
    return evenly(np.concatenate([curve[: i - joint], curve[i + joint :][::-1]]), len(curve))


def _loops(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> Iterator[tuple[float, DoubtfulLoop, Complex]]:
    """Yield each loop, how much straighter it is the other way round, and the curve that way."""
    yield from _loops_between_strands(path, width, settings)
    yield from _loops_at_ends(path, width, settings)


def _loops_between_strands(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> Iterator[tuple[float, DoubtfulLoop, Complex]]:
    """Yield each loop between two strands that meet, as `_loops` does."""
    last, joint = len(path.curve) - 1, _joint(width, path.step, settings)
    for i, j, gain, again in _other_ways(path.curve, width, path.step, settings):
        breadth = _breadth(path.curve[i : j + 1])
        yield gain, DoubtfulLoop((i - joint) / last, (j + joint) / last, breadth), again


def _loops_at_ends(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> Iterator[tuple[float, DoubtfulLoop, Complex]]:
    """Yield each loop between an end and the strand under it, as `_loops` does.

    Less straight by what an end must tell more.
    """
    last, joint = len(path.curve) - 1, _joint(width, path.step, settings)
    window, reach = _window(width, path.step, settings), _turn_stretch(width, path.step, settings)
    for last_end in (False, True):
        curve = path.curve if last_end else path.curve[::-1]
        i = _met_by_end(curve, width, path.step, settings)
        if i is None:
            continue
        again = _passed_other_way(curve, i, joint)
        gain = _turned2(curve, i, last, window, reach) - _turned2(again, i, last, window, reach)
        gain -= settings.least_gain_at_end_rad2
        beyond = (i - joint) / last
        part = (beyond, 1.0) if last_end else (0.0, 1 - beyond)
        loop = DoubtfulLoop(*part, _breadth(curve[i:]))
        yield gain, loop, again if last_end else again[::-1]


def _breadth(loop: Complex) -> float:
    """Return how far a part of a loop lies elsewhere if it is passed the other way."""
    return float(np.abs(loop - loop[::-1]).max())


def _other_ways(
    curve: Complex, width: float, step: float, settings: StrandExchangeSettings
) -> Iterator[tuple[int, int, float, Complex]]:
    """Yield each exchange: its two nodes, how much straighter it is (rad²), and the curve."""
    joint = _joint(width, step, settings)
    window, reach = _window(width, step, settings), _turn_stretch(width, step, settings)
    for i, j in meetings(curve, width, step, settings):
        if i < joint or j >= len(curve) - joint or j - i <= 2 * joint:
            continue
        again = _exchanged(curve, i, j, joint)
        gain = _turned2(curve, i, j, window, reach) - _turned2(again, i, j, window, reach)
        yield i, j, gain, again


def _joint(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes to either side of a meeting are laid anew."""
    return max(2, round(settings.joint_widths * width / step))


def _window(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes to either side of a meeting are compared."""
    return round(settings.window_widths * width / step)


def _turn_stretch(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes the stretches are long between which a strand's turn is taken."""
    return max(2, round(settings.direction_stretch_widths * width / step))


def meetings(
    curve: Complex, width: float, step: float, settings: StrandExchangeSettings
) -> list[tuple[int, int]]:
    """Return the pairs of nodes at which two strands come nearest to each other.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        At equal steps.
    width, step : float
        The body's width and the distance of the nodes, pixels.
    settings : StrandExchangeSettings
    """
    stride = 2
    coarse = curve[::stride]
    apart = max(ceil(settings.least_apart_along_widths * width / (stride * step)), 1)
    pairs = np.empty((len(coarse) * (len(coarse) - 1) // 2, 2), np.intp)
    count = _nearest_pairs(coarse, apart, settings.most_apart_widths * width, pairs)
    return [(stride * i, stride * j) for i, j in pairs[:count].tolist()]


@compiled_for(array_read(types.complex128), types.intp, types.float64, array_written(types.intp, 2))
def _nearest_pairs(curve: Complex, apart: int, most: float, pairs: NDArray[np.intp]) -> int:
    """Fill in the pairs of nodes nearer than `most`, and than all pairs within two nodes of them.

    Only those count that are `apart` nodes from each other; how many there are is returned.
    """
    count, n = 0, len(curve)
    for i in range(n):
        for j in range(i + apart, n):
            distance = abs(curve[i] - curve[j])
            if distance >= most:
                continue
            is_nearest = True
            for k in range(max(i - 2, 0), min(i + 3, n)):
                for m in range(max(j - 2, k + apart), min(j + 3, n)):
                    is_nearest &= abs(curve[k] - curve[m]) >= distance
            if is_nearest:
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count


@compiled_for(array_read(types.complex128), types.intp, types.intp, types.intp, types.intp)
def _turned2(curve: Complex, i: int, j: int, window: int, reach: int) -> float:
    """Return the sum of the squared turns near two nodes, over the nodes of a stretch.

    A node's turn is that between the stretches before and after it, so many nodes long (`reach`).
    """
    total = 0.0
    for node in range(max(reach, i - window), min(len(curve) - reach, j + window + 1)):
        if i + window < node < j - window:
            continue
        after = curve[node + reach] - curve[node]
        before = curve[node] - curve[node - reach]
        total += np.angle(after * before.conjugate()) ** 2
    return total / reach


def _exchanged(curve: Complex, i: int, j: int, joint: int) -> Complex:
    """Return a curve on which what lies between two nodes is passed the other way round."""
    between = curve[i + joint : j - joint + 1][::-1]
    return evenly(np.concatenate([curve[: i - joint], between, curve[j + joint :]]), len(curve))
