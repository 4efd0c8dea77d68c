"""Ends of a worm that are paler than the rest of it: below the threshold, on the body's axis."""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.blobs import Blob, draw_blob, thickness
from worm_tracker.detection.detection import Detection, DetectionPrior, SignalView
from worm_tracker.midline.contour_midline import ContourMidlineSettings, contour_midline
from worm_tracker.midline.occupied_part import occupied_box, occupied_part

_WITHIN = np.s_[1:-1, 1:-1]
"""A window but for its outermost pixels."""


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
    followed_part: float = 0.3
    followed_widths: float = 1.5
    least_part_followed: float = 0.6
    """Part of the body's length that an end is, and how much of a piece must lie as near to where
    that end was in the picture beside."""
    least_area_followed_widths2: float = 0.12
    """A smaller piece there may be noise: a thin tail's is smaller than what is found by itself."""
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
    detection: Detection, prior: DetectionPrior, settings: PaleEndSettings, *, may_be_cut: bool
) -> Detection | None:
    """Return a detection with what continues its ends below the threshold; None if that is cut off.

    There the smoothed signal is raised so much that the usual threshold is right (`raised`); how
    dark the end is by itself stays in `smooth`.

    Parameters
    ----------
    detection : Detection
        The object that is the worm.
    prior : DetectionPrior
    settings : PaleEndSettings
    may_be_cut : bool
        Whether the window is not all of the picture, so that an end may go on beyond it.
    """
    if not may_miss_an_end(detection, prior, settings):
        return detection
    width = prior.model.width if prior.model else detection.thickness()
    pieces = _pieces(detection, width, settings, settings.least_area_widths2)
    if not pieces:
        return detection
    if may_be_cut and _is_any_cut(pieces, detection, width, settings):
        return None
    seen = contour_midline(detection.blob.contour, width, prior.body, ContourMidlineSettings())
    if seen is None:
        return detection
    line = detection.view.in_window(seen.points)
    ends = [piece for piece in pieces if _continues(piece, line, width, settings)]
    return _raised(detection, ends, width, settings)


def with_followed_ends(
    detection: Detection, width: float, body: Floats, settings: PaleEndSettings
) -> Detection:
    """Return a detection with what lies below the threshold where an end was followed to.

    In a fold no contour tells where an end is, and one that is thin or out of focus comes and goes
    with the threshold: a body that loses it is followed along another strand. As with
    `with_pale_ends`, `raised` changes alone.

    Parameters
    ----------
    detection : Detection
    width : float
        The body's, pixels.
    body : ndarray, shape (n, 2)
        Where it lay in the picture beside.
    settings : PaleEndSettings
    """
    pieces = _pieces(detection, width, settings, settings.least_area_followed_widths2)
    if not pieces:
        return detection
    part = round(settings.followed_part * (len(body) - 1))
    line = detection.view.in_window(body)
    near = [
        _around(stretch, settings.followed_widths * width, pieces[0])
        for stretch in (line[: part + 1], line[-1 - part :])
    ]
    ends = [piece for piece in pieces if any(_lies_in(piece, each, settings) for each in near)]
    return _raised(detection, ends, width, settings)


def kept_for_later(detection: Detection, margin_px: int, settings: PaleEndSettings) -> Detection:
    """Return what must be kept to look at an object later: a small window around it.

    And around what may turn out to be its pale end, once it is known to have one.
    """
    u0, v0 = detection.view.origin
    boxes = [detection.blob.box]
    body_px = thickness(detection.object_pixels())
    for piece in _pieces(detection, body_px, settings, settings.least_area_widths2):
        u, v, width, height = cv2.boundingRect(piece)
        boxes.append((u0 + u, v0 + v, u0 + u + width - 1, v0 + v + height - 1))
    corners = np.array(boxes)
    first, last = corners[:, :2].min(axis=0), corners[:, 2:].max(axis=0)
    return detection.cropped(margin_px, (int(first[0]), int(first[1]), int(last[0]), int(last[1])))


def _faint(view: SignalView, settings: PaleEndSettings) -> float:
    """Return the signal from which on something may be an end."""
    faint = settings.signal_over_threshold * view.threshold
    return max(faint, settings.signal_over_noise * view.noise)


