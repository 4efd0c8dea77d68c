"""Believes a body again that was lost, once it explains many pictures.

One picture is explained by bodies that lie otherwise, too: strands that lie side by side are alike.
A worm that crawls on parts them.
"""

from dataclasses import replace
from math import log

from worm_tracker.midline.body_model import BodyModel
from worm_tracker.propagation.end_sureness import end_sd_px_of
from worm_tracker.propagation.overlaps import overlaps_tell
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def explained_again(
    found: PropagatedBody,
    before: PropagatedBody,
    frames: int,
    model: BodyModel,
    settings: PropagationSettings,
) -> PropagatedBody:
    """Return a body that was lost as one that is known again, where it has explained enough.

    A picture in which an end is not told does not count, and is passed over.

    Parameters
    ----------
    found : PropagatedBody
        The body in this picture.
    before : PropagatedBody
        In the one before.
    frames : int
        How many frames ago that was, 1 for the next.
    model : BodyModel
    settings : PropagationSettings
    """
    if found.frames_unexplained == 0:
        return found
    if not _explains_all(found, model, settings):
        return found
    most_px = settings.most_end_sd_widths * model.width
    ends_told = max(end_sd_px_of(found, model, settings)) < most_px
    count = ends_told + before.frames_explained * (frames == 1)
    if ends_told and count >= settings.least_frames_explained:
        return replace(found, frames_unexplained=0)
    return replace(found, frames_explained=count)


def _explains_all(found: PropagatedBody, model: BodyModel, settings: PropagationSettings) -> bool:
    """Tell whether a body explains its picture as one of its length does.

    Where overlaps are told by their darkness a body of another length leaves something over; and
    the worm's own strokes may be longer.
    """
    plain, marked = settings.most_over_limits_alone, settings.most_over_limits_of_marked_alone
    most = marked if model.is_marked else plain
    if found.over_limits > most or found.hides_slack:
        return False
    off = abs(log(found.path.length / model.length))
    return overlaps_tell(model, settings) or off <= settings.most_log_length_explained
