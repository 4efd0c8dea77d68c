"""Believes a body again that was lost where overlaps are no darker, once it explains many pictures.

One picture of one shade is explained by bodies that lie otherwise, too: strands that lie side by
side are alike. A worm that crawls on parts them.
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
    if found.frames_unexplained == 0 or overlaps_tell(model, settings):
        return found
    if not _explains_all(found, model, settings):
        return found
    count = 1 + before.frames_explained * (frames == 1)
    if count < settings.least_frames_explained:
        return replace(found, frames_explained=count)
    return replace(found, frames_unexplained=0)


def _explains_all(found: PropagatedBody, model: BodyModel, settings: PropagationSettings) -> bool:
    """Tell whether a body explains its picture as one of its length does, both ends told."""
    if found.over_limits > settings.most_over_limits_alone or found.hides_slack:
        return False
    if abs(log(found.path.length / model.length)) > settings.most_log_length_explained:
        return False
    return max(end_sd_px_of(found, model, settings)) < settings.most_end_sd_widths * model.width
