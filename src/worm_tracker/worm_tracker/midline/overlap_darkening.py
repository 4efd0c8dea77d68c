"""How much darker two parts of a marked body are where they lie on each other.

The marks of a skin are darker than some of its overlaps, so that the darkest places do not tell.
But where the body was followed through a fold it is known which parts lie on each other, and what
either of them looks like alone.
"""

from dataclasses import dataclass, field

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
from worm_tracker.midline.cross_sections import interpolate
from worm_tracker.midline.self_cover import SelfCoverSettings, parts_over


@dataclass(frozen=True, slots=True)
class OverlapDarkeningSettings:
    """Which places of a body tell."""

    within_widths: float = 0.25
    """How much nearer to each other than half a width the midlines of two parts are."""
    least_overlap_widths: float = 2.0
    """Length of what lies on another part, at least."""
    end_widths: float = 1.5
    """How much of either end is left out: it may lie elsewhere."""
    cover: SelfCoverSettings = field(default_factory=SelfCoverSettings)


def overlap_darkening(
    signal: Picture,
    curve: Complex,
    widths: Floats,
    levels: Floats,
    width: float,
    settings: OverlapDarkeningSettings,
) -> float | None:
    """Return what a part of a body adds to the signal of one that it lies on, over its own.

    The median over all such places: two thirds where transmissions multiply and a layer takes away
    a third of the light, nothing where overlaps are no darker.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window, without the noise of single pixels.
    curve : ndarray of complex, shape (n,)
        The midline at equal steps in the window's coordinates, u + iv.
    widths, levels : ndarray, shape (m,)
        Width, pixels, and signal of one layer on the midline, along the body in the same order.
    width : float
        That of most of the body, pixels.
    settings : OverlapDarkeningSettings

    Returns
    -------
    float or None
        None where too little of the body lies on itself.
    """
    n = len(curve)
    step = float(np.abs(np.diff(curve)).mean())
    part, known = np.linspace(0, 1, n), np.linspace(0, 1, len(widths))
    half, level = np.interp(part, known, widths) / 2, np.interp(part, known, levels)
    ends = round(settings.end_widths * width / step)
    inner, margin_px = slice(ends, n - ends), -settings.within_widths * width
    over = parts_over(curve[:, None], curve, half, inner, step, margin_px, settings.cover)
    covered = over[:, 0] > 0
    covered[:ends] = covered[n - ends :] = False
    if np.count_nonzero(covered) * step < settings.least_overlap_widths * width:
        return None
    below = level_below(curve, covered, level, step, width, settings.cover)[covered]
    adds = interpolate(signal, curve[covered][:, None])[:, 0] - below
    return float(np.median(adds / np.maximum(level[covered], 1.0)))


def level_below(
    curve: Complex,
    covered: Mask,
    level: Floats,
    step: float,
    width: float,
    cover: SelfCoverSettings,
) -> Floats:
    """Return the signal of the parts that lie over the nodes of a path; 0 where none does.

    Parameters
    ----------
    curve : ndarray of complex, shape (n,)
        At equal steps.
    covered : ndarray of bool, shape (n,)
        Where another part lies over it.
    level : ndarray, shape (n,)
        Signal of one layer at each node; 0 where the body is not.
    step, width : float
        Distance of the nodes, and width of the body, pixels.
    cover : SelfCoverSettings
        How far along the body another part begins.
    """
    below = np.zeros(len(curve))
    at, parts = np.flatnonzero(covered), np.flatnonzero(level > 0)
    if not (len(at) and len(parts)):
        return below
    away = np.abs(curve[at][:, None] - curve[parts])
    apart = cover.least_way_between_parts_widths * width
    away[np.abs(at[:, None] - parts) * step < apart] = np.inf
    below[at] = level[parts[away.argmin(axis=1)]]
    return below
