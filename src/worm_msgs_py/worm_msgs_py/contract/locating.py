"""Which part of the rig holds a head: one rule for pictures and for tables of tracks."""

from math import inf, isfinite
from typing import Any

PASSAGE_SLACK = 1.2
"""How much wider than the exit the stretch is that counts as the passage: the head is a point on
the body's edge, and W is known to a pixel."""
UNSEEN_EXIT = 1.03
"""Distance from the nearest centre, over R, beyond which a head is in a passage whose width is not
known: nowhere else can it be that far beyond the wall."""


def is_in_passage(
    x: Any, y: Any, out: Any, radius: float, exit_width: float, passage_length: float = inf
) -> Any:
    """Return whether a head is in the passage of a chamber.

    Parameters
    ----------
    x, y : float or ndarray
        The head in the chamber's frame (x towards its exit), in any unit of length.
    out : float or ndarray
        Its distance from the nearest chamber's centre, over the radius.
    radius, exit_width : float
        R and W, same unit; W is NaN where it is not known.
    passage_length : float
        L, same unit, where there is a second chamber.

    Returns
    -------
    bool or ndarray of bool
    """
    if not isfinite(exit_width):
        return out > UNSEEN_EXIT
    between_walls = abs(y) < PASSAGE_SLACK * exit_width / 2
    return (out > 1) & (x > 0) & (x < radius + passage_length) & between_walls
