"""Finds the worm in the picture: the one dark object that continues the one seen before."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.chamber import Geometry
from worm_tracker.body_model import Known
from worm_tracker.detection.background import MAX_GAIN, MIN_GAIN, Background
from worm_tracker.detection.blobs import (
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
    thickness,
    whole,
    window_around,
)
from worm_tracker.detection.glare import any_white, near, seen_through, white_from
from worm_tracker.detection.illumination import WALL_REACH_PX, Picture, arena_of, empty_rig
from worm_tracker.detection.occlusion import Joined, join, paint
from worm_tracker.midline.contour_midline import Floats

THRESHOLD = 0.4
"""Of the signal on the midline: what counts as body when the object is cut out."""
LEAST_AREA = 0.1
"""Objects smaller than this part of the worm's area are none."""
MARGIN_PX = 24
OVERGROWN = 1.04
"""Area over the known one from which an object is looked at for what hangs on to it."""
SETTLE, SETTLE_FRAMES, LARGEST = 0.5, 12, 0.5
"""Change of the background that is taken at once, over the threshold; how often it is looked for
where nothing is seen; the largest object that is taken for dirt, over the worm's area."""
SETTLE_AROUND = 6.0
"""How far around the worm that is done, in widths."""
SLIGHT = 3.5
"""Change, over the noise, that is taken at once where there is dirt in the background already."""
HANGS_ON = 1.1
"""Area over the known one below which all of the object is the worm."""
NEAR_END = 2.0
"""How far around its ends nothing is taken for dirt, in widths."""
ENTIRE = 0.95
"""Area over the known one below which a part of the worm may have been cut off."""
BEYOND = 6.0
"""How far around the worm it is looked for where there is glare, in widths."""
HIDE_PX = 5
"""How far around the worm its blur may darken the background."""


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """The worm's surroundings in one picture.

    Attributes
    ----------
    window : Window
        Where in the picture the rest lies.
    signal, smooth : ndarray of uint8
        Background minus picture in the window, as it is and without the noise of single pixels.
    blob : Blob
        The object that is the worm.
    threshold : float
        Of `smooth`: what lies above is object.
    joined : Joined or None
        Where a part of the worm is hidden: how the rest was put together, in the window's
        coordinates. What is hidden is drawn into `signal` as it is supposed to be.
    zone : ndarray of uint8, or None
        Not zero where glare leaves the body's width untold; None where there is none near it.
    """

    window: Window
    signal: Picture
    smooth: Picture
    blob: Blob
    threshold: float
    joined: Joined | None = None
    zone: Picture | None = None


