"""The pixels of an object that may hold itself in a loop: its holes are left open."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.detection.blobs import draw_blob, window_around
from worm_tracker.detection.detector import Sight

MARGIN_PX = 24


def object_mask(sight: Sight) -> NDArray[np.uint8]:
    """Return the object's pixels in its window, holes open; 0 or 255."""
    _, above = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    return np.asarray(cv2.bitwise_and(draw_blob(sight.blob, sight.window), above), np.uint8)


def centroid_of(sight: Sight) -> tuple[float, float]:
    """Return the centroid (u, v) of an object's pixels."""
    moments = cv2.moments(object_mask(sight), binaryImage=True)
    area = max(moments["m00"], 1.0)
    u, v = moments["m10"] / area, moments["m01"] / area
    return u + sight.window[1].start, v + sight.window[0].start


def kept(sight: Sight) -> Sight:
    """Return what must be kept of a sight to look at its object later: a small window."""
    rows, columns = sight.window
    v0, u0 = rows.start, columns.start
    window = window_around(sight.blob.box, MARGIN_PX, (rows.stop, columns.stop))
    rows = slice(max(window[0].start, v0), window[0].stop)
    columns = slice(max(window[1].start, u0), window[1].stop)
    part = np.s_[rows.start - v0 : rows.stop - v0, columns.start - u0 : columns.stop - u0]
    return replace(
        sight,
        window=(rows, columns),
        signal=sight.signal[part].copy(),
        smooth=sight.smooth[part].copy(),
    )
