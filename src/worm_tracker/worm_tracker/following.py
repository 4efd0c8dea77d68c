"""Follows one worm from picture to picture: where it is, and its midline."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import log

import cv2
import numpy as np

from worm_msgs_py.chamber import Geometry
from worm_msgs_py.status import Status
from worm_tracker.background import MAX_GAIN, MIN_GAIN, Background
from worm_tracker.body_fit import Fit, fit_body, overlap
from worm_tracker.identity import LEAP_LENGTHS, LEAP_WIDTHS
from worm_tracker.light import Picture, arena_of, empty_rig
from worm_tracker.outline import Floats, Rough, arc_length, as_complex, rough_midline
from worm_tracker.refinement import Fine, refine
from worm_tracker.segmentation import (
    Blob,
    Window,
    alike,
    draw_blob,
    find_blobs,
    first_threshold,
    moved,
    noise_of,
    pick,
    smoothed,
    whole,
    window_around,
)

THRESHOLD = 0.4
"""Of the signal on the midline: what counts as body when the object is cut out."""
MOST_STRETCH, MOST_STRETCH_A_FRAME = 0.15, 0.08
"""Log of the length over the known one, or over that of the frame before: both at once are an
error, because a worm does not stretch in a moment."""
LEAP_DOUBT = 0.5
"""What a leap leaves of the confidence."""
WAY_COST, STRETCH_COST = 0.3, 1.0
"""What moving an end by a length, and a unit of log stretch, take off a carried body's overlap."""
RELEARN_FRAMES, MORE = 15, 1.1
"""Frames in a row without a midline, and area over the known one, after which a slender outline of
another length is believed: the worm was seen in part at first."""
MIN_OVERLAP = 0.7
"""Least agreement of body and picture for a midline to be believed."""
SMALL, LARGE = 0.35, 2.2
"""Areas, relative to the worm's, that are not the worm."""
MARGIN_PX = 24
HIDE_PX = 5
"""How far around the worm its blur may darken the background."""


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """What one picture says of the worm, before anyone knows which end is the head.

    Attributes
    ----------
    status : Status
    u, v : float
        Centroid of the body's area; NaN where there is none.
    points, widths : ndarray
        Midline (POINTS, 2) and widths (POINTS,); empty where there is none.
    confidence : float
        How well the body explains the picture, 0 to 1.
    width : float
        Mean width over the middle four fifths; NaN where there is no midline.
    """

    status: Status
    u: float = float("nan")
    v: float = float("nan")
    points: Floats = field(default_factory=lambda: np.empty((0, 2)))
    widths: Floats = field(default_factory=lambda: np.empty(0))
    confidence: float = 0.0
    width: float = float("nan")


@dataclass(eq=False, slots=True)
class _Known:
    """What has been learned of this worm: running means over frames with a sound midline."""

    length: float
    width: float
    area: float
    level: float
    widths: Floats
    frames: int = 1

    def learn(self, fine: Fine, widths: Floats, area: float) -> None:
        self.frames += 1
        rate = max(1 / self.frames, 0.02)
        self.length += rate * (arc_length(fine.points)[-1] - self.length)
        self.width += rate * (mean_width(widths) - self.width)
        self.area += rate * (area - self.area)
        self.level += rate * (fine.level - self.level)
        self.widths = self.widths + rate * (widths - self.widths)


