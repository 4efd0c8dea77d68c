"""Lays the ends of a body anew where it does not explain its object: along the arc that does best.

A head that turns sharply, or comes out from under another part elsewhere than it was expected, is
not found by sliding a body along its path. Its last stretch is taken off and laid along arcs of all
curvatures; the arc is taken that stays on the object and covers most of what is missing.
"""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Picture
from worm_tracker.midline.cross_sections import interpolate
from worm_tracker.midline.path import BodyPath, evenly, nodes_for


@dataclass(frozen=True, slots=True)
class RegrownEndsSettings:
    """Which arcs are tried."""

    cut_widths: tuple[float, ...] = (0.7, 1.5, 3.0, 5.0)
    """How much of an end is taken off."""
    beyond_widths: float = 2.5
    """How far an arc may lead beyond what was taken off."""
    most_curvature_per_width: float = 1.1
    """Turn of the tightest arc over a width, radians."""
    arcs: int = 13
    """Curvatures that are tried, of either sign."""
    nodes_per_width: float = 4.0
    side_widths: float = 0.3
    """How far to either side of an arc there must be object, too."""
    price_per_width: float = 0.15
    """What an arc must cover of what is missing, over its own length, to be made longer."""
    off_object_cost: float = 3.0
    """What a stretch off the object costs, over one that covers what is missing."""


def regrown(
    path: BodyPath,
    mask: Picture,
    wanted: Picture,
    width: float,
    end_width: float,
    last_end: bool,
    settings: RegrownEndsSettings,
) -> BodyPath | None:
    """Return a path with one end laid anew; None where that covers nothing that is missing.

    Parameters
    ----------
    path : BodyPath
        In the masks' coordinates.
    mask, wanted : ndarray of uint8, shape (h, w)
        The object, and what of it is missing in the body; not zero there.
    width, end_width : float
        The body's, and that of its end, which may taper, pixels.
    last_end : bool
        Whether the path's last end is meant, rather than its first.
    settings : RegrownEndsSettings
    """
    curve = path.curve if last_end else path.curve[::-1]
    step = width / settings.nodes_per_width
    curvature = np.linspace(-1, 1, settings.arcs) * settings.most_curvature_per_width / width
    best: tuple[float, Complex] | None = None
    for cut in settings.cut_widths:
        stem = curve[: max(len(curve) - round(cut * width / path.step), 8)]
        heading = np.angle(stem[-1] - stem[-6])
        count = round((cut + settings.beyond_widths) * settings.nodes_per_width)
        turn = heading + curvature[:, None] * step * (np.arange(count) + 0.5)
        arcs = stem[-1] + np.cumsum(step * np.exp(1j * turn), axis=1)
        gain = _gain(arcs, np.exp(1j * turn), mask, wanted, end_width, settings)
        k, j = np.unravel_index(int(gain.argmax()), gain.shape)
        if gain[k, j] > 0 and (best is None or gain[k, j] > best[0]):
            best = float(gain[k, j]), np.concatenate([stem, arcs[k, : j + 1]])
    if best is None:
        return None
    line = evenly(best[1], nodes_for(float(np.abs(np.diff(best[1])).sum()), width))
    return BodyPath(line if last_end else line[::-1])


def _gain(
    arcs: Complex,
    tangent: Complex,
    mask: Picture,
    wanted: Picture,
    end_width: float,
    settings: RegrownEndsSettings,
) -> Floats:
    """Return what each arc, cut off after each node, covers of what is missing, less its costs."""
    side = 1j * tangent * settings.side_widths * end_width
    on = [interpolate(mask, arcs + sign * side) > 127 for sign in (-1, 0, 1)]
    covers = [interpolate(wanted, arcs + sign * side) > 127 for sign in (-1, 0, 1)]
    off = 1 - np.mean(on, axis=0)
    per_node = np.mean(covers, axis=0) - settings.off_object_cost * off
    per_node -= settings.price_per_width
    return np.asarray(np.cumsum(per_node, axis=1) + settings.price_per_width * 2, np.float64)
