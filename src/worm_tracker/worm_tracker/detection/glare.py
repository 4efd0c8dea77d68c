"""Where glare leaves the picture nothing to tell, and what can still be seen through its fringe."""

from typing import NamedTuple

import cv2
import numpy as np

from worm_tracker.detection.blobs import Floats, Picture, smoothed

WHITE = 250
"""Grey level from which the camera cannot tell one light from another."""
ABOVE = 20
"""Grey levels above the rig's own light from which that is glare. Where clear water itself is about
white nothing is glare: a worm is dark there as everywhere."""
STRIDE = 8
"""Of the rows and columns that are looked at to see whether there is any glare."""
WIDER = 1.8
"""A dark track that is narrower than this, in the worm's widths, is the worm before the glare."""
FAINTEST = 15.0
"""Least signal that counts where all but the worm is white: there is no noise in what is white."""
FAR = 0.75
"""How far around what is white the picture may be of no use, in widths."""


class Through(NamedTuple):
    """A window as it is seen through glare.

    Attributes
    ----------
    signal, smooth : ndarray of uint8
        As in a `Sight`; in what is white `smooth` is so much stronger that the usual threshold is
        right there too.
    zone : ndarray of uint8
        Not zero where the picture may not tell.
    """

    signal: Picture
    smooth: Picture
    zone: Picture


def white_from(clear: Picture) -> Picture:
    """Return the grey level above which a pixel is glare; 255, which is never, in bright water."""
    return np.where(clear < WHITE - ABOVE, WHITE - 1, 255).astype(np.uint8)


def any_white(picture: Picture, limit: Picture) -> bool:
    """Tell whether there is glare in a window."""
    return bool((picture[::STRIDE, ::STRIDE] > limit[::STRIDE, ::STRIDE]).any())


def seen_through(
    picture: Picture,
    limit: Picture,
    ground: Picture,
    arena: Picture,
    width: float,
    threshold: float,
) -> Through:
    """Look through the fringe of glare.

    Parameters
    ----------
    picture, limit, ground, arena : ndarray of uint8, shape (h, w)
        A window of the picture, of `white_from`, of the background, and of where a worm can be.
    width : float
        The worm's, pixels.
    threshold : float
        What counts as object elsewhere.

    Notes
    -----
    The light with the glare but without the worm is what is left where dark tracks as narrow as the
    worm are closed.
    """
    white = cv2.compare(picture, limit, cv2.CMP_GT)
    size = 2 * round(WIDER * width / 2) + 1
    closing = np.ones((size, size), np.uint8)
    bright = cv2.morphologyEx(white, cv2.MORPH_CLOSE, closing)
    light = cv2.morphologyEx(picture, cv2.MORPH_CLOSE, closing)
    ground = np.where(bright > 0, cv2.max(light, ground), ground)
    signal = np.asarray(cv2.bitwise_and(cv2.subtract(ground, picture), arena), np.uint8)
    smooth = smoothed(signal)
    stronger = cv2.convertScaleAbs(smooth, alpha=max(threshold / FAINTEST, 1.0))
    smooth = np.asarray(np.where((bright > 0) & (light >= WHITE), stronger, smooth), np.uint8)
    reach = 2 * round(FAR * width) + 1
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    return Through(signal, smooth, np.asarray(cv2.dilate(bright, around), np.uint8))


def near(zone: Picture, points: Floats, reach: float) -> bool:
    """Tell whether any point of a curve, or of its ends' way on, is within a reach of a zone."""
    ends = [
        points[k] + (points[k] - points[j]) * reach / _apart(points[k], points[j])
        for k, j in ((0, 3), (-1, -4))
    ]
    u, v = np.rint(np.concatenate([points, ends])).astype(int).T
    return bool((zone[v.clip(0, zone.shape[0] - 1), u.clip(0, zone.shape[1] - 1)] > 0).any())


def _apart(one: Floats, other: Floats) -> float:
    return max(float(np.hypot(*(one - other))), 1e-9)
