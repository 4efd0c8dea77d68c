"""How far a body has moved aside between two pictures: along itself it slides, aside it hardly can.

What lies farther aside than a worm moves in that time lies on another strand.
"""

from math import ceil

import numpy as np

from worm_msgs_py.arrays import Floats

_FINER = 4
"""Nodes of a line for each of a midline's points: seen from half a step away, its nearest node is
off by next to nothing."""


def moved_aside_px(points: Floats, before: Floats, most_along_px: float) -> Floats:
    """Return how far each point of a midline lies beside where the body was in another picture.

    Parameters
    ----------
    points, before : ndarray, shape (n, 2)
        Midlines in one order of the ends, pixels; NaN where they are not told.
    most_along_px : float
        How far along itself the body may have slid: farther along is another part of it.

    Returns
    -------
    ndarray, shape (n,)
        NaN where it is not told of one of both. Near an end it may be that end's way.
    """
    n = len(points)
    nodes = np.linspace(0, n - 1, _FINER * (n - 1) + 1)
    line = np.stack([np.interp(nodes, np.arange(n), part) for part in before.T])
    told = np.isfinite(before[:, 0]) & np.isfinite(points[:, 0])
    away = np.hypot(*(line[:, np.newaxis] - points.T[:, :, np.newaxis]))
    steps_px = np.hypot(*np.diff(before[told], axis=0).T)
    step_px = float(np.median(steps_px)) if steps_px.any() else np.inf
    along = np.abs(nodes - np.arange(n)[:, np.newaxis])
    near = (along <= ceil(most_along_px / step_px)) & np.isfinite(away)
    aside = np.where(near, away, np.inf).min(axis=1)
    return np.where(told, aside, np.nan)
