"""What is kept out of the background: the worm, and all that may be a part of it."""

from collections.abc import Callable

import numpy as np

from worm_msgs_py.arrays import Picture
from worm_tracker.detection.background import Background
from worm_tracker.detection.blobs import Blob, Window, draw_blob


def worm_mask(blob: Blob, blur_px: int) -> Callable[[Window], Picture | None]:
    """Return the function that masks the worm, and its blur about it."""
    return lambda window: draw_blob(blob, window, blur_px) if blob.near(window, blur_px) else None


def dark_mask(
    background: Background, picture: Picture, gain: float, level: float
) -> Callable[[Window], Picture]:
    """Return the function that masks all that is darker than the background by some grey levels."""

    def dark(window: Window) -> Picture:
        signal = background.signal(picture, gain, window)
        return np.asarray(signal > level, np.uint8)

    return dark


def either_of(
    one: Callable[[Window], Picture | None], other: Callable[[Window], Picture]
) -> Callable[[Window], Picture]:
    """Return the function that masks what either of two masks."""

    def both(window: Window) -> Picture:
        mask = one(window)
        return other(window) if mask is None else np.asarray(mask | other(window), np.uint8)

    return both
