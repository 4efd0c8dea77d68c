"""Whether it is known which way round the loops of a body are passed: by bends, or from before."""

import numpy as np

from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.self_cover import ends_kept, ends_on_body
from worm_tracker.midline.strand_exchange import DoubtfulLoop, doubtful_loops
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def loops_in_doubt(
    path: BodyPath,
    before: PropagatedBody,
    was_followed: bool,
    bend_lost_rad2: float,
    end_sd_px: tuple[float, float],
    width: float,
    settings: PropagationSettings,
) -> list[DoubtfulLoop]:
    """Return the loops of a body which may be passed either way round, by its bends.

    One in doubt that has been followed, and open, since it was known is passed as it was; one
    whose strands have just been exchanged is passed the other way, and so may be all of a body
    whose ends were taken for each other.

    Parameters
    ----------
    path : BodyPath
        Where it lies.
    before : PropagatedBody
        Where it lay in the picture before.
    was_followed : bool
        Whether it was slid from there, its strands as they were.
    bend_lost_rad2 : float
        How much less straight the other way past a loop may be and still be in doubt.
    end_sd_px : tuple of float
        How surely its ends were where they were said to be there.
    width : float
        The worm's, pixels.
    settings : PropagationSettings
    """
    loops = doubtful_loops(
        path, width, settings.doubt, -bend_lost_rad2, settings.least_breadth_widths
    )
    left = before.doubt_by_bends
    if not loops and left is not None and _is_left_by_end(path, left, width, settings):
        return [DoubtfulLoop(*left, path.length)]
    open_px = settings.open_loop_widths * width
    was_known = left is None and was_followed
    if max(end_sd_px) > settings.most_end_sd_widths * width:
        kept = ends_kept(before.points, end_sd_px)
        was_known = was_known and kept > settings.least_ends_kept
    known = was_known and all(loop.breadth_px > open_px for loop in loops)
    return [] if known else loops


def turns_known_loop(
    path: BodyPath,
    otherwise: BodyPath,
    before: PropagatedBody,
    ends_seen: tuple[bool, bool],
    width: float,
    settings: PropagationSettings,
) -> bool:
    """Tell whether an open loop is passed otherwise of which it is known how it is passed.

    Straighter is not truer where a hairpin lies on a strand. An end that is not seen may have gone
    on elsewhere, and so made a loop beside it.

    Parameters
    ----------
    path, otherwise : BodyPath
        The body as it was followed, and as it may lie.
    before : PropagatedBody
        It in the picture before.
    ends_seen : tuple of bool
    width : float
        The worm's, pixels.
    settings : PropagationSettings
    """
    if before.doubt_by_bends is not None or before.frames_unexplained:
        return False
    apart = np.hypot(*(path.points - otherwise.points).T)
    if apart.max() < settings.open_loop_widths * width:
        return False
    changed = np.flatnonzero(apart > settings.changed_widths * width)
    near = settings.made_by_end_widths * width / path.length * (len(apart) - 1)
    beside = changed[0] < near, changed[-1] > len(apart) - 1 - near
    return all(seen or not at for seen, at in zip(ends_seen, beside, strict=True))


def _is_left_by_end(
    path: BodyPath, left: tuple[float, float], width: float, settings: PropagationSettings
) -> bool:
    """Tell whether what was in doubt is so still, its strands meeting where an end lies on one.

    How an end bends is not seen there, so that neither way is the straighter one.
    """
    near = settings.near_end_widths * width
    part = 2 * near / path.length
    on_first, on_last = ends_on_body(path.curve, near, path.step)
    first, last = left
    return (on_first and first < part) or (on_last and last > 1 - part)
