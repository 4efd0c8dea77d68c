"""What each node of a path says for the body being there, and for an end of it being there.

In clear water a body is dark and none is bright. Over another part it is darker than that part
alone, or, where overlaps are no darker, nothing can be told. Each part lets the same part of the
light through, so that a third adds as much of what the second adds as that adds of the first.
"""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Mask
from worm_tracker.midline.cross_sections import Covers
from worm_tracker.midline.end_marks import EndMarksSettings, SeenOnPath, more_by_marks
from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.self_cover import SelfCoverSettings


@dataclass(frozen=True, eq=False, slots=True)
class ExpectedAtNodes:
    """What a body is expected to be at the nodes of a path.

    Attributes
    ----------
    level : ndarray, shape (n,)
        Its signal on the midline, grey levels.
    covers : Covers
        Where other parts of it lie over this one.
    ends : tuple of float
        Arc lengths at which its ends are expected, pixels.
    step : float
        Distance of the nodes, pixels.
    """

    level: Floats
    covers: Covers
    ends: tuple[float, float]
    step: float


def node_log_odds(spine: Floats32, along: ExpectedAtNodes, level_sd_relative: float) -> Floats:
    """Return the log odds of the body being at each node, by the darkness there.

    Parameters
    ----------
    spine : ndarray, shape (n,)
        Signal on the path, grey levels.
    along : ExpectedAtNodes
    level_sd_relative : float
        How far the body's darkness scatters, relative to itself.
    """
    covers = along.covers
    below = np.arange(int(covers.layers.max(initial=0)) + 1)
    of_layers = np.append(0.0, np.cumsum(covers.darkening**below))[covers.layers]
    without = covers.level * of_layers
    adds = covers.darkening ** covers.layers.astype(np.float64) * along.level
    sd = level_sd_relative * along.level
    sd = np.where(covers.middle, np.hypot(sd, covers.level_sd), sd)
    odds = (spine - without - adds / 2) * adds / np.maximum(sd, 1.0) ** 2
    border = covers.either & ~covers.middle
    return np.where(border & (odds > 0), 0.0, odds)


def end_log_odds(
    spine: Floats32,
    curve: Complex,
    along: ExpectedAtNodes,
    odds: Floats,
    body: ExpectedBody,
    most: float,
    settings: EndMarksSettings,
) -> tuple[Floats, Floats] | None:
    """Return what is told of an end being at each node, beyond what the nodes say by themselves.

    By the marks of a skin, where an end may lie on other parts: what lies below is known place by
    place, and so is what the end adds to it.

    Parameters
    ----------
    spine : ndarray, shape (n,)
        Signal on the path, grey levels.
    curve : ndarray of complex, shape (n,)
    along : ExpectedAtNodes
    odds : ndarray, shape (n,)
        Log odds of the body being there.
    body : ExpectedBody
    most : float
        Most that a node speaks for or against the body.
    settings : EndMarksSettings

    Returns
    -------
    tuple of ndarray, shape (n,), or None
        For the first end and the last; None where nothing more is told.
    """
    covers, step = along.covers, along.step
    if not (body.is_marked and covers.darkening > 0 and covers.middle.any()):
        return None
    node = np.arange(len(curve))
    first, last = round(along.ends[0] / step), round(along.ends[1] / step)
    there = np.where((node >= first) & (node <= last), along.level, 0.0)
    below = level_below(curve, covers.middle, there, step, body.width, SelfCoverSettings())
    border = covers.either & ~covers.middle
    seen = SeenOnPath(np.asarray(spine, np.float64), below, along.level, border, odds)
    points = len(body.levels) - 1
    behind = np.arange(round(settings.widths * body.width / step)) * points / max(last - first, 1)
    first_more, last_more = (
        _more_of_end(seen, body, behind, turned, is_pale, most, settings)
        for is_pale, turned in zip(body.pale_ends, (False, True), strict=True)
    )
    return first_more, last_more


def _more_of_end(
    seen: SeenOnPath,
    body: ExpectedBody,
    behind: Floats,
    turned: bool,
    is_pale: bool,
    most: float,
    settings: EndMarksSettings,
) -> Floats:
    """Return what marks say more of one end, by the points of the body behind it at the nodes.

    In clear water of a pale one alone: the darkness of any other tells it there, however the skin
    has rolled.
    """
    levels = body.levels[::-1] if turned else body.levels
    profile = np.interp(behind, np.arange(len(levels)), levels)
    at = seen.turned() if turned else seen
    known = profile, body.darkening, body.level
    more = more_by_marks(at, *known, most, settings, in_water=is_pale)
    return more[::-1] if turned else more


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
