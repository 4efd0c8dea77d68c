"""Whether a body that an object's contour gives is all of the worm in it, but for debris."""

from dataclasses import replace
from math import log

import cv2
import numpy as np

from worm_msgs_py.arrays import Picture
from worm_tracker.midline.body_model import BodyModel, mean_width
from worm_tracker.midline.body_residual import (
    BodyResidualSettings,
    ObjectMasks,
    Unexplained,
    dark_places,
    ends_and_bends,
    unexplained,
)
from worm_tracker.midline.curve import length_of
from worm_tracker.midline.refine import RefinedMidline


def explains_object(
    found: RefinedMidline,
    smooth: Picture,
    mask: Picture,
    folded: bool,
    model: BodyModel | None,
    settings: BodyResidualSettings,
) -> bool:
    """Tell whether a body is all of its object, but for debris beside an open one.

    Parameters
    ----------
    found : RefinedMidline
        Its points in the coordinates of the picture's window.
    smooth : ndarray of uint8, shape (h, w)
        The smoothed signal.
    mask : ndarray of uint8, shape (h, w)
        The object; 0 or 255.
    folded : bool
        Whether the body lies near itself, or may lie on itself with an end.
    model : BodyModel or None
        The worm, where it is known.
    settings : BodyResidualSettings
    """
    dark = dark_places(smooth, found.level, 2 * settings.least_darkening, settings)
    width = mean_width(found.widths)
    masks = ObjectMasks(mask, np.asarray(dark & mask), width, settings)
    differs = unexplained(masks, found.points, found.widths)
    ends = ends_and_bends(found.points, width, settings)
    if not folded and not differs.wants_near(ends, settings.end_widths * width):
        if model is not None and model.lacks(length_of(found.points), differs.left_over):
            return False
        return differs.in_water + differs.overlap < settings.most_of_contour_body
    if model is not None and _lacks_end(found, differs, mask, width, settings):
        return False
    most = settings.most_of_folded_body if folded else settings.most_of_contour_body
    return differs.total < most


def may_hide_end(
    found: RefinedMidline,
    model: BodyModel,
    most_log_shortening: float,
    settings: BodyResidualSettings,
) -> bool:
    """Tell whether an end may lie on the body: it is short, or broad where it ends.

    Parameters
    ----------
    found : RefinedMidline
        In the order of the body model's widths.
    model : BodyModel
    most_log_shortening : float
        By how much a body may be shorter than is known.
    settings : BodyResidualSettings
    """
    if log(model.length / length_of(found.points)) > most_log_shortening:
        return True
    return model.is_learned and any(broad_contour_ends(found, model, settings))


def broad_contour_ends(
    found: RefinedMidline, model: BodyModel, settings: BodyResidualSettings
) -> tuple[bool, bool]:
    """Tell of each end whether a body is broader there than the worm: it may be a bend beside it.

    An end that is bent back on itself makes the object broad there, and so the body found in it.

    Parameters
    ----------
    found : RefinedMidline
        In the order of the body model's widths.
    model : BodyModel
    settings : BodyResidualSettings
    """
    step = length_of(found.points) / (len(found.points) - 1)
    near = 1 + round(settings.broad_end_widths * model.width / step)
    scale = mean_width(found.widths) / mean_width(model.widths)
    over_px2 = (found.widths - scale * model.widths) * step
    if model.is_marked:
        most_widths2 = settings.most_broader_at_marked_end_widths2
    else:
        most_widths2 = settings.most_broader_at_end_widths2
    most_px2 = most_widths2 * model.width**2
    return bool(over_px2[:near].sum() > most_px2), bool(over_px2[-near:].sum() > most_px2)


def _lacks_end(
    found: RefinedMidline,
    differs: Unexplained,
    mask: Picture,
    width: float,
    settings: BodyResidualSettings,
) -> bool:
    """Tell whether the object goes on beside an end: one bent like a hook was cut at its bend."""
    left = np.asarray(cv2.bitwise_and(mask, cv2.bitwise_not(differs.near)), np.uint8)
    beside = replace(differs, wanted=left)
    most_px2, reach = settings.most_lacked_at_end_widths2 * width**2, settings.end_widths * width
    return any(beside.missing_px2(end, reach) > most_px2 for end in found.points[[0, -1]])
