"""Where two strands of a body meet, and how much it turns there."""

from dataclasses import dataclass
from math import ceil

import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for


@dataclass(frozen=True, slots=True)
class StrandExchangeSettings:
    """Which strands meet, and how much straighter the other way must be."""

    least_apart_along_widths: float = 2.5
    """How far along the body two strands are apart at least."""
    most_apart_widths: float = 0.6
    """How far apart they may be where they meet."""
    least_breadth_of_order_widths: float = 0.85
    """How far from where it is a body must lie in which two strands are passed in another order."""
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


@compiled
def _is_nearest(curve: Complex, i: int, j: int, apart: int, distance: float) -> bool:
    """Tell whether no nodes within two of a pair of nodes are nearer to each other than these."""
    n = len(curve)
    for k in range(max(i - 2, 0), min(i + 3, n)):
        for m in range(max(j - 2, k + apart), min(j + 3, n)):
            if abs(curve[k] - curve[m]) < distance:
                return False
    return True


@compiled_for(array_read(types.complex128), types.intp, types.float64, array_written(types.intp, 2))
def _nearest_pairs(curve: Complex, apart: int, most: float, pairs: NDArray[np.intp]) -> int:
    """Fill in the pairs of nodes nearer than `most`, and than all pairs within two nodes of them.

    Only those count that are `apart` nodes from each other; how many there are is returned.
    """
    count, n = 0, len(curve)
    for i in range(n):
        for j in range(i + apart, n):
            du, dv = curve[i].real - curve[j].real, curve[i].imag - curve[j].imag
            if max(abs(du), abs(dv)) >= most:  # most pairs: a root takes long
                continue
            distance = abs(curve[i] - curve[j])
            if distance >= most:
                continue
            if _is_nearest(curve, i, j, apart, distance):
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count


def joint_nodes(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes to either side of a meeting are laid anew."""
    return max(2, round(settings.joint_widths * width / step))


def window_nodes(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes to either side of a meeting are compared."""
    return round(settings.window_widths * width / step)


def turn_nodes(width: float, step: float, settings: StrandExchangeSettings) -> int:
    """Return how many nodes the stretches are long between which a strand's turn is taken."""
    return max(2, round(settings.direction_stretch_widths * width / step))


@compiled_for(array_read(types.complex128), types.intp, types.intp, types.intp, types.intp)
def turned2(curve: Complex, i: int, j: int, window: int, reach: int) -> float:
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
