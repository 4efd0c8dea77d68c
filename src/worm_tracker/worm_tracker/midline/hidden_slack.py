"""What of a body nothing in the picture asks for: it goes back over itself and on again.

Where overlaps are no darker a body that was followed too long hides what is too much: in a spike
that lies on a strand of its own, or laid three times over one stretch. A shorter one that goes
straight on covers the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.strand_meetings import StrandExchangeSettings, meetings


@dataclass(frozen=True, slots=True)
class HiddenSlackSettings:
    """What is left out of a body to see whether it is asked for."""

    most_apart_widths: float = 0.8
    """How far apart the two places may be between which it is left out."""
    direction_widths: float = 0.8
    """Length of the stretches before the one and after the other that give its directions."""
    most_turn_rad: float = 1.5
    """How far it may turn where it goes on without that."""
    most_tried: int = 4
    """Of the pairs of places, those nearest to each other along the body: wide loops are seen."""
    least_length_over_known: float = 0.75
    """How long the shorter body is at least: a worm that contracts by more is another one."""


def without_slack(
    path: BodyPath, width: float, meet: StrandExchangeSettings, settings: HiddenSlackSettings
) -> Iterator[BodyPath]:
    """Yield a path without what lies between two places where it meets itself and goes on.

    Parameters
    ----------
    path : BodyPath
    width : float
        The body's, pixels.
    meet : StrandExchangeSettings
        Where its strands meet.
    settings : HiddenSlackSettings
    """
    curve = path.curve
    reach = max(2, round(settings.direction_widths * width / path.step))
    apart_px = settings.most_apart_widths * width
    pairs = set[tuple[int, int]]()
    for i, j in meetings(curve, width, path.step, meet):
        pair = _widened(curve, i, j, reach, apart_px)
        if pair is not None and _turns_by(curve, *pair, reach) < settings.most_turn_rad:
            pairs.add(pair)
    for i, j in sorted(pairs, key=lambda pair: pair[1] - pair[0])[: settings.most_tried]:
        line = np.concatenate([curve[:i], curve[j + 1 :]])
        line = line[np.append(True, np.diff(line) != 0)]  # there and back may be one place
        length = float(np.abs(np.diff(line)).sum())
        yield BodyPath(evenly(line, nodes_for(length, width)))


def _widened(curve: Complex, i: int, j: int, reach: int, apart_px: float) -> tuple[int, int] | None:
    """Return the pair of places farthest apart along a body that runs there and back between them.

    None where so little of it lies before or behind them that it gives no direction.
    """
    first, last = reach, len(curve) - 1 - reach
    while i > first and j < last and abs(curve[i - 1] - curve[j + 1]) < apart_px:
        i, j = i - 1, j + 1
    return (i, j) if first <= i and j <= last else None


def _turns_by(curve: Complex, i: int, j: int, reach: int) -> float:
    """Return by how much a body turns where it goes on from one place at another, radians."""
    before, after = curve[i] - curve[i - reach], curve[j + reach] - curve[j]
    return float(abs(np.angle(after * before.conjugate())))
