"""What is not worm: things that hang on to it are cut off, things beside it become background."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.body_model import Known
from worm_tracker.detection.blobs import Picture, Window, find_blobs
from worm_tracker.detection.detector import OVERGROWN, Sight
from worm_tracker.midline.contour_midline import Floats

MARGIN = 0.4
"""How far beside the body, as it was carried on, the worm's own pixels may lie, in widths."""
AHEAD = 1.5
"""How far beyond its last ends the worm may have got in a frame, in widths."""
THIN = 0.6
"""What is thinner than this, in widths, is no body."""
OPENINGS = (0.4, 0.55, 0.7)
"""Parts of an object thinner than these, relative to its thickest, are taken off in turn."""
MOST_OF = 0.75
"""The worm is at least this part of the object."""
RIM_PX = 2
"""What belongs to the edge of an object: its blur."""


def views(sight: Sight, known: Known | None, body: Floats | None) -> Iterator[Sight]:
    """Return the sights in which the worm may be told from what hangs on to it, likeliest first.

    Parameters
    ----------
    sight : Sight
        The object as it is.
    known : Known or None
        The worm; nothing is known of it in the first frames.
    body : ndarray, shape (POINTS, 2), or None
        Its midline when it was last seen.
    """
    if known is None:
        yield sight
        yield from opened(sight)
        return
    if body is not None and sight.blob.area > OVERGROWN * known.area:
        cut = trimmed(sight, body, known.width)
        if cut is not None:
            yield cut
            left = without_thin(cut, round(THIN * known.width))
            if left is not None:
                yield left
    yield sight


def corridor(shape: tuple[int, ...], points: Floats, width: float, ahead: float) -> Picture:
    """Return the neighbourhood of a body as a mask: half a width and the margin to either side.

    Parameters
    ----------
    shape : tuple of int
    points : ndarray, shape (n, 2)
        Its midline, in the mask's coordinates.
    width : float
        Its width, pixels.
    ahead : float
        How far the mask goes beyond its ends, in widths.
    """
    mask = np.zeros(shape, np.uint8)
    line = [points]
    for end, inner in ((points[0], points[6]), (points[-1], points[-7])):
        way = end - inner
        way = way / max(float(np.hypot(*way)), 1e-9)
        line.append(np.stack([end, end + ahead * width * way]))
    thickness = max(3, round((1 + 2 * MARGIN) * width))
    for part in line:
        cv2.polylines(mask, [np.rint(16 * part).astype(np.int32)], False, 255, thickness, 8, 4)
    return mask


def trimmed(sight: Sight, points: Floats, width: float) -> Sight | None:
    """Return the sight of what lies near the body as it was, without what hangs on to it.

    Parameters
    ----------
    sight : Sight
    points : ndarray, shape (POINTS, 2)
        The body's midline in the frame before.
    width : float
        Its width, pixels.
    """
    near = corridor(sight.smooth.shape, points - origin(sight.window), width, AHEAD)
    return within(sight, near)


def opened(sight: Sight) -> Iterator[Sight]:
    """Return what is left of the object where thin parts fall off: ever thicker ones."""
    _, mask = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    thickest = 2 * float(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max())
    for part in OPENINGS:
        size = round(part * thickest)
        left = without_thin(sight, size) if size >= 3 else None
        if left is not None and left.blob.area > MOST_OF * sight.blob.area:
            yield left


def without_thin(sight: Sight, size: int) -> Sight | None:
    """Return the sight of what is left where nothing thinner than `size` pixels is."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    _, mask = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    return within(sight, np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel), np.uint8))


def within(sight: Sight, mask: Picture) -> Sight | None:
    """Return the sight of the largest object within a mask; what is outside is no signal."""
    smooth = np.asarray(cv2.bitwise_and(sight.smooth, mask), np.uint8)
    blobs = find_blobs(smooth, sight.threshold, sight.window)
    if not blobs:
        return None
    wide = cv2.dilate(mask, np.ones((2 * RIM_PX + 1, 2 * RIM_PX + 1), np.uint8))
    signal = np.asarray(cv2.bitwise_and(sight.signal, wide), np.uint8)
    return replace(sight, signal=signal, smooth=smooth, blob=blobs[0])


def origin(window: Window) -> NDArray[np.float64]:
    """Return (u, v) of a window's first pixel."""
    return np.array([window[1].start, window[0].start], np.float64)
