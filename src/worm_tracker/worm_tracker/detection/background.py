"""The picture without the worm, kept up to date without ever absorbing the worm."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.detection.blobs import Window, whole
from worm_tracker.detection.glare import any_white, white_from
from worm_tracker.detection.illumination import Floats, Picture

MEMORY_FRAMES = 256
"""Frames after which an old background has mostly been forgotten."""
EAGER_FRAMES = 12
"""First frames, in which all of the picture is averaged at once."""
BAND_PIXELS = 16384
"""Pixels that are refreshed per frame thereafter: a band of rows that goes round and round."""
GAIN_STRIDE = 16
GAIN_SAMPLES = 1000
"""Pixels whose median gives the light's change: good to a thousandth."""
SAMPLE_FRAMES = 16
"""Frames between two readings of the background for the gain."""
MIN_GAIN, MAX_GAIN = 0.5, 2.0
DIM, MOST_WEIGHT = 0.6, 3.5
"""Part of clear water's light below which the signal is weighed, and its most weight: where there
is less light left the picture cannot tell."""
WEIGHT_ONE = 64
BLOCK_PX = 16


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
    water : ndarray of bool, shape (h, w)
        Where clear water lets all light through.
    """

    def __init__(
        self, picture: Picture, ground: Floats, worm: Picture, water: NDArray[np.bool_]
    ) -> None:
        self.limit = white_from(np.rint(ground).astype(np.uint8))
        hidden = (worm > 0) | (picture > self.limit)
        self._mean = np.where(hidden, ground, picture).astype(np.float32)
        self._count = np.where(hidden, 0, 1).astype(np.float32)
        self.picture = np.rint(self._mean).astype(np.uint8)
        self._clear = np.where(water, ground, 0).astype(np.float32)
        self._dim = np.rint(DIM * self._clear).astype(np.uint8)
        self._weight = np.full(picture.shape, WEIGHT_ONE, np.uint8)
        self._weighted = np.zeros(-(-np.array(picture.shape) // BLOCK_PX), bool)
        self._weigh(whole(picture.shape))
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
        self._ground = np.ones(0, np.float32)

    def gain(self, picture: Picture) -> float:
        """Return the picture's brightness over the background's (flicker), by the median."""
        ratio = picture.reshape(-1).take(self._sample) / self._sampled()
        middle = len(ratio) // 2
        ratio.partition(middle)
        return float(ratio[middle])

    def _sampled(self) -> Floats:
        """Return the background at the samples; it changes too slowly to be read each time."""
        if self._frames <= EAGER_FRAMES or self._frames % SAMPLE_FRAMES == 0:
            self._ground = np.maximum(self._mean.reshape(-1).take(self._sample), 1.0)
        return self._ground

    def signal(self, picture: Picture, gain: float, window: Window) -> NDArray[np.uint8]:
        """Return how much darker than the background a window of the picture is."""
        signal = np.asarray(cv2.subtract(self.scaled(gain, window), picture[window]), np.uint8)
        if self.dim_in(window):
            cv2.multiply(signal, self._weight[window], dst=signal, scale=1 / WEIGHT_ONE)
        return signal

    def dim_in(self, window: Window) -> bool:
        """Tell whether anything in a window lets through much less light than clear water."""
        return bool(self._weighted[_blocks(window)].any())

    def cluttered(self, window: Window) -> NDArray[np.bool_]:
        """Return where in a window, or just beside, less light comes through than clear water."""
        dim = np.asarray(self._weight[window] != WEIGHT_ONE, np.uint8)
        return cv2.dilate(dim, np.ones((9, 9), np.uint8)) > 0

    def _weigh(self, window: Window) -> None:
        """Note where the background is dim: what passes there takes away less light.

        Weighed by the light that clear water would let through, over what the background does, it
        takes away the same part of it everywhere.
        """
        ground, blocks = self.picture[window], _blocks(window)
        dim = cv2.compare(ground, self._dim[window], cv2.CMP_LT)
        if not (cv2.countNonZero(dim) or self._weighted[blocks].any()):
            return
        parts = self._clear[window] / np.maximum(ground, 1)
        weight = WEIGHT_ONE * np.minimum(parts, MOST_WEIGHT) + 0.5
        self._weight[window] = np.where(dim > 0, weight, WEIGHT_ONE)
        rows, columns = (slice(part.start * BLOCK_PX, part.stop * BLOCK_PX) for part in blocks)
        v, u = np.nonzero(self._weight[rows, columns] != WEIGHT_ONE)
        self._weighted[blocks] = False
        self._weighted[(v + rows.start) // BLOCK_PX, (u + columns.start) // BLOCK_PX] = True

    def scaled(self, gain: float, window: Window) -> Picture:
        """Return a window of the background as bright as a picture of this gain."""
        ground = self.picture[window]
        if abs(gain - 1) > 0.002:
            ground = np.asarray(cv2.convertScaleAbs(ground, alpha=gain), np.uint8)
        return ground

    def move(self, motion: NDArray[np.float64]) -> None:
        """Take the background along with a rig that has moved in the picture.

        Parameters
        ----------
        motion : ndarray, shape (2, 3)
            Affine map of old (u, v) to new ones. What comes into view is told by the edge.
        """
        size = self.picture.shape[::-1]
        replicate = cv2.BORDER_REPLICATE
        # Cubic: a softer wall would leave a rim that touches a worm at the wall.
        mean = cv2.warpAffine(self._mean, motion, size, flags=cv2.INTER_CUBIC, borderMode=replicate)
        count = cv2.warpAffine(
            self._count, motion, size, flags=cv2.INTER_NEAREST, borderMode=replicate
        )
        self._mean = np.clip(mean, 0, 255).astype(np.float32)
        self._count = np.minimum(count, EAGER_FRAMES).astype(np.float32)
        self._frames = 0
        self.picture = np.asarray(cv2.convertScaleAbs(self._mean), np.uint8)
        self.limit = np.asarray(
            cv2.warpAffine(self.limit, motion, size, flags=cv2.INTER_NEAREST, borderValue=255),
            np.uint8,
        )
        clear = cv2.warpAffine(self._clear, motion, size, flags=cv2.INTER_NEAREST)
        self._clear = np.asarray(clear, np.float32)
        self._dim = np.rint(DIM * self._clear).astype(np.uint8)
        self._weigh(whole(self.picture.shape))

    def renew(self, picture: Picture, gain: float, where: NDArray[np.bool_]) -> None:
        """Forget a part of the background for what a picture shows there."""
        self._mean[where] = picture[where] / np.float32(gain)
        self._count[where] = 1
        self._frames = 0
        self.picture = np.asarray(cv2.convertScaleAbs(self._mean), np.uint8)
        self._weigh(whole(picture.shape))

    def take(self, picture: Picture, gain: float, window: Window, taken: NDArray[np.bool_]) -> None:
        """Take what a picture shows in a part of a window for the background, at once.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
            The picture's, see `gain`.
        window : Window
        taken : ndarray of bool
            Which pixels of the window.
        """
        taken = taken & (picture[window] <= self.limit[window])
        self._mean[window][taken] = picture[window][taken] / np.float32(gain)
        self._count[window][taken] = np.maximum(self._count[window][taken], 1)
        self.picture[window][taken] = cv2.convertScaleAbs(self._mean[window])[taken]
        self._weigh(window)

    def learn(
        self, picture: Picture, gain: float, hide: Callable[[Window], Picture | None]
    ) -> None:
        """Average a picture in, apart from where the worm is.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
            The picture's, see `gain`.
        hide : callable
            Returns, for a window, a mask that is not zero where the worm hides the background; None
            where it hides none of it.
        """
        height = picture.shape[0]
        if self._frames < EAGER_FRAMES:
            first, last = 0, height
        else:
            first = self._next
            last = min(first + self._rows, height)
            self._next = 0 if last == height else last
        self._frames += 1
        band = slice(first, last), slice(0, picture.shape[1])
        hidden = hide(band)
        if any_white(picture[band], self.limit[band]):
            white = cv2.compare(picture[band], self.limit[band], cv2.CMP_GT)
            white = cv2.dilate(white, np.ones((5, 5), np.uint8))
            hidden = np.asarray(
                white if hidden is None else cv2.bitwise_or(hidden, white), np.uint8
            )
        count, mean = self._count[first:last], self._mean[first:last]
        now = picture[first:last] * np.float32(1 / gain)
        most = max(self._visits, EAGER_FRAMES)
        if count.min() >= most:
            free = None if hidden is None else np.asarray(hidden == 0, np.uint8)
            cv2.accumulateWeighted(now, mean, 1 / most, mask=free)
        else:
            seen = np.ones(1, bool) if hidden is None else hidden == 0
            np.add(count, 1, out=count, where=seen)
            np.minimum(count, most, out=count)
            now -= mean
            now /= np.maximum(count, 1)
            now *= seen
            mean += now
        self.picture[first:last] = cv2.convertScaleAbs(mean)
        self._weigh(band)


def _blocks(window: Window) -> Window:
    """Return which blocks of pixels a window touches."""
    rows, columns = window
    return (
        slice(rows.start // BLOCK_PX, -(-rows.stop // BLOCK_PX)),
        slice(columns.start // BLOCK_PX, -(-columns.stop // BLOCK_PX)),
    )
