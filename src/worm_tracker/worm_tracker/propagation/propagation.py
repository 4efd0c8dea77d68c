"""Propagates a midline to the next picture where the contour gives none.

A body is slid along itself into the picture; where that does not explain the object, a deformable
body is fitted.
"""

from dataclasses import replace
from math import ceil, floor

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import BodyModel, mean_width
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.midline.s_turns import s_shaped_part
from worm_tracker.midline.self_cover import lies_near_itself
from worm_tracker.observation import Observation
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_sureness import end_sd_px_of, most_end_sd_px
from worm_tracker.propagation.lies_otherwise import followed_or_otherwise, is_due
from worm_tracker.propagation.overlaps import overlaps_tell
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.propagation.traced_anew import traced_anew
from worm_tracker.worm_track import PropagatedBody


def propagate(
    detection: Detection,
    model: BodyModel,
    last: PropagatedBody,
    before: Floats | None,
    frames: int,
    contour_body: RefinedMidline | None,
    settings: PropagationSettings,
) -> PropagatedBody:
    """Propagate the worm's body to an object that touches itself, from where the body was.

    Parameters
    ----------
    detection : Detection
        The object.
    model : BodyModel
        The worm.
    last : PropagatedBody
        Where it was in the last picture that gave a midline.
    before : ndarray, shape (TRACKED_POINTS, 2), or None
        Its midline in the one before, in the same order.
    frames : int
        How many frames ago that was, 1 for the next.
    contour_body : RefinedMidline or None
        A midline that the contour gave, and that seems not to continue the last one.
    settings : PropagationSettings

    Notes
    -----
    An open body that has contracted or stretched is where the contour shows it. Any other is slid
    along itself; where that does not explain the object about as well as before, a deformable body
    is fitted, and slid once more where it was found, which brings it below a pixel.
    """
    scene = CandidateSearch.of(detection, model, last, frames, settings)
    contracted = scene.contracted(contour_body)
    if contracted is not None:
        return scene.in_picture(contracted)
    slid = followed_or_otherwise(scene)
    if slid is None or scene.over_limits(slid) > 1:
        anew = traced_anew(scene)
        if anew is not None:
            return scene.in_picture(anew)
    if slid is not None and _goes_on(scene, slid, may_be_other=contour_body is not None):
        return replace(scene.in_picture(slid), was_slid=scene.keeps_ends(slid))
    starts = [scene.last.points]
    if before is not None:
        starts.append(2 * last.points - before - as_points(np.array([scene.origin])))
    return scene.in_picture(scene.best(slid, starts, contour_body))


def _goes_on(scene: CandidateSearch, slid: Candidate, *, may_be_other: bool) -> bool:
    """Tell whether a body slid along itself is taken, although it may not explain its picture.

    Less does where the contour gives no other body.
    """
    if scene.leaps(slid):
        return False
    settings, expected = scene.settings, scene.body.expected_agreement
    over = scene.over_limits(slid)
    poor = slid.agreement < expected - settings.most_agreement_lost_unsure
    bearable = over < settings.lost_over_limits and not poor
    if not may_be_other and (bearable or not is_due(scene)):
        return True
    return slid.agreement >= expected - settings.most_agreement_lost_sliding and over <= 1


def coiled(detection: Detection, followed: Observation | None = None) -> Observation:
    """Return the observation of an object without a midline that can be told."""
    return Observation(Status.COILED, *detection.centroid(), followed=followed)


def observation_of(
    body: PropagatedBody,
    model: BodyModel,
    confidence: float,
    settings: PropagationSettings,
) -> Observation:
    """Return the observation of a propagated body; the centroid is that of what is seen."""
    u, v = body.centroid.real, body.centroid.imag
    width = mean_width(model.widths)
    step = body.path.length / (len(body.points) - 1)
    folded = lies_near_itself(body.path.curve, width, body.path.step)
    end_sd_px = end_sd_px_of(body, model, settings)
    most_sd_px = most_end_sd_px(body, model, settings)
    first, last = (
        0 if sd < most_sd_px and not is_broad else 1 + ceil(2 * max(sd, is_broad * width) / step)
        for sd, is_broad in zip(end_sd_px, body.broad_ends, strict=True)
    )
    seen = Status.FOLDED if folded else Status.TRACKED
    may_be_s = folded and model.is_marked and overlaps_tell(model, settings)
    in_doubt = _points_in_doubt(body, model.width, may_be_s, settings)
    seen = seen if in_doubt == (0, 0) else Status.LOOP_IN_DOUBT
    return Observation(
        Status.END_HIDDEN if first or last else seen,
        u,
        v,
        body.points,
        model.widths,
        confidence,
        model.half_height_width,
        occluded=(min(first, len(body.points)), min(last, len(body.points))),
        end_sd_px=end_sd_px,
        seen_end_sd_px=body.end_sd_px,
        broad_ends=body.broad_ends,
        in_doubt=in_doubt,
        over_limits=body.over_limits,
        overlaps_tell=overlaps_tell(model, settings),
        by_marks=body.doubt_by_bends != body.loop_in_doubt,
        order_known=body.order_known and _ends_told(body, settings) and not (first or last),
    )


def _ends_told(body: PropagatedBody, settings: PropagationSettings) -> bool:
    """Tell whether enough of either end lies in no loop in doubt for the widths to tell.

    An end on a strand lies about where it was said to be, whichever way its loop is passed.
    """
    if body.loop_in_doubt is None:
        return True
    beside = [part for part in (body.loop_in_doubt[0], 1 - body.loop_in_doubt[1]) if part > 0]
    return bool(beside) and min(beside) > settings.least_told_at_ends


def _points_in_doubt(
    body: PropagatedBody, width: float, may_be_s: bool, settings: PropagationSettings
) -> tuple[int, int]:
    """Return from which of a body's points to before which it may lie otherwise.

    In a loop in doubt; or, of a folded one with marks, in an S that no worm makes: its ends are
    seen, but what is between has come onto another strand there, or was led round one.
    """
    count = len(body.points)
    first, behind = _points_of(body.loop_in_doubt, count)
    if not may_be_s:
        return first, behind
    least, within = settings.most_s_turn_of_marked_rad, settings.s_turn_within_widths
    s_shaped = s_shaped_part(body.points, width, least, within)
    if s_shaped is None:
        return first, behind
    s_first, s_behind = _points_of(s_shaped, count)
    s_first, s_behind = max(s_first, 1), min(s_behind, count - 1)
    return (s_first, s_behind) if behind == 0 else (min(first, s_first), max(behind, s_behind))


def _points_of(part: tuple[float, float] | None, count: int) -> tuple[int, int]:
    """Return from which of a midline's points to before which a part of its length is."""
    if part is None:
        return 0, 0
    return floor(part[0] * (count - 1)), 1 + ceil(part[1] * (count - 1))
