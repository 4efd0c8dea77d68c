"""What can be measured when part of the body is occluded."""

from dataclasses import replace

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_tracker.detection.detection import Detection, Occlusion
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.curve import arc_length
from worm_tracker.midline.refine import RefinedMidline


def occluded_points(points: Floats, occlusion: Occlusion) -> tuple[int, int]:
    """Return how many points at a midline's first, and last, end were not seen but supposed.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        The midline of a body that was drawn in where it is occluded.
    occlusion : Occlusion
    """
    ends = occlusion.ends
    straight = np.hypot(*(points[[0, -1]] - ends).T).sum()
    turned = np.hypot(*(points[[-1, 0]] - ends).T).sum()
    first, last = occlusion.occluded_ends
    if turned < straight:
        first, last, ends = last, first, ends[::-1]
    upto = [int(np.hypot(*(points - end).T).argmin()) for end in ends]
    return upto[0] + 1 if first else 0, len(points) - upto[1] if last else 0


def with_known_width(
    midline: RefinedMidline, detection: Detection, model: BodyModel | None
) -> RefinedMidline:
    """Return a body that is as wide in glare as it is known to be, or as it is elsewhere.

    Parameters
    ----------
    midline : RefinedMidline
        Points and widths in the order of those that are known.
    detection : Detection
    model : BodyModel or None
        None where nothing is known yet.
    """
    if detection.occluder is None:
        return midline
    inside = detection.is_occluder_at(midline.points)
    if not inside.any() or inside.all():
        return midline
    usual = np.median(midline.widths[~inside]) if model is None else model.widths
    widths = np.where(inside, usual, midline.widths)
    within = midline.half_height_widths
    soft = np.median(within[~inside]) / max(float(np.median(midline.widths[~inside])), 1e-9)
    half_height = np.where(inside, soft * usual, within)
    step = np.gradient(arc_length(midline.points))
    area = midline.area + float((widths - midline.widths) @ step)
    before, more = float(within @ step), (half_height - within) * step
    centre = before * np.array([midline.u, midline.v]) + more @ midline.points
    u, v = (centre / max(before + float(more.sum()), 1e-9)).tolist()
    return replace(midline, widths=widths, half_height_widths=half_height, area=area, u=u, v=v)
