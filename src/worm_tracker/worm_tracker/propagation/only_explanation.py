"""Tells whether a body that was lost, and explains its picture again, is the only one that can."""

from collections.abc import Collection

from worm_tracker.midline.self_cover import lies_near_itself
from worm_tracker.midline.strand_exchange import DoubtfulLoop, doubtful_loops
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.propagation_settings import PropagationSettings


def is_only_explanation(
    found: Candidate,
    over_limits: float,
    overlaps_are_told: bool,
    width: float,
    told_by_marks: Collection[DoubtfulLoop],
    settings: PropagationSettings,
) -> bool:
    """Tell whether no other body can explain the picture, however this one was found.

    It lies apart from itself, ends and all, so that all of it is seen. Or hardly anything is left
    over, overlaps are told by their darkness, and nowhere could its strands be passed the other way
    round without bending much more, or against its marks.

    Parameters
    ----------
    found : Candidate
        It explains its picture.
    over_limits : float
        What it leaves over, over what may be.
    overlaps_are_told : bool
        Whether they are darker, so that they are seen.
    width : float
        The body's, pixels.
    told_by_marks : collection of DoubtfulLoop
        Those of its loops that marks say are passed as it has them.
    settings : PropagationSettings
    """
    path = found.path
    sure = max(found.end_sd_px) < settings.most_end_sd_widths * width
    if sure and not lies_near_itself(path.curve, width, path.step, settings.least_apart_widths):
        return True
    if not overlaps_are_told or over_limits > settings.most_over_limits_alone:
        return False
    most = -settings.least_bend_of_other_way_rad2
    loops = doubtful_loops(path, width, settings.exchange, most)
    return all(loop in told_by_marks for loop in loops)
