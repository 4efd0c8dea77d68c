"""Where the background is dim, by dirt or a bubble's rim: a worm there takes away less light."""

from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Floats32, Mask, Picture
from worm_tracker.detection.blobs import Window

_WEIGHT_ONE = 64
"""Weight of a signal before clear water, as a whole number."""
_BLOCK_PX = 16
"""Side of the blocks in which dim places are booked."""


@dataclass(frozen=True, slots=True)
class DimPlacesSettings:
    """From when a place is dim, and what is made of the signal there."""

    dim_over_clear: float = 0.6
    """Part of clear water's light below which the signal is weighed: dirt is there."""
    most_weight: float = 3.5
    """Most such weight: where there is less light left the picture cannot tell."""
    margin_px: int = 4
    """How far about a dim place its blur reaches."""
    rim_px: int = 2
    """How far about a place as dim as this it shows nothing of a worm."""


class DimPlaces:
    """Weighs the signal by the light that clear water would let through, over what is let through.

    So weighed, a worm takes away the same part of the light everywhere.

    Parameters
    ----------
    background : ndarray of uint8, shape (h, w)
    clear : ndarray of float32, shape (h, w)
        What clear water lets through; 0 where there is none.
    settings : DimPlacesSettings
    """

    def __init__(self, background: Picture, clear: Floats32, settings: DimPlacesSettings) -> None:
        self._settings = settings
        self._clear = clear
        self._dim = np.rint(settings.dim_over_clear * clear).astype(np.uint8)
        self._weight = np.full(background.shape, _WEIGHT_ONE, np.uint8)
        self._weighted = np.zeros(-(-np.array(background.shape) // _BLOCK_PX), bool)
        height, width = background.shape
        self.update(background, (slice(0, height), slice(0, width)))

    def any_in(self, window: Window) -> bool:
        """Tell whether anything in a window lets through much less light than clear water."""
        return bool(self._weighted[_blocks(window)].any())

    def mask(self, window: Window) -> Mask:
        """Return where in a window, or just beside, less light comes through than clear water."""
        return self._about(window, self._settings.margin_px) > 0

    def picture(self, window: Window) -> Picture | None:
        """Return where in a window dirt shows nothing of a worm, 0 or 255; None where nowhere."""
        return self._about(window, self._settings.rim_px) if self.any_in(window) else None

    def _about(self, window: Window, reach_px: int) -> Picture:
        """Return where in a window, or so near to it, the background is dim; 0 or 255."""
        dim = np.asarray(self._weight[window] != _WEIGHT_ONE, np.uint8) * np.uint8(255)
        size = 2 * reach_px + 1
        return np.asarray(cv2.dilate(dim, np.ones((size, size), np.uint8)), np.uint8)

    def weigh(self, signal: Picture, window: Window) -> None:
        """Make the signal in a window as strong, in place, as it would be before clear water."""
        if self.any_in(window):
            cv2.multiply(signal, self._weight[window], dst=signal, scale=1 / _WEIGHT_ONE)

    def update(self, background: Picture, window: Window) -> None:
        """Take a window of the background as it is now."""
        now, blocks = background[window], _blocks(window)
        dim = cv2.compare(now, self._dim[window], cv2.CMP_LT)
        if not (cv2.countNonZero(dim) or self._weighted[blocks].any()):
            return
        parts = self._clear[window] / np.maximum(now, 1)
        weight = _WEIGHT_ONE * np.minimum(parts, self._settings.most_weight) + 0.5
        self._weight[window] = np.where(dim > 0, weight, _WEIGHT_ONE)
        rows, columns = (slice(part.start * _BLOCK_PX, part.stop * _BLOCK_PX) for part in blocks)
        v, u = np.nonzero(self._weight[rows, columns] != _WEIGHT_ONE)
        self._weighted[blocks] = False
        self._weighted[(v + rows.start) // _BLOCK_PX, (u + columns.start) // _BLOCK_PX] = True

    def transform(self, motion: Floats) -> None:
        """Take the clear water along by an affine map (2, 3); `update` has to follow."""
        size = self._clear.shape[::-1]
        clear = cv2.warpAffine(self._clear, motion, size, flags=cv2.INTER_NEAREST)
        self._clear = np.asarray(clear, np.float32)
        self._dim = np.rint(self._settings.dim_over_clear * self._clear).astype(np.uint8)


def _blocks(window: Window) -> Window:
    """Return which blocks of pixels a window touches."""
    rows, columns = window
    return (
        slice(rows.start // _BLOCK_PX, -(-rows.stop // _BLOCK_PX)),
        slice(columns.start // _BLOCK_PX, -(-columns.stop // _BLOCK_PX)),
    )
