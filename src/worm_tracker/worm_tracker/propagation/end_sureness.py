"""How surely the ends of a body that lies on itself are where they are said to be."""

from math import log

import numpy as np

from worm_tracker.midline.body_model import BodyModel, mean_width
from worm_tracker.midline.self_cover import ends_on_body, lies_near_itself
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def end_sd_px_of(
    body: PropagatedBody, model: BodyModel, settings: PropagationSettings
) -> tuple[float, float]:
    """Return how surely the ends are where they are said to be.

    The picture does not tell an end that lies on the body where overlaps are no darker, nor one so
    pale that it adds little: edges of what it lies on are taken for its own. It is no surer than
    the length agrees with the known one, and than the worm keeps its length. Nor are two that
    coincide, either of which may be the other, nor is a pale one of a folded body shorter than a
    stroke makes it: the object may have been seen without it.
    """
    folded = lies_near_itself(body.path.curve, mean_width(model.widths), body.path.step)
    near_px = settings.near_end_widths * model.width
    on_body = ends_on_body(body.path.curve, near_px, body.path.step)
    off = max(abs(body.path.length - model.length), model.length_scatter * model.length)
    short = folded and log(model.length / body.path.length) > settings.most_log_shortening_of_pale
    dark = overlaps_tell(model, settings)
    apart_px = float(np.hypot(*(body.points[0] - body.points[-1])))
    coincide = folded and apart_px < settings.coinciding_ends_widths * model.width
    if coincide and max(body.end_sd_px) > settings.most_end_sd_of_coinciding_widths * model.width:
        return model.width, model.width
    first, last = (
        max(sd, off * ((on and (is_pale or not dark)) or (short and is_pale)))
        for sd, on, is_pale in zip(body.end_sd_px, on_body, model.pale_ends, strict=True)
    )
    return first, last


def most_end_sd_px(body: PropagatedBody, model: BodyModel, settings: PropagationSettings) -> float:
    """Return how unsure an end may be and still be told, pixels.

    What a body with a loop in doubt leaves over, though it is little enough to be believed, may be
    an unsure end that lies elsewhere.
    """
    most = settings.most_end_sd_widths
    if overlaps_tell(model, settings):
        most = settings.most_end_sd_in_darker_overlap_widths
    if not body.loops_known and body.over_limits > settings.most_over_limits_of_unsure_end:
        most = min(most, settings.most_end_sd_beside_left_over_widths)
    return most * mean_width(model.widths)


def overlaps_tell(model: BodyModel, settings: PropagationSettings) -> bool:
    """Tell whether overlaps are so much darker that the picture shows what lies in them."""
    return model.darkening > settings.residual.least_darkening
