"""Tells by its bends whether two strands of a body that meet cross each other or turn back.

Both cover the same of the picture. A body goes on as straight as it can: where both strands have a
kink at the same place, it is the other way, and what lies between them is passed the other way
round.
"""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.path import BodyPath, evenly


@dataclass(frozen=True, slots=True)
class StrandExchangeSettings:
    """Which strands meet, and how much straighter the other way must be."""

    least_apart_along_widths: float = 2.5
    """How far along the body two strands are apart at least."""
    most_apart_widths: float = 0.6
    """How far apart they may be where they meet."""
    direction_stretch_widths: float = 0.7
    """Length of the stretch that tells a strand's direction."""
    least_kink_rad: float = 0.3
    """Turn of a strand over that much, to either side, from which on it is a kink."""
    least_gain_rad2: float = 0.3
    """Sum of the squares of both turns that the other way must have less."""
    joint_widths: float = 0.4
    """How much of a strand is laid anew on either side of the place where they meet."""


def exchanged_strands(
    path: BodyPath, width: float, settings: StrandExchangeSettings
) -> BodyPath | None:
    """Return a path that goes on straighter where two of its strands meet; None where none does.

    Parameters
    ----------
    path : BodyPath
    width : float
        The body's, pixels.
    settings : StrandExchangeSettings
    """
    curve, step = path.curve, path.step
    reach = max(2, round(settings.direction_stretch_widths * width / step))
    apart = max(2 * reach, round(settings.least_apart_along_widths * width / step))
    before, after = _directions(curve, reach)
    turn = np.abs(np.angle(after * before.conj()))
    kinks = np.flatnonzero(turn > settings.least_kink_rad)
    best, where = settings.least_gain_rad2, None
    for k in kinks.tolist():
        near = np.abs(curve - curve[k]) < settings.most_apart_widths * width
        near[max(k - apart, 0) : k + apart + 1] = False
        near[:reach] = near[-reach:] = False
        for other in np.flatnonzero(near).tolist():
            i, j = min(k, other), max(k, other)
            crossed = _angle2(before[i], -before[j]) + _angle2(-after[i], after[j])
            gain = float(turn[i] ** 2 + turn[j] ** 2 - crossed)
            if gain > best:
                best, where = gain, (i, j)
    if where is None:
        return None
    return BodyPath(_exchanged(curve, *where, round(settings.joint_widths * width / step)))


def _directions(curve: Complex, reach: int) -> tuple[Complex, Complex]:
    """Return the unit directions in which a curve comes to each node, and leaves it."""
    chord = curve[reach:] - curve[:-reach]
    chord /= np.maximum(np.abs(chord), 1e-9)
    before = np.concatenate([np.full(reach, chord[0]), chord])
    after = np.concatenate([chord, np.full(reach, chord[-1])])
    return before, after


def _angle2(a: complex, b: complex) -> float:
    """Return the square of the angle between two directions."""
    return float(np.angle(a * np.conj(b)) ** 2)


def _exchanged(curve: Complex, i: int, j: int, joint: int) -> Complex:
    """Return a curve on which what lies between two nodes is passed the other way round."""
    between = curve[i + joint : j - joint + 1][::-1]
    return evenly(np.concatenate([curve[: i - joint], between, curve[j + joint :]]), len(curve))
