"""The picture without the worm, kept up to date without ever absorbing the worm."""

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats, Floats32, Mask, Picture
from worm_tracker.detection.blobs import Window, whole_picture
from worm_tracker.detection.dim_places import DimPlaces, DimPlacesSettings
from worm_tracker.detection.glare import GLARE_STRIDE, glare_in, glare_limit
from worm_tracker.detection.illumination import evened


@dataclass(frozen=True, slots=True)
class BackgroundSettings:
    """How fast the background follows, and how a picture's brightness is compared with it."""

    memory_frames: int = 256
    """Frames after which an old background has mostly been forgotten."""
    first_frames: int = 12
    """First frames, in which all of the picture is averaged at once."""
    pixels_per_frame: int = 16384
    """Pixels that are refreshed per frame thereafter: a band of rows that goes round and round."""
    gain_stride_px: int = 16
    gain_samples: int = 1000
    """Pixels whose median gives the change of the light: good to a thousandth."""
    gain_sample_frames: int = 16
    """Frames between two readings of the background for the gain: it changes slowly."""
    least_gain: float = 0.5
    most_gain: float = 2.0
    """Brightness over the background's beyond which a picture is no view of the rig."""
    gain_change_ignored: float = 0.002
    """Gain that is no change: less than a grey level."""
    glare_over_clear_grey: int = 20
    """Grey levels above the rig's own light from which what saturates is glare. Where clear water
    itself is about white nothing is glare: a worm is dark there as everywhere."""
    dim: DimPlacesSettings = field(default_factory=DimPlacesSettings)


