"""How dark the overlaps of a worm are, and what its marks tell of them."""

from dataclasses import replace

import cv2
import numpy as np

from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.body_residual import BodyResidualSettings, dark_places
from worm_tracker.midline.body_shade import ACROSS
from worm_tracker.midline.curve import median_of
from worm_tracker.midline.drawn_skin import SkinnedBody
from worm_tracker.midline.end_marks import has_marks
from worm_tracker.midline.overlap_darkening import overlap_darkening
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def marked_ends(model: BodyModel, settings: PropagationSettings) -> tuple[bool, bool]:
    """Tell of each end whether it is pale, and has marks of its own, which tell where it is."""
    if not model.is_marked:
        return False, False
    first, last = (
        is_pale and has_marks(levels, model.length, model.width, settings.end_marks)
        for is_pale, levels in zip(model.pale_ends, (model.levels, model.levels[::-1]), strict=True)
    )
    return first, last


def overlaps_tell(model: BodyModel, settings: PropagationSettings) -> bool:
    """Tell whether overlaps are so much darker that the picture shows what lies in them."""
    return model.darkening > settings.residual.least_darkening


def darkening_of(
    detection: Detection, model: BodyModel, least_widths2: float, settings: BodyResidualSettings
) -> float | None:
    """Return how much darker the object is where it is darkest; None where it is of one shade."""
    view = detection.view
    levels = model.levels_at(detection.gain)
    level = float(levels.max())
    dark = dark_places(view.found_in, level, 2 * settings.least_darkening, settings)
    least_area = least_widths2 * model.width**2
    if cv2.countNonZero(dark) < least_area:  # most frames; the object need not be drawn
        return None
    cv2.bitwise_and(dark, detection.object_pixels(), dst=dark)
    if cv2.countNonZero(dark) < least_area:
        return None
    darkening = float(np.median(view.found_in[dark > 0]) / np.median(levels)) - 1
    return darkening if darkening < settings.most_darkening else None


def as_dark_as(detection: Detection, model: BodyModel, settings: PropagationSettings) -> BodyModel:
    """Return a worm whose overlaps are as dark as an object's darkest places, where it has some.

    Those of a marked one may be its marks: they do not tell once it was followed into overlaps
    (`as_dark_as_followed`), and never where it is bright.
    """
    if model.knows_overlaps:
        return model
    if not settings.darkest_of_marked_are_overlaps and model.is_marked:
        return replace(model, darkening=0.0)
    residual = settings.residual
    darkening = darkening_of(detection, model, residual.least_dark_widths2, residual)
    return model if darkening is None else model.with_darkening(darkening)


def as_dark_as_followed(
    detection: Detection, model: BodyModel, found: PropagatedBody, settings: PropagationSettings
) -> BodyModel:
    """Return a marked worm whose overlaps are as dark as those that a body was followed into."""
    if not found.is_explained or not model.is_marked:
        return model
    if not model.overlap_is_due:
        return replace(model, overlaps_left_out=model.overlaps_left_out + 1)
    model = replace(model, overlaps_left_out=0)
    view, levels = detection.view, model.levels_at(detection.gain)
    curve = found.path.shifted(-complex(*view.origin)).curve
    shade = model.shade_at(detection.gain)
    mean = np.repeat(levels[:, None], len(ACROSS), axis=1) if shade is None else shade.mean
    body = SkinnedBody(curve, model.widths, mean, median_of(levels), model.darkening)
    darkening = overlap_darkening(view.smooth, body, model.width, settings.overlaps)
    return model if darkening is None else model.with_overlap(darkening)