class Follower:
    """Follows the worm; one picture in, one `Observation` out.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture, dark worm on bright ground.
    geometry : Geometry
        The rig.
    """

    def __init__(self, picture: Picture, geometry: Geometry) -> None:
        ground, arena = empty_rig(picture, geometry)
        self._arena = arena.astype(np.uint8) * 255
        signal = cv2.subtract(np.rint(ground).astype(np.uint8), picture)
        signal = smoothed(np.asarray(cv2.bitwise_and(signal, self._arena), np.uint8))
        noise = noise_of((ground - picture).astype(np.int16)[arena])
        self._threshold = first_threshold(signal, noise)
        everything = whole(picture.shape)
        blobs = find_blobs(signal, self._threshold, everything)
        worm = draw_blob(blobs[0], everything, widen=6) if blobs else np.zeros_like(picture)
        self.background = Background(picture, ground, worm)
        self._noise = noise
        self._known: _Known | None = None
        self._blob: Blob | None = None
        self._last: Floats | None = None
        self._before: Floats | None = None
        self._lost = 0
        self._unresolved = 0

    @property
    def outline(self) -> Floats | None:
        """The worm's outline (u, v) in the last picture; None where it was not seen."""
        return None if self._blob is None else np.asarray(self._blob.contour, np.float64)

    def move(self, picture: Picture, geometry: Geometry, motion: Floats | None) -> None:
        """Take a new geometry, before the picture that it holds from is pushed.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        geometry : Geometry
        motion : ndarray, shape (2, 3), or None
            Affine map of old picture coordinates to new ones; None where nothing has moved.
        """
        arena = arena_of(picture, geometry)
        if motion is None:
            opened = arena & (self._arena == 0)
            self.background.renew(picture, self.background.gain(picture), opened)
        else:
            self.background.move(motion)
            self._last, self._before = (
                None if points is None else moved(points, motion)
                for points in (self._last, self._before)
            )
            self._blob = None if self._blob is None else self._blob.moved(motion)
        self._arena = arena.astype(np.uint8) * 255

    def push(self, picture: Picture) -> Observation:
        """Look at the next picture."""
        gain = self.background.gain(picture)
        if not MIN_GAIN <= gain <= MAX_GAIN:
            self._lost += 1
            return Observation(Status.BAD_IMAGE)
        window, signal, smooth, blob = self._find(picture, gain)
        if blob is None:
            self._lost += 1
            self._blob = None
            if self._known is None:
                self._rethink(signal)
            found = Observation(Status.AMBIGUOUS if self._rivals else Status.NO_WORM)
        else:
            found = self._observe(signal, smooth, window, blob)
            self._blob, self._lost = blob, 0
        resolved = len(found.points) > 0
        self._before, self._last = self._last, found.points if resolved else None
        self._unresolved = 0 if resolved or blob is None else self._unresolved + 1
        self.background.learn(picture, gain, self._hide(picture, gain))
        return found

    def _find(self, picture: Picture, gain: float) -> tuple[Window, Picture, Picture, Blob | None]:
        """Return window, signal, smoothed signal and object; all of the picture if need be."""
        everything = whole(picture.shape)
        windows = [everything]
        if self._blob is not None:
            windows.insert(0, window_around(self._blob.box, MARGIN_PX, picture.shape))
        for window in windows:
            signal = self.background.signal(picture, gain, window)
            cv2.bitwise_and(signal, self._arena[window], dst=signal)
            smooth = smoothed(signal)
            blob = self._pick(find_blobs(smooth, self._threshold, window))
            cut = blob is not None and blob.touches(window) and not blob.touches(everything)
            if blob is not None and not (cut and window is not everything):
                return window, signal, smooth, blob
        return window, signal, smooth, None

    def _pick(self, blobs: list[Blob]) -> Blob | None:
        """Return the object that is the worm, if any can be."""
        if self._known is not None:
            blobs = [blob for blob in blobs if blob.area > 0.1 * self._known.area]
        area = self._known.area if self._known else 0.0
        # With nothing to go by but the size, two of the worm's size could each be the worm.
        self._rivals = self._blob is None and alike(blobs, area)
        if self._rivals:
            return None
        if self._blob is None:
            return pick(blobs, area, 0.0, 0.0, 0.0)
        u0, v0, u1, v1 = self._blob.box
        reach = max(float(u1 - u0), float(v1 - v0), 20.0)
        return pick(blobs, area, self._blob.u, self._blob.v, reach)

    def _rethink(self, signal: Picture) -> None:
        """Choose the threshold anew while no worm has been seen yet."""
        self._threshold = first_threshold(signal, self._noise)

    def _observe(self, signal: Picture, smooth: Picture, window: Window, blob: Blob) -> Observation:
        """Find the midline of the object, or say why there is none."""
        height, width = self.background.picture.shape
        if blob.touches((slice(0, height), slice(0, width))):
            return Observation(Status.TOUCHES_BORDER, blob.u, blob.v)
        known = self._known
        if known is not None and blob.area < SMALL * known.area:
            return Observation(Status.TOO_SMALL, blob.u, blob.v)
        if known is not None and blob.area > LARGE * known.area:
            return Observation(Status.TOO_LARGE, blob.u, blob.v)
        expected = known.width if known else _thickness(blob, window)
        rough = rough_midline(blob.contour, expected, self._last)
        if rough is None or not self._sound(rough, blob, expected):
            return self._carry(signal, smooth, window, blob, None)
        offset = (window[1].start, window[0].start)
        fine = refine(signal, offset, rough.points, known.width if known else rough.width)
        confidence = _agreement(fine, blob)
        if confidence < MIN_OVERLAP:
            return self._carry(signal, smooth, window, blob, None)
        if self._continues(fine):
            self._learn(fine, blob)
            return _seen(fine, confidence)
        return self._carry(signal, smooth, window, blob, fine)

    def _continues(self, fine: Fine) -> bool:
        """Tell whether a midline can be that of the frame before, a frame later."""
        known, last = self._known, self._last
        if known is None or last is None:
            return True
        length = _length(fine)
        odd = abs(log(length / known.length)) > MOST_STRETCH
        changed = abs(log(length / arc_length(last)[-1])) > MOST_STRETCH_A_FRAME
        return not (odd and changed) and not self._leaps(fine.points)

    def _leaps(self, points: Floats) -> bool:
        """Tell whether an end is farther from where it was than an end can have got."""
        if self._last is None or self._known is None:
            return False
        far = max(LEAP_WIDTHS * self._known.width, LEAP_LENGTHS * self._known.length)
        return end_displacement(points, self._last) > far * (1 + self._lost)

    def _sound(self, rough: Rough, blob: Blob, width: float) -> bool:
        """Tell whether an outline is that of a body that does not touch itself."""
        length = float(arc_length(rough.points)[-1])
        if blob.hole_area > 0.15 * width**2 or rough.unequal > 0.3:
            return False
        if self._known is None:
            off = abs(float(np.log(length * rough.width / blob.area)))
            return length > 2.5 * rough.width and off < 0.35
        if rough.width > 1.35 * width:
            return False
        if self._was_in_part(blob):
            return length > 2.5 * rough.width
        return 0.75 < length / self._known.length < 1.35

    def _was_in_part(self, blob: Blob) -> bool:
        """Tell whether the worm has long been too large for what was seen of it at first."""
        known = self._known
        larger = known is not None and blob.area > MORE * known.area
        return larger and self._unresolved >= RELEARN_FRAMES

    def _learn(self, fine: Fine, blob: Blob) -> None:
        """Take a sound midline into what is known of the worm."""
        if self._known is None or self._was_in_part(blob):
            width = mean_width(fine.widths)
            length = float(arc_length(fine.points)[-1])
            self._known = _Known(length, width, blob.area, fine.level, fine.widths)
        else:
            flip = self._last is not None and _nearer_turned(fine.points, self._last)
            widths = fine.widths[::-1] if flip else fine.widths
            self._known.learn(fine, widths, blob.area)
        self._threshold = max(THRESHOLD * self._known.level, 4 * self._noise)

    def _carry(
        self, signal: Picture, smooth: Picture, window: Window, blob: Blob, fine: Fine | None
    ) -> Observation:
        """Carry the last midline on as a deformable body, where the body touches itself.

        Where the outline has given a midline, `fine`, that cannot continue the last one, the better
        of both is taken; a leap that remains is said by a low confidence.
        """
        known, last = self._known, self._last
        if known is None or last is None:
            return Observation(Status.COILED, blob.u, blob.v)
        offset = np.array([window[1].start, window[0].start], np.float64)
        _, above = cv2.threshold(smooth, self._threshold, 255, cv2.THRESH_BINARY)
        mask = np.asarray(cv2.bitwise_and(draw_blob(blob, window), above), np.uint8)
        starts = [last - offset]
        if self._before is not None:
            before = self._before
            if _nearer_turned(before, last):
                before = before[::-1]
            starts.append(2 * last - before - offset)
        fits = [fit_body(mask, start, known.widths, known.length) for start in starts]
        best = max(fits, key=lambda fit: self._merit(fit, offset))
        sharp = refine(signal, (0, 0), best.points, known.width)
        sharper = overlap(mask, sharp.points, sharp.widths)
        if (
            sharper >= best.overlap - 0.02
            and abs(log(_length(sharp) / known.length)) < MOST_STRETCH
            and not self._leaps(sharp.points + offset)
        ):
            best = Fit(sharp.points, sharper)
        if fine is not None:
            open_body = Fit(fine.points - offset, overlap(mask, fine.points - offset, fine.widths))
            if self._merit(open_body, offset) > self._merit(best, offset):
                best = open_body
        if best.overlap < MIN_OVERLAP:
            return Observation(Status.COILED, blob.u, blob.v)
        points = best.points + offset
        doubt = LEAP_DOUBT if self._leaps(points) else 1.0
        return _carried(points, known.widths, doubt * best.overlap)

    def _merit(self, fit: Fit, offset: Floats) -> float:
        """Return how good a body is: its overlap, less what its ends' way and length cost."""
        known, last = self._known, self._last
        if known is None or last is None:
            return fit.overlap
        points = fit.points + offset
        way = end_displacement(points, last) / known.length / (1 + self._lost)
        stretch = abs(log(float(arc_length(points)[-1]) / known.length))
        return fit.overlap - WAY_COST * way - STRETCH_COST * max(stretch - 0.05, 0.0)

    def _hide(self, picture: Picture, gain: float) -> Callable[[Window], Picture | None]:
        """Return the function that masks the worm for the background."""
        blob = self._blob
        if blob is not None:
            return lambda window: (
                draw_blob(blob, window, HIDE_PX) if blob.near(window, HIDE_PX) else None
            )

        def dark(window: Window) -> Picture:
            signal = self.background.signal(picture, gain, window)
            level = max(0.5 * min(self._threshold, 255.0), 3 * self._noise)
            return np.asarray(signal > level, np.uint8)

        return dark