class Background:
    """A running mean of every pixel over the frames in which the worm was elsewhere.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture.
    empty : ndarray of float32, shape (h, w)
        What it would show without a worm (see `empty_rig`).
    worm : ndarray of uint8, shape (h, w)
        Non-zero where the worm, widened by its blur, covers the background of the first picture.
    water : ndarray of bool, shape (h, w)
        Where clear water lets all light through.
    evening : ndarray of uint8, shape (h, w)
        What a signal is multiplied by, in hundredths, for light that is the same everywhere (see
        `evening_of`).
    settings : BackgroundSettings

    Attributes
    ----------
    picture : ndarray of uint8, shape (h, w)
        The background.
    clear : ndarray of uint8, shape (h, w)
        The rig's own light in the first picture.
    dim : DimPlaces
        Where it lets through much less light than clear water.
    """

    def __init__(
        self,
        picture: Picture,
        empty: Floats32,
        worm: Picture,
        water: Mask,
        evening: Picture,
        settings: BackgroundSettings,
    ) -> None:
        self._settings = settings
        self._evening = evening
        self.clear = np.rint(empty).astype(np.uint8)
        limit = glare_limit(self.clear, settings.glare_over_clear_grey)
        masked = (worm > 0) | (picture > limit)
        self._mean = np.where(masked, empty, picture).astype(np.float32)
        self._count = np.where(masked, 0, 1).astype(np.float32)
        self.picture = np.rint(self._mean).astype(np.uint8)
        clear = np.where(water, empty, 0).astype(np.float32)
        self.dim = DimPlaces(self.picture, clear, settings.dim)
        height, width = picture.shape
        self._rows = int(np.clip(settings.pixels_per_frame // width, 1, height))
        self._next = 0
        self._frames = 0
        self._most_visits = settings.memory_frames * self._rows / height
        self._sample = _bright_sample(self._mean, settings)
        self._sampled = np.ones(0, np.float32)

    def gain(self, picture: Picture) -> float:
        """Return the picture's brightness over the background's (flicker), by the median."""
        ratio = picture.reshape(-1).take(self._sample) / self._at_samples()
        middle = len(ratio) // 2
        ratio.partition(middle)
        return float(ratio[middle])

    def is_view(self, gain: float) -> bool:
        """Tell whether a picture of this gain shows the rig: not when the lamp is off."""
        return self._settings.least_gain <= gain <= self._settings.most_gain

    def _at_samples(self) -> Floats32:
        """Return the background at the samples; it changes too slowly to be read each time."""
        settings = self._settings
        if self._frames <= settings.first_frames or self._frames % settings.gain_sample_frames == 0:
            self._sampled = np.maximum(self._mean.reshape(-1).take(self._sample), 1.0)
        return self._sampled

    def signal(self, picture: Picture, gain: float, window: Window) -> Picture:
        """Return how much darker than the background a window of the picture is."""
        signal = np.asarray(cv2.subtract(self.scaled(gain, window), picture[window]), np.uint8)
        self.dim.weigh(signal, window)
        return evened(signal, self._evening[window])

    def scaled(self, gain: float, window: Window) -> Picture:
        """Return a window of the background as bright as a picture of this gain."""
        return self._as_bright(self.picture[window], gain)

    def glare_limit(self, gain: float, window: Window) -> Picture:
        """Return the grey level above which a pixel of a window is glare, at a picture's gain."""
        clear = self._as_bright(self.clear[window], gain)
        return glare_limit(clear, self._settings.glare_over_clear_grey)

    def any_glare(self, picture: Picture, gain: float, window: Window) -> bool:
        """Tell whether there is glare in a window of a picture."""
        sparse = np.s_[::GLARE_STRIDE, ::GLARE_STRIDE]
        clear = self._as_bright(np.ascontiguousarray(self.clear[window][sparse]), gain)
        limit = glare_limit(clear, self._settings.glare_over_clear_grey)
        if not (picture[window][sparse] > limit).any():
            return False
        return bool(glare_in(picture[window], self.glare_limit(gain, window)).any())

    def _as_bright(self, background: Picture, gain: float) -> Picture:
        if abs(gain - 1) > self._settings.gain_change_ignored:
            background = np.asarray(cv2.convertScaleAbs(background, alpha=gain), np.uint8)
        return background

    def transform(self, motion: Floats) -> None:
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
        self._count = np.minimum(count, self._settings.first_frames).astype(np.float32)
        self._frames = 0
        self.picture = np.asarray(cv2.convertScaleAbs(self._mean), np.uint8)
        self.clear = np.asarray(
            cv2.warpAffine(self.clear, motion, size, flags=cv2.INTER_NEAREST, borderValue=255),
            np.uint8,
        )
        self._evening = np.asarray(
            cv2.warpAffine(self._evening, motion, size, borderMode=replicate), np.uint8
        )
        self.dim.transform(motion)
        self.dim.update(self.picture, whole_picture(self.picture.shape))

    def reset(self, picture: Picture, gain: float, where: Mask) -> None:
        """Forget a part of the background for what a picture shows there."""
        self._mean[where] = picture[where] / np.float32(gain)
        self._count[where] = 1
        self._frames = 0
        self.picture = np.asarray(cv2.convertScaleAbs(self._mean), np.uint8)
        self.dim.update(self.picture, whole_picture(picture.shape))

    def absorb(self, picture: Picture, gain: float, window: Window, where: Mask) -> None:
        """Take what a picture shows in a part of a window for the background, at once.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
            The picture's, see `gain`.
        window : Window
        where : ndarray of bool
            Which pixels of the window.
        """
        where = where & (picture[window] <= self.glare_limit(gain, window))
        self._mean[window][where] = picture[window][where] / np.float32(gain)
        self._count[window][where] = np.maximum(self._count[window][where], 1)
        self.picture[window][where] = cv2.convertScaleAbs(self._mean[window])[where]
        self.dim.update(self.picture, window)

    def average(
        self, picture: Picture, gain: float, worm_mask: Callable[[Window], Picture | None]
    ) -> None:
        """Average a picture in, apart from where the worm is.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        gain : float
            The picture's, see `gain`.
        worm_mask : callable
            Returns, for a window, a mask that is not zero where the worm covers it; None
            where it covers none of it.
        """
        height, settings = picture.shape[0], self._settings
        if self._frames < settings.first_frames:
            first, last = 0, height
        else:
            first = self._next
            last = min(first + self._rows, height)
            self._next = 0 if last == height else last
        self._frames += 1
        band = slice(first, last), slice(0, picture.shape[1])
        masked = worm_mask(band)
        if self.any_glare(picture, gain, band):
            white = glare_in(picture[band], self.glare_limit(gain, band))
            about = np.asarray(cv2.dilate(white, np.ones((5, 5), np.uint8)), np.uint8)
            masked = about if masked is None else np.asarray(masked | about, np.uint8)
        count, mean = self._count[first:last], self._mean[first:last]
        now = picture[first:last] * np.float32(1 / gain)
        most = max(self._most_visits, settings.first_frames)
        if count.min() >= most:
            free = None if masked is None else np.asarray(masked == 0, np.uint8)
            cv2.accumulateWeighted(now, mean, 1 / most, mask=free)
        else:
            seen = np.ones(1, bool) if masked is None else masked == 0
            np.add(count, 1, out=count, where=seen)
            np.minimum(count, most, out=count)
            now -= mean
            now /= np.maximum(count, 1)
            now *= seen
            mean += now
        self.picture[first:last] = cv2.convertScaleAbs(mean)
        self.dim.update(self.picture, band)


def _bright_sample(mean: Floats32, settings: BackgroundSettings) -> NDArray[np.int64]:
    """Return pixels of the bright background, spread over the picture, as flat indices."""
    sample = np.zeros(mean.shape, bool)
    stride = max(1, min(settings.gain_stride_px, min(mean.shape) // 16))
    sample[::stride, ::stride] = True
    level = np.quantile(mean[sample], 0.9)
    bright = np.flatnonzero(sample & (mean > 0.5 * level))
    return bright[:: max(1, len(bright) // settings.gain_samples)]
