"""Ends of a worm that are paler than the rest of it: below the threshold, on the body's axis."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.blobs import draw_blob
from worm_tracker.detection.detection import Detection, DetectionPrior
from worm_tracker.midline.contour_midline import ContourMidlineSettings, contour_midline


@dataclass(frozen=True, slots=True)
class PaleEndSettings:
    """What beside an object is a part of the worm, although it is paler."""

    signal_over_threshold: float = 0.45
    """Signal of a pale end over the threshold: a fifth of the body's."""
    signal_over_noise: float = 2.5
    """The same over the noise of a pixel, which smoothing makes a third as large."""
    rim_widths: float = 0.22
    """How far about an object what is dark is its own soft edge."""
    least_area_widths2: float = 0.3
    """A smaller piece may be noise, or the last of a soft tip."""
    most_area_over_object: float = 0.4
    """A larger one is no end of it."""
    most_thickness_widths: float = 1.2
    most_gap_widths: float = 0.9
    """How far from an end a piece may begin, its rim included."""
    most_off_axis_rad: float = 0.7
    """How far from the axis of the end a piece may lie, as seen from within it."""
    axis_part: float = 0.08
    """Part of the midline from which an end has its axis."""
    complete_area_over_known: float = 0.97
    """Area from which nothing is missing."""
    learning_frames: int = 12
    """Midlines until which a piece is looked for at each frame, and between two looks later."""


def may_miss_an_end(detection: Detection, prior: DetectionPrior, settings: PaleEndSettings) -> bool:
    """Tell whether a pale end may be missing from an object.

    It is small, or the worm's end is known to be pale, which a stretched worm's area does not show,
    or a look is due.
    """
    model = prior.model
    if model is None or model.frames % settings.learning_frames == 0:
        return True
    small = detection.blob.area < settings.complete_area_over_known * model.area
    return small or model.frames < settings.learning_frames or any(model.pale_ends)


def with_pale_ends(
    detection: Detection, prior: DetectionPrior, noise: float, settings: PaleEndSettings
) -> Detection:
    """Return a detection with what continues its ends below the threshold.

    There the smoothed signal is raised so much that the usual threshold is right (`raised`); how
    dark the end is by itself stays in `smooth`.

    Parameters
    ----------
    detection : Detection
        The object that is the worm.
    prior : DetectionPrior
    noise : float
        Standard deviation of a pixel, grey levels.
    settings : PaleEndSettings
    """
    view, blob = detection.view, detection.blob
    faint = settings.signal_over_threshold * view.threshold
    faint = max(faint, settings.signal_over_noise * noise)
    if faint >= view.threshold:
        return detection
    width = prior.model.width if prior.model else detection.thickness()
    pieces = _pieces(detection, faint, width, settings)
    if not pieces:
        return detection
    seen = contour_midline(blob.contour, width, prior.body, ContourMidlineSettings())
    if seen is None:
        return detection
    line = view.in_window(seen.points)
    ends = [piece for piece in pieces if _continues(piece, line, width, settings)]
    if not ends:
        return detection
    reach = 2 * round(settings.rim_widths * width + 1) + 1
    where = cv2.dilate(np.bitwise_or.reduce(ends), np.ones((reach, reach), np.uint8))
    stronger = cv2.convertScaleAbs(view.smooth, alpha=view.threshold / faint)
    raised = np.asarray(np.where(where > 0, stronger, view.smooth), np.uint8)
    whole = replace(view, raised=raised)
    grown = [each for each in whole.blobs() if each.area > blob.area]
    if not grown:
        return detection
    nearest = min(grown, key=lambda each: abs(each.u - blob.u) + abs(each.v - blob.v))
    return replace(detection, view=whole, blob=nearest)


def _pieces(
    detection: Detection, faint: float, width: float, settings: PaleEndSettings
) -> list[Picture]:
    """Return what is faint beside the object, each piece as a mask of the window."""
    view, area = detection.view, detection.blob.area
    rim = max(2, round(settings.rim_widths * width))
    _, dark = cv2.threshold(view.smooth, faint, 255, cv2.THRESH_BINARY)
    beside = cv2.subtract(dark, draw_blob(detection.blob, view.window, rim))
    least, most = settings.least_area_widths2 * width**2, settings.most_area_over_object * area
    if cv2.countNonZero(beside) < least:  # nearly always
        return []
    count, labels, stats, _ = cv2.connectedComponentsWithStats(beside)
    sizes = stats[:, cv2.CC_STAT_AREA]
    wanted = (sizes > least) & (sizes < most)
    return [
        np.asarray((labels == k).view(np.uint8) * 255, np.uint8)
        for k in range(1, count)
        if wanted[k]
    ]


def _continues(piece: Picture, line: Floats, width: float, settings: PaleEndSettings) -> bool:
    """Tell whether a piece lies beyond an end of a midline, on its axis, and is no broader."""
    v, u = np.nonzero(piece)
    if 2 * float(cv2.distanceTransform(piece, cv2.DIST_L2, 3).max()) > (
        settings.most_thickness_widths * width
    ):
        return False
    k = max(2, round(settings.axis_part * len(line)))
    for end, inner in ((line[0], line[k]), (line[-1], line[-1 - k])):
        axis = complex(*(end - inner))
        away = (u - inner[0]) + 1j * (v - inner[1])
        beyond = away / axis * abs(axis) - abs(axis)
        if float(np.abs(beyond).min()) > settings.most_gap_widths * width:
            continue
        near = away[np.abs(beyond) < 2 * width]
        if abs(np.angle(near.mean() / axis)) < settings.most_off_axis_rad:
            return True
    return False
