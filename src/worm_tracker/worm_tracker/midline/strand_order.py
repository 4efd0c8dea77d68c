"""Tells by its bends in which order a body passes two of its strands that lead to the same places.

A body may come twice by one place, and go on from there to another one twice, by two ways. It may
have taken either of them first: both orders cover the same of the picture, and no loop passed the
other way round leads from one to the other. It goes on as straight as it can, as where two strands
cross.
"""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.path import evenly
from worm_tracker.midline.strand_meetings import (
    StrandExchangeSettings,
    joint_nodes,
    turn_nodes,
    turned2,
)


def other_orders(
    curve: Complex,
    met: list[tuple[int, int]],
    width: float,
    step: float,
    settings: StrandExchangeSettings,
) -> Iterator[tuple[int, int, float, Complex]]:
    """Yield each other order in which a body may pass two of its strands.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        At equal steps.
    met : list of tuple of int
        The nodes at which two of its strands meet (`meetings`), those as near to an end as a joint
        is long left out.
    width, step : float
        The body's width and the distance of the nodes, pixels.
    settings : StrandExchangeSettings

    Yields
    ------
    first, last : int
        The nodes between which the body lies otherwise.
    gain : float
        How much straighter it is: the sum of its squared turns that it has less, rad².
    again : ndarray of complex, shape (n,)
        The curve in that order.
    """
    joint, reach = joint_nodes(width, step, settings), turn_nodes(width, step, settings)
    for (start, start_again), (end, end_again) in permutations(met, 2):
        one, between, other = end - start, start_again - end, end_again - start_again
        if min(one, other) <= 2 * joint or between < 0:
            continue
        again = _in_other_order(curve, (start, end, start_again, end_again), joint)
        if np.abs(again - curve).max() < settings.least_breadth_of_order_widths * width:
            continue
        turned, turned_again = (turned2(each, 0, 0, len(curve), reach) for each in (curve, again))
        yield start, end_again, turned - turned_again, again


def _in_other_order(curve: Complex, places: tuple[int, int, int, int], joint: int) -> Complex:
    """Return a curve whose strands between the first two and the last two nodes change places."""
    start, end, start_again, end_again = places
    parts = (
        curve[: start - joint],
        curve[start_again + joint : end_again - joint + 1],
        curve[end + joint : start_again - joint + 1],
        curve[start + joint : end - joint + 1],
        curve[end_again + joint :],
    )
    return evenly(np.concatenate(parts), len(curve))
