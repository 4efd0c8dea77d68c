"""How sharply a midline bends to the one side and then to the other: an S that no worm makes.

A body does not bend both ways within a width or two. A midline that changes over to the strand
beside it does, and so does one that is led round something that it should cross.
"""

import numpy as np

from worm_msgs_py.arrays import Complex, Floats
from worm_tracker.midline.curve import as_complex, complex_arc_length

_FROM_END_WIDTHS = 0.3
"""How far from an end turns are looked for at first: nearer a midline hardly shows them."""
_APART_WIDTHS = 0.15
"""How far apart."""


def s_turn_at_ends(points: Floats, width: float, near_widths: float) -> float:
    """Return how sharp an S a line makes near one of its ends, radians.

    The most that it turns over a width to the one side there, or to the other if that is less.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    width : float
        The body's, in the unit of the points.
    near_widths : float
        How far from an end that is looked for.
    """
    line = as_complex(points)
    at, length = _places(near_widths * width, width), float(complex_arc_length(line)[-1])
    sharpest = 0.0
    for place in (at, length - at):
        over = _turns_over_width(line, place, width)
        sharpest = max(sharpest, min(float(over.max()), float(-over.min())))
    return sharpest


def s_shaped_part(
    points: Floats, width: float, least_rad: float, within_widths: float
) -> tuple[float, float] | None:
    """Return the part of a line's length in which it makes a sharp S; None where it makes none.

    From where to where, parts of its length. All of them, where there are several.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    width : float
        The body's, in the unit of the points.
    least_rad : float
        How much it turns at least over a width to the one side, and to the other.
    within_widths : float
        How far apart those turns are at most.
    """
    line = as_complex(points)
    length = float(complex_arc_length(line)[-1])
    at = _places(length - _FROM_END_WIDTHS * width, width)
    over = _turns_over_width(line, at, width)
    left, right = at[over > least_rad], at[over < -least_rad]
    near = np.abs(left[:, None] - right) <= within_widths * width
    bends = [*left[near.any(axis=1)].tolist(), *right[near.any(axis=0)].tolist()]
    if not bends:
        return None
    first, last = min(bends) - width / 2, max(bends) + width / 2
    return max(first / length, 0.0), min(last / length, 1.0)


def _places(last: float, width: float) -> Floats:
    """Return how far along a line its turns are looked for, up to so far."""
    return np.arange(_FROM_END_WIDTHS * width, last, _APART_WIDTHS * width)


def _turns_over_width(line: Complex, at: Floats, width: float) -> Floats:
    """Return how much a line turns over a width about places so far along it, radians."""
    d, s = np.diff(line), complex_arc_length(line)
    turned = np.concatenate([[0.0], np.cumsum(np.angle(d[1:] * d[:-1].conj()))])
    middle = (s[1:] + s[:-1]) / 2
    over = np.interp(at + width / 2, middle, turned) - np.interp(at - width / 2, middle, turned)
    return np.asarray(over, np.float64)
