"""Finds the worm in the picture: the one dark object that continues the one seen before."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.chamber import Geometry
from worm_tracker.background import MAX_GAIN, MIN_GAIN, Background
from worm_tracker.light import Picture, arena_of, empty_rig
from worm_tracker.outline import Floats
from worm_tracker.segmentation import (
    Blob,
    Window,
    alike,
    draw_blob,
    find_blobs,
    first_threshold,
    noise_of,
    pick,
    smoothed,
    whole,
    window_around,
)

THRESHOLD = 0.4
"""Of the signal on the midline: what counts as body when the object is cut out."""
LEAST_AREA = 0.1
"""Objects smaller than this part of the worm's area are none."""
MARGIN_PX = 24
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
    """

    window: Window
    signal: Picture
    smooth: Picture
    blob: Blob
    threshold: float


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
        self._background = Background(picture, ground, worm)
        self.blob: Blob | None = None
        self.rivals = False

    def expect(self, area: float, level: float) -> None:
        """Take what the worm's area and its signal's level are known to be."""
        self._area = area
        self._threshold = max(THRESHOLD * level, 4 * self._noise)

    def move(self, picture: Picture, geometry: Geometry, motion: Floats | None) -> None:
        """Take a new geometry; see `Follower.move`."""
        arena = arena_of(picture, geometry)
        if motion is None:
            opened = arena & (self._arena == 0)
            self._background.renew(picture, self._background.gain(picture), opened)
        else:
            self._background.move(motion)
            self.blob = None if self.blob is None else self.blob.moved(motion)
        self._arena = arena.astype(np.uint8) * 255

    def gain(self, picture: Picture) -> float | None:
        """Return how bright a picture is, relative to the background; None where it is no view."""
        gain = self._background.gain(picture)
        return gain if MIN_GAIN <= gain <= MAX_GAIN else None

    def find(self, picture: Picture, gain: float) -> Sight | None:
        """Find the worm, near where it was, else in all of the picture."""
        everything = whole(picture.shape)
        windows = [everything]
        if self.blob is not None:
            windows.insert(0, window_around(self.blob.box, MARGIN_PX, picture.shape))
        for window in windows:
            signal = self._background.signal(picture, gain, window)
            cv2.bitwise_and(signal, self._arena[window], dst=signal)
            smooth = smoothed(signal)
            blob = self._pick(find_blobs(smooth, self._threshold, window))
            cut = blob is not None and blob.touches(window) and not blob.touches(everything)
            if blob is not None and not (cut and window is not everything):
                self.blob = blob
                return Sight(window, signal, smooth, blob, self._threshold)
        self.blob = None
        if not self._area:  # no worm has been seen yet: the threshold may be wrong
            self._threshold = first_threshold(signal, self._noise)
        return None

    def learn(self, picture: Picture, gain: float) -> None:
        """Let the background follow the picture where the worm is not."""
        self._background.learn(picture, gain, self._hide(picture, gain))

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
