"""What is not worm: debris that hangs on to it is cut off, debris beside it becomes background."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Mask, Picture
from worm_tracker.detection.background import Background
from worm_tracker.detection.blobs import (
    Blob,
    BlobSettings,
    Window,
    draw_blob,
    find_blobs,
    holds_wormlike_piece,
    smoothed,
    window_around,
    window_origin,
)
from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import BodyModel


@dataclass(frozen=True, slots=True)
class DebrisCuttingSettings:
    """What is cut off the worm as debris that hangs on to it."""

    overgrown_area_over_known: float = 1.04
    """Area from which an object is looked at for what hangs on to it: the learned area is good to
    a few per cent."""
    body_margin_widths: float = 0.4
    """How far beside the body, as it was, the worm's own pixels may lie."""
    ahead_of_ends_widths: float = 1.5
    """How far beyond its last ends the worm may have got in a frame."""
    thinnest_body_widths: float = 0.6
    """What is thinner is no body."""
    openings_over_thickest: tuple[float, ...] = (0.4, 0.55, 0.7)
    """Parts of an object thinner than these, relative to its thickest, are cut off in turn where
    the worm's width is not known."""
    least_area_over_object: float = 0.75
    """The worm is at least this part of the object."""


@dataclass(frozen=True, slots=True)
class DebrisSettings:
    """What beside the worm is absorbed into the background as debris."""

    crowded_area_over_known: float = 1.04
    """Area of the worm from which something hangs on to it: debris is then looked for at once."""
    change_over_threshold: float = 0.5
    """Change of the background, over the threshold, that is absorbed at once."""
    change_over_noise: float = 3.5
    """The same, over the noise, where there is debris in the background already."""
    check_every_frames: int = 12
    """How often such changes are looked for where nothing is seen."""
    largest_area_over_worm: float = 0.5
    """The largest object that is taken for debris: a larger one may be another worm."""
    around_worm_widths: float = 6.0
    least_around_worm_px: int = 24
    """How far around the worm they are looked for."""
    untouched_about_ends_widths: float = 2.0
    """How far around the worm's ends nothing is taken for debris: an end is where it moves to."""
    all_worm_area_over_known: float = 1.1
    """Area below which all of the object is the worm."""
    drawn_width_over_known: float = 1.25
    drawn_rim_px: int = 4
    """How wide a worm is drawn for what is not debris: with its blur."""
    worm_blur_px: int = 5
    """How far around the worm its blur may darken the background."""
    dirt_rim_px: int = 2
    """How far around dirt that is seen beside the worm it shows nothing of a worm."""
    blobs: BlobSettings = field(default_factory=BlobSettings)


def without_debris(
    detection: Detection,
    model: BodyModel | None,
    body: Floats | None,
    frames: int,
    settings: DebrisCuttingSettings,
) -> Iterator[Detection]:
    """Return detections in which the worm may be told from what hangs on to it, likeliest first.

    Parameters
    ----------
    detection : Detection
        The object as it is.
    model : BodyModel or None
        The worm; nothing is known of it in the first frames.
    body : ndarray, shape (TRACKED_POINTS, 2), or None
        Its midline when it was last seen.
    frames : int
        How many frames ago that was, 1 for the next.
    settings : DebrisCuttingSettings
    """
    if model is None:
        yield detection
        yield from _without_thin_parts(detection, settings)
        return
    if body is not None and detection.blob.area > settings.overgrown_area_over_known * model.area:
        near = _corridor(detection, body, model.width, frames, settings)
        cut = detection.restricted_to(near)
        if cut is not None:
            yield cut
            left = _without_thin(cut, round(settings.thinnest_body_widths * model.width))
            if left is not None:
                yield left
    yield detection


def _corridor(
    detection: Detection, body: Floats, width: float, frames: int, settings: DebrisCuttingSettings
) -> Picture:
    """Return the neighbourhood of a body, and the way on of its ends, as a mask of the window."""
    mask = np.zeros(detection.view.smooth.shape, np.uint8)
    points = detection.view.in_window(body)
    line, ahead = [points], settings.ahead_of_ends_widths * width * frames
    for end, inner in ((points[0], points[6]), (points[-1], points[-7])):
        way = end - inner
        way = way / max(float(np.hypot(*way)), 1e-9)
        line.append(np.stack([end, end + ahead * way]))
    thick = max(3, round((1 + 2 * settings.body_margin_widths) * width))
    for part in line:
        cv2.polylines(mask, [np.rint(16 * part).astype(np.int32)], False, 255, thick, 8, 4)
    return mask


def _without_thin_parts(
    detection: Detection, settings: DebrisCuttingSettings
) -> Iterator[Detection]:
    """Return what is left of the object where thin parts fall off: ever thicker ones."""
    mask = detection.view.above_threshold()
    thickest = 2 * float(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max())
    for part in settings.openings_over_thickest:
        size = round(part * thickest)
        left = _without_thin(detection, size) if size >= 3 else None
        least = settings.least_area_over_object * detection.blob.area
        if left is not None and left.blob.area > least:
            yield left