def _raised(
    detection: Detection, ends: list[Picture], width: float, settings: PaleEndSettings
) -> Detection:
    """Return a detection with some pieces beside its object as a part of it."""
    view, blob = detection.view, detection.blob
    if not ends:
        return detection
    reach = 2 * round(settings.rim_widths * width + 1) + 1
    where = cv2.dilate(np.bitwise_or.reduce(ends), np.ones((reach, reach), np.uint8))
    alpha = view.threshold / _faint(view, settings)
    stronger = cv2.max(cv2.convertScaleAbs(view.smooth, alpha=alpha), view.found_in)
    raised = np.asarray(np.where(where > 0, stronger, view.found_in), np.uint8)
    whole = replace(view, raised=raised)
    grown = [each for each in whole.blobs() if each.area > blob.area]
    if not grown:
        return detection
    nearest = min(grown, key=lambda each: abs(each.u - blob.u) + abs(each.v - blob.v))
    return replace(detection, view=whole, blob=nearest)


def _pieces(
    detection: Detection, width: float, settings: PaleEndSettings, least_widths2: float
) -> list[Picture]:
    """Return what is faint beside the object and larger than that, each a mask of the window."""
    view, area = detection.view, detection.blob.area
    faint = _faint(view, settings)
    if faint >= view.threshold:
        return []
    rim = max(2, round(settings.rim_widths * width))
    beside = _faint_beside(detection.blob, view, faint, rim)
    least, most = least_widths2 * width**2, settings.most_area_over_object * area
    if cv2.countNonZero(beside) < least:  # nearly always
        return []
    box = occupied_box(beside)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(beside[box])
    sizes = stats[:, cv2.CC_STAT_AREA]
    wanted = (sizes > least) & (sizes < most)
    pieces = np.zeros((int(wanted[1:].sum()), *beside.shape), np.uint8)
    for piece, k in zip(pieces, 1 + np.flatnonzero(wanted[1:]), strict=True):
        piece[box][labels == k] = 255
    return list(pieces)


@lru_cache(maxsize=2)  # both a pale end and one that was followed are looked for in a picture
def _faint_beside(blob: Blob, view: SignalView, faint: float, rim: int) -> Picture:
    """Return what has more signal than that and lies beyond an object's rim; 0 or 255."""
    _, dark = cv2.threshold(view.smooth, faint, 255, cv2.THRESH_BINARY)
    return np.asarray(cv2.subtract(dark, draw_blob(blob, view.window, rim)), np.uint8)


def _is_any_cut(
    pieces: list[Picture], detection: Detection, width: float, settings: PaleEndSettings
) -> bool:
    """Tell whether one of some pieces beside the object reaches the edge of the window."""
    cut = [piece for piece in pieces if cv2.countNonZero(piece) > np.count_nonzero(piece[_WITHIN])]
    if not cut:
        return False
    reach = round(settings.most_gap_widths * width)
    beside = draw_blob(detection.blob, detection.view.window, reach)
    return any(bool(cv2.bitwise_and(piece, beside).any()) for piece in cut)


def _continues(piece: Picture, line: Floats, width: float, settings: PaleEndSettings) -> bool:
    """Tell whether a piece lies beyond an end of a midline, on its axis, and is no broader."""
    within = cv2.distanceTransform(occupied_part(piece), cv2.DIST_L2, 3)
    if 2 * float(within.max()) > settings.most_thickness_widths * width:
        return False
    rows, columns = box = occupied_box(piece)
    v, u = np.nonzero(piece[box])
    v, u = v + rows.start, u + columns.start
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


def _lies_in(piece: Picture, mask: Picture, settings: PaleEndSettings) -> bool:
    """Tell whether most of a piece lies within a mask."""
    inside = cv2.countNonZero(cv2.bitwise_and(piece, mask))
    return inside > settings.least_part_followed * cv2.countNonZero(piece)


def _around(line: Floats, radius: float, like: Picture) -> Picture:
    """Return where a window is as near to a line (n, 2) in it as this; 0 or 255."""
    mask = np.zeros_like(like)
    points = np.rint(16 * line).astype(np.int32)
    cv2.polylines(mask, [points], False, 255, max(1, round(2 * radius)), cv2.LINE_8, 4)
    return mask