class Finder:
    """Finds the worm from picture to picture, and keeps the background that it is told by.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture, dark worm on bright ground.
    geometry : Geometry
        The rig.

    Attributes
    ----------
    blob : Blob or None
        The worm in the last picture.
    rivals : bool
        Whether there were several objects that could each have been the worm.
    """

    def __init__(self, picture: Picture, geometry: Geometry) -> None:
        ground, arena = empty_rig(picture, geometry)
        self._arena = arena.astype(np.uint8) * 255
        signal = cv2.subtract(np.rint(ground).astype(np.uint8), picture)
        signal = smoothed(np.asarray(cv2.bitwise_and(signal, self._arena), np.uint8))
        self._noise = noise_of((ground - picture).astype(np.int16)[arena])
        self._threshold = first_threshold(signal, self._noise)
        self._area = 0.0
        everything = whole(picture.shape)
        blobs = find_blobs(signal, self._threshold, everything)
        worm = draw_blob(blobs[0], everything, widen=6) if blobs else np.zeros_like(picture)
        white = cv2.compare(picture, white_from(np.rint(ground).astype(np.uint8)), cv2.CMP_GT)
        if white.any():  # what is near glare may be another part of the worm
            around = np.ones((2 * MARGIN_PX + 1, 2 * MARGIN_PX + 1), np.uint8)
            near_white = cv2.dilate(white, around)
            for blob in blobs[1:]:
                piece = draw_blob(blob, everything, widen=6)
                if cv2.bitwise_and(piece, near_white).any():
                    worm |= piece
        self._background = Background(picture, ground, worm, _water(arena, geometry))
        self.blob: Blob | None = None
        self.body: Floats | None = None
        self.width = 0.0
        self._length = 0.0
        self._frames = 0
        self._crowded = False
        self._veiled = False
        self._plain = np.rint(ground).astype(np.uint8)
        self.rivals = False

    def expect(self, known: Known) -> None:
        """Take what is known of the worm."""
        self._area, self._length, self.width = known.area, known.length, known.width
        self._threshold = max(THRESHOLD * known.level, 4 * self._noise)

    def move(self, picture: Picture, geometry: Geometry, motion: Floats | None) -> None:
        """Take a new geometry; see `Follower.move`."""
        arena = arena_of(picture, geometry)
        if motion is None:
            opened = arena & (self._arena == 0)
            self._background.renew(picture, self._background.gain(picture), opened)
        else:
            self._background.move(motion)
            size = self._plain.shape[::-1]
            self._plain = np.asarray(cv2.warpAffine(self._plain, motion, size), np.uint8)
            self.body = None if self.body is None else moved(self.body, motion)
            self.blob = None if self.blob is None else self.blob.moved(motion)
        self._arena = arena.astype(np.uint8) * 255

    def gain(self, picture: Picture) -> float | None:
        """Return how bright a picture is, relative to the background; None where it is no view."""
        gain = self._background.gain(picture)
        return gain if MIN_GAIN <= gain <= MAX_GAIN else None

    def find(self, picture: Picture, gain: float) -> Sight | None:
        """Find the worm, near where it was, else in all of the picture."""
        everything = whole(picture.shape)
        sight = self._find_parts(picture, gain)
        self._veiled = sight is not None and sight.joined is not None
        if sight is not None:
            self.blob = sight.blob
            return sight
        windows = [everything]
        if self.blob is not None:
            windows.insert(0, window_around(self.blob.box, MARGIN_PX, picture.shape))
        for window in windows:
            signal = self._background.signal(picture, gain, window)
            cv2.bitwise_and(signal, self._arena[window], dst=signal)
            smooth = smoothed(signal)
            blobs = find_blobs(smooth, self._threshold, window)
            blob = self._pick(blobs)
            cut = blob is not None and blob.touches(window) and not blob.touches(everything)
            if blob is not None and not (cut and window is not everything):
                self.blob = blob
                self._crowded = len(blobs) > 1 or blob.area > OVERGROWN * self._area
                sight = Sight(window, signal, smooth, blob, self._threshold)
                return self._with_cut_off(sight, len(blobs))
        self.blob = self.body = None
        if not self._area:  # no worm has been seen yet: the threshold may be wrong
            self._threshold = first_threshold(signal, self._noise)
        return None

    def _find_parts(self, picture: Picture, gain: float) -> Sight | None:
        """Find a worm that glare may hide a part of; None where there is none near it."""
        window, body = whole(picture.shape), self.body
        if not np.isfinite(self._threshold):
            return None
        if body is not None and self.blob is not None:
            around = round(BEYOND * self.width)
            window = window_around(self.blob.box, around, picture.shape)
        now, limit = picture[window], self._background.limit[window]
        if not any_white(now, limit):
            return None
        ground = self._background.scaled(gain, window)
        width = self.width or self._width(picture, gain)
        through = seen_through(now, limit, ground, self._arena[window], width, self._threshold)
        offset = np.array([window[1].start, window[0].start])
        if body is not None:
            body = body - offset
            if not near(through.zone, body, 2 * width):
                return None
        blobs = find_blobs(through.smooth, self._threshold, whole(now.shape))
        level = self._threshold / THRESHOLD
        joined = join(blobs, through.signal, through.zone, width, self._length, level, body)
        if joined is not None:
            return self._put_together(
                window, through.signal, through.smooth, through.zone, joined, width
            )
        blob = self._pick(find_blobs(through.smooth, self._threshold, window))
        if blob is None:
            return None
        return Sight(
            window, through.signal, through.smooth, blob, self._threshold, None, through.zone
        )

    def _with_cut_off(self, sight: Sight, objects: int) -> Sight:
        """Return a sight with what is cut off by dirt in the background that has moved on."""
        window = sight.window
        small = objects > 1 and sight.blob.area < ENTIRE * self._area
        if self.body is None or not small or not self._background.dim_in(window):
            return sight
        zone = self._background.cluttered(window).astype(np.uint8)
        blobs = find_blobs(sight.smooth, self._threshold, whole(sight.smooth.shape))
        body = self.body - np.array([window[1].start, window[0].start])
        level = self._threshold / THRESHOLD
        joined = join(blobs, sight.signal, zone, self.width, self._length, level, body)
        if joined is None or any(joined.hidden):
            return sight
        found = self._put_together(window, sight.signal, sight.smooth, zone, joined, self.width)
        if found is None or found.blob.area < sight.blob.area:
            return sight
        self.blob, self._veiled = found.blob, True
        return found

    def _put_together(
        self,
        window: Window,
        signal: Picture,
        smooth: Picture,
        zone: Picture,
        joined: Joined,
        width: float,
    ) -> Sight | None:
        """Return the sight of a worm whose pieces were joined, what is hidden drawn in."""
        level = self._threshold / THRESHOLD
        signal = paint(signal, joined.bridges, width, level)
        smooth = paint(smooth, joined.bridges, width, level)
        for piece in joined.pieces:  # one object, also where it fades
            smooth = paint(smooth, [piece], 1, level)
        blobs = find_blobs(smooth, self._threshold, window)
        if not blobs:
            return None
        middle = joined.pieces[0][len(joined.pieces[0]) // 2]
        u, v = float(middle[0] + window[1].start), float(middle[1] + window[0].start)
        inside = [cv2.pointPolygonTest(b.contour[:, None], (u, v), True) for b in blobs]
        blob = blobs[int(np.argmax(inside))]
        return Sight(window, signal, smooth, blob, self._threshold, joined, zone)

    def _width(self, picture: Picture, gain: float) -> float:
        """Return a first guess of the worm's width: the thickness of the largest object."""
        everything = whole(picture.shape)
        signal = self._background.signal(picture, gain, everything)
        cv2.bitwise_and(signal, self._arena, dst=signal)
        blobs = find_blobs(smoothed(signal), self._threshold, everything)
        if not blobs:
            return 3.0
        return thickness(draw_blob(blobs[0], everything))

    def learn(self, picture: Picture, gain: float, body: Floats, entire: bool) -> None:
        """Let the background follow the picture where the worm is not.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
        body : ndarray, shape (n, 2)
            The midline; empty where it was not resolved.
        entire : bool
            Whether it is that of all of the worm: what is elsewhere is something else.
        """
        if not self._veiled:  # else not all of the worm may be known
            self._background.learn(picture, gain, self._hide(picture, gain))
        if len(body):
            self.body = body
        if entire and self.blob is not None:
            self._frames += 1
            near = window_around(self.blob.box, MARGIN_PX, picture.shape)
            often = self._crowded or self._background.dim_in(near)
            if often or self._frames % SETTLE_FRAMES == 0:
                self._settle(picture, gain, body, self.blob)

    def _settle(self, picture: Picture, gain: float, body: Floats, blob: Blob) -> None:
        """Take what came, or left, beside the worm for background at once.

        The worm only makes things darker: where a picture is brighter than the background, dirt or
        a bubble has left. What is darker away from all of the worm is none of it, unless it is
        large enough to be another one.
        """
        around = max(MARGIN_PX, round(SETTLE_AROUND * self.width))
        window = window_around(blob.box, around, picture.shape)
        level, slight = SETTLE * self._threshold, SLIGHT * self._noise
        now, ground = picture[window], self._background.scaled(gain, window)
        dim = self._background.dim_in(window)
        signal = self._background.signal(picture, gain, window)
        cv2.bitwise_and(signal, self._arena[window], dst=signal)
        signal = smoothed(signal)
        worm, ends = self._body_in(body, window)
        if blob.area < HANGS_ON * self._area:  # in a sharp bend a midline cuts the corner
            cv2.bitwise_or(worm, draw_blob(blob, window, HIDE_PX), dst=worm)
        least = slight if dim else level
        _, gone = cv2.threshold(cv2.subtract(now, ground), least, 255, cv2.THRESH_BINARY)
        _, there = cv2.threshold(signal, least, 255, cv2.THRESH_BINARY)
        cv2.bitwise_and(there, cv2.bitwise_not(worm), dst=there)
        if not (cv2.countNonZero(gone) or cv2.countNonZero(there)):
            return
        cluttered = self._background.cluttered(window)
        glare = cv2.subtract(now, cv2.convertScaleAbs(self._plain[window], alpha=gain))
        where = (gone > 0) & (cluttered | (now > ground + level)) & (glare < level)
        where |= (there > 0) & cluttered & ((ends == 0) | (signal < level))
        signal[(worm > 0) | (ends > 0)] = 0
        for dirt in find_blobs(signal, level, window):
            if dirt.area < LARGEST * self._area:
                where |= (draw_blob(dirt, window, 1) > 0) & (worm == 0) & (ends == 0)
        if where.any():
            self._background.take(picture, gain, window, where)

    def _body_in(self, body: Floats, window: Window) -> tuple[Picture, Picture]:
        """Return where the worm is in a window, and where its ends may be."""
        worm, ends = np.zeros((2, *self._arena[window].shape), np.uint8)
        line = np.rint(16 * (body - (window[1].start, window[0].start))).astype(np.int32)
        thick = round(1.25 * self.width) + 2 * 2
        cv2.polylines(worm, [line], False, 255, thick, cv2.LINE_8, 4)
        for end in (line[0], line[-1]):
            cv2.circle(ends, end, round(16 * NEAR_END * self.width), 255, -1, cv2.LINE_8, 4)
        return worm, ends

    def _pick(self, blobs: list[Blob]) -> Blob | None:
        """Return the object that is the worm, if any can be."""
        blobs = [blob for blob in blobs if blob.area > LEAST_AREA * self._area]
        # With nothing to go by but the size, two of the worm's size could each be the worm.
        self.rivals = self.blob is None and alike(blobs, self._area)
        if self.rivals:
            return None
        if self.blob is None:
            return pick(blobs, self._area, 0.0, 0.0, 0.0)
        u0, v0, u1, v1 = self.blob.box
        reach = max(float(u1 - u0), float(v1 - v0), 20.0)
        return pick(blobs, self._area, self.blob.u, self.blob.v, reach)

    def _hide(self, picture: Picture, gain: float) -> Callable[[Window], Picture | None]:
        """Return the function that masks the worm for the background."""
        blob = self.blob
        if blob is not None:
            return lambda window: (
                draw_blob(blob, window, HIDE_PX) if blob.near(window, HIDE_PX) else None
            )

        def dark(window: Window) -> Picture:
            signal = self._background.signal(picture, gain, window)
            level = max(0.5 * min(self._threshold, 255.0), 3 * self._noise)
            return np.asarray(signal > level, np.uint8)

        return dark


def _water(arena: NDArray[np.bool_], geometry: Geometry) -> NDArray[np.bool_]:
    """Return where clear water is sure to be bright: away from the walls of the rig."""
    if not geometry.chambers:
        return np.zeros_like(arena)
    size = 2 * (WALL_REACH_PX + 3) + 1
    return cv2.erode(arena.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
