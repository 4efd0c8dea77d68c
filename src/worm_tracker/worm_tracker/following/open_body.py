"""What is said of a body that the contour shows, its ends unsure where they may be bent back."""

from dataclasses import replace
from math import ceil, log

from worm_msgs_py.contract.status import Status
from worm_tracker.detection.detection import SignalView
from worm_tracker.head_tail.appearance import appearance_difference
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.body_residual import BodyResidualSettings
from worm_tracker.midline.contour_body import broad_contour_ends
from worm_tracker.midline.curve import length_of
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.observation import Observation


def open_body(
    found: RefinedMidline,
    agreement: float,
    view: SignalView,
    model: BodyModel | None,
    settings: BodyResidualSettings,
) -> Observation:
    """Return the observation of a refined midline.

    An end that bends back flat onto its own flank makes the body broad there, and the bend is taken
    for the end. So it is unsure by half a width, and hidden where the body is shorter, too; but not
    that of a skin with marks, whose pale rims come and go.

    Parameters
    ----------
    found : RefinedMidline
        In the order of the body model's widths.
    agreement : float
        How well it explains the object, 0 to 1.
    view : SignalView
    model : BodyModel or None
        The worm, where it is known.
    settings : BodyResidualSettings
    """
    appearance = appearance_difference(found.points, found.widths, view.found_in, view.origin)
    body = found.u, found.v, found.points, found.widths
    seen = Observation(Status.TRACKED, *body, agreement, found.width, appearance=appearance)
    if model is None or not model.is_learned:
        return seen
    broad, length = broad_contour_ends(found, model, settings), length_of(found.points)
    if not any(broad):
        return seen
    first_px, last_px = (each * settings.sd_of_broad_end_widths * model.width for each in broad)
    seen = replace(seen, end_sd_px=(first_px, last_px))
    if model.is_marked or log(model.length / length) < settings.least_log_shortening_of_bent:
        return seen
    count = min(1 + ceil(2 * model.width * (len(found.points) - 1) / length), len(found.points))
    first, last = (count * each for each in broad)
    return replace(seen, status=Status.END_HIDDEN, occluded=(first, last), broad_ends=broad)