def _without_thin(detection: Detection, size: int) -> Detection | None:
    """Return what is left of the object where nothing thinner than `size` pixels is."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    opened = cv2.morphologyEx(detection.view.above_threshold(), cv2.MORPH_OPEN, kernel)
    return detection.restricted_to(np.asarray(opened, np.uint8))


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """All of a worm in a picture: whatever else has changed there is debris.

    Attributes
    ----------
    picture : ndarray of uint8, shape (h, w)
    gain : float
        Its brightness over the background's.
    arena : ndarray of uint8, shape (h, w)
        Not zero where a worm can be.
    empty : ndarray of uint8, shape (h, w)
        The rig without worm and debris.
    model : BodyModel
    blob : Blob
    body : ndarray, shape (TRACKED_POINTS, 2)
        The worm.
    threshold, noise : float
        Signal of an object, and standard deviation of the noise, grey levels.
    """

    picture: Picture
    gain: float
    arena: Picture
    empty: Picture
    model: BodyModel
    blob: Blob
    body: Floats
    threshold: float
    noise: float


def absorb_debris(background: Background, seen: Surroundings, settings: DebrisSettings) -> None:
    """Take what came, or left, beside the worm for background at once.

    The worm only makes things darker: where a picture is brighter than the background, dirt or a
    bubble has left. What is darker away from all of the worm is none of it, unless it is large
    enough to be another one.
    """
    around = round(settings.around_worm_widths * seen.model.width)
    around = max(settings.least_around_worm_px, around)
    window = window_around(seen.blob.box, around, seen.picture.shape)
    where = _debris_in(window, background, seen, settings)
    if where is not None and where.any():
        background.absorb(seen.picture, seen.gain, window, where)


def _debris_in(
    window: Window, background: Background, seen: Surroundings, settings: DebrisSettings
) -> Mask | None:
    """Return where in a window debris came or left; None where nothing changed."""
    level = settings.change_over_threshold * seen.threshold
    now, ground = seen.picture[window], background.scaled(seen.gain, window)
    signal = background.signal(seen.picture, seen.gain, window)
    cv2.bitwise_and(signal, seen.arena[window], dst=signal)
    signal = smoothed(signal)
    worm, ends = _worm_in(window, seen, settings)
    dim = background.dim.any_in(window)
    least = settings.change_over_noise * seen.noise if dim else level
    _, gone = cv2.threshold(cv2.subtract(now, ground), least, 255, cv2.THRESH_BINARY)
    _, there = cv2.threshold(signal, least, 255, cv2.THRESH_BINARY)
    cv2.bitwise_and(there, cv2.bitwise_not(worm), dst=there)
    if not (cv2.countNonZero(gone) or cv2.countNonZero(there)):
        return None
    dim_places = background.dim.mask(window)
    glare = cv2.subtract(now, cv2.convertScaleAbs(seen.empty[window], alpha=seen.gain))
    where = (gone > 0) & (dim_places | (now > ground + level)) & (glare < level)
    where |= (there > 0) & dim_places & ((ends == 0) | (signal < level))
    signal[(worm > 0) | (ends > 0)] = 0
    for debris in find_blobs(signal, level, window, settings.blobs):
        if debris.area > settings.largest_area_over_worm * seen.model.area:
            continue
        if not holds_wormlike_piece(draw_blob(debris, window), seen.model.width, settings.blobs):
            where |= (draw_blob(debris, window, 1) > 0) & (worm == 0) & (ends == 0)
    return np.asarray(where)


def _worm_in(
    window: Window, seen: Surroundings, settings: DebrisSettings
) -> tuple[Picture, Picture]:
    """Return where the worm is in a window, and where its ends may be."""
    worm, ends = np.zeros((2, *seen.arena[window].shape), np.uint8)
    width = seen.model.width
    line = np.rint(16 * (seen.body - window_origin(window))).astype(np.int32)
    thick = round(settings.drawn_width_over_known * width) + settings.drawn_rim_px
    cv2.polylines(worm, [line], False, 255, thick, cv2.LINE_8, 4)
    for end in (line[0], line[-1]):
        radius = round(16 * settings.untouched_about_ends_widths * width)
        cv2.circle(ends, end, radius, 255, -1, cv2.LINE_8, 4)
    # In a sharp bend a midline cuts the corner; and a body laid double is soon longer than it was.
    small = seen.blob.area < settings.all_worm_area_over_known * seen.model.area
    if small or seen.model.is_young:
        cv2.bitwise_or(worm, draw_blob(seen.blob, window, settings.worm_blur_px), dst=worm)
    return worm, ends
