"""The picture without the worm, kept up to date without ever absorbing the worm."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.light import Floats, Picture

Window = tuple[slice, slice]

MEMORY_FRAMES = 256
"""Frames after which an old background has mostly been forgotten."""
EAGER_FRAMES = 12
"""First frames, in which all of the picture is averaged at once."""
BAND_PIXELS = 16384
"""Pixels that are refreshed per frame thereafter: a band of rows that goes round and round."""
GAIN_STRIDE = 16
GAIN_SAMPLES = 1000
"""Pixels whose median gives the light's change: good to a thousandth."""
MIN_GAIN, MAX_GAIN = 0.5, 2.0


class Background:
    """A running mean of every pixel over the frames in which the worm was elsewhere.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture.
    ground : ndarray of float32, shape (h, w)
        What it would show without a worm (`light.empty_rig`).
    worm : ndarray of uint8, shape (h, w)
        Non-zero where the worm, widened by its blur, hides the background of the first picture.
    """

    def __init__(self, picture: Picture, ground: Floats, worm: Picture) -> None:
        hidden = worm > 0
        self._mean = np.where(hidden, ground, picture).astype(np.float32)
        self._count = np.where(hidden, 0, 1).astype(np.float32)
        self.picture = np.rint(self._mean).astype(np.uint8)
        height, width = picture.shape
        self._rows = int(np.clip(BAND_PIXELS // width, 1, height))
        self._next = 0
        self._frames = 0
        self._visits = MEMORY_FRAMES * self._rows / height
        sample = np.zeros(picture.shape, bool)
        stride = max(1, min(GAIN_STRIDE, min(picture.shape) // 16))
        sample[::stride, ::stride] = True
        level = np.quantile(self._mean[sample], 0.9)
        self._sample = np.flatnonzero(sample & (self._mean > 0.5 * level))
        self._sample = self._sample[:: max(1, len(self._sample) // GAIN_SAMPLES)]

    def gain(self, picture: Picture) -> float:
        """Return the picture's brightness over the background's (flicker), by the median."""
        now = picture.reshape(-1)[self._sample]
        ratio = now / np.maximum(self._mean.reshape(-1)[self._sample], 1.0)
        ratio.sort()
        return float(ratio[len(ratio) // 2])

    def signal(self, picture: Picture, gain: float, window: Window) -> NDArray[np.uint8]:
        """Return how much darker than the background a window of the picture is."""
        ground = self.picture[window]
        if abs(gain - 1) > 0.002:
            ground = np.asarray(cv2.convertScaleAbs(ground, alpha=gain), np.uint8)
        return np.asarray(cv2.subtract(ground, picture[window]), np.uint8)

    def learn(self, picture: Picture, gain: float, hide: Callable[[Window], Picture]) -> None:
        """Average a picture in, apart from where the worm is.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
            The picture's, see `gain`.
        hide : callable
            Returns, for a window, a mask that is not zero where the worm hides the background.
        """
        height = picture.shape[0]
        if self._frames < EAGER_FRAMES:
            first, last = 0, height
        else:
            first = self._next
            last = min(first + self._rows, height)
            self._next = 0 if last == height else last
        self._frames += 1
        free = hide((slice(first, last), slice(0, picture.shape[1]))) == 0
        count = self._count[first:last]
        np.add(count, 1, out=count, where=free)
        np.minimum(count, max(self._visits, EAGER_FRAMES), out=count)
        mean = self._mean[first:last]
        change = picture[first:last] * np.float32(1 / gain)
        change -= mean
        change /= np.maximum(count, 1)
        change *= free
        mean += change
        self.picture[first:last] = cv2.convertScaleAbs(mean)