def end_displacement(points: Floats, last: Floats) -> float:
    """Return how far the end that moved more has moved, the ends paired the likelier way."""
    ends, before = as_complex(points[[0, -1]]), as_complex(last[[0, -1]])
    straight, turned = np.abs(ends - before), np.abs(ends[::-1] - before)
    return float(min(straight.max(), turned.max()))


def _seen(fine: Fine, confidence: float) -> Observation:
    """Return the observation of a refined midline."""
    return Observation(
        Status.TRACKED,
        fine.u,
        fine.v,
        fine.points,
        fine.widths,
        confidence,
        mean_width(fine.widths),
    )


def _length(fine: Fine) -> float:
    return float(arc_length(fine.points)[-1])


def mean_width(widths: Floats) -> float:
    """Return the mean over the middle four fifths of the body."""
    cut = len(widths) // 10
    return float(widths[cut : len(widths) - cut].mean())


def _carried(points: Floats, widths: Floats, confidence: float) -> Observation:
    """Return the observation of a carried midline; the centroid is that of the body's area."""
    steps = np.gradient(arc_length(points)) * widths
    u, v = (points * steps[:, None]).sum(0) / steps.sum()
    return Observation(
        Status.TRACKED,
        float(u),
        float(v),
        points,
        widths,
        float(confidence),
        mean_width(widths),
    )


def _agreement(fine: Fine, blob: Blob) -> float:
    """Return how well a refined body explains the object: areas and edges found."""
    return min(fine.area, blob.area) / max(fine.area, blob.area) * fine.seen


def _thickness(blob: Blob, window: Window) -> float:
    """Return a first guess of the body's width, from the distance to the outline."""
    inside = cv2.distanceTransform(draw_blob(blob, window), cv2.DIST_L2, 5)
    return max(2 * float(inside.max()) - 1, 3.0)


def _nearer_turned(points: Floats, last: Floats) -> bool:
    """Tell whether a midline lies nearer to another one when it is turned round."""
    straight = np.abs(points - last).sum()
    return bool(np.abs(points[::-1] - last).sum() < straight)
