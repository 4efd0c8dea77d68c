"""Where glare saturates the picture, and what can still be seen through its fringe."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.blobs import smoothed

SATURATED = 250
"""Grey level from which the camera cannot tell one light from another."""
GLARE_STRIDE = 8
"""Of the rows and columns that are looked at to see whether there is any glare."""


@dataclass(frozen=True, slots=True)
class GlareSettings:
    """What of a worm can be told in and about glare."""

    most_track_width_widths: float = 1.8
    """A dark track that is narrower than this is the worm before the glare."""
    least_signal_in_glare: float = 15.0
    """Least signal, grey levels, that counts where all but the worm is white: there is no noise in
    what is white."""
    fringe_widths: float = 0.75
    """How far around what is white the picture may be of no use."""


class GlareView(NamedTuple):
    """A window as it is seen through glare.

    Attributes
    ----------
    signal, smooth : ndarray of uint8
        As in a `SignalView`; in what is white `smooth` is so much stronger that the usual threshold
        is right there too.
    occluder : ndarray of uint8
        Not zero where the glare may occlude the worm.
    """

    signal: Picture
    smooth: Picture
    occluder: Picture


def glare_limit(clear: Picture, least_over_clear: int) -> Picture:
    """Return the grey level above which a pixel is glare; 255, which is never, in bright water.

    Parameters
    ----------
    clear : ndarray of uint8, shape (h, w)
        The rig's own light, as bright as in the picture: by a lamp that has grown brighter the
        water may be white itself.
    least_over_clear : int
        See `BackgroundSettings`.
    """
    _, limit = cv2.threshold(clear, SATURATED - least_over_clear - 1, 255, cv2.THRESH_BINARY)
    return np.maximum(np.asarray(limit, np.uint8), np.uint8(SATURATED - 1))


def glare_in(picture: Picture, limit: Picture) -> Picture:
    """Return where a picture is glare, 0 or 255.

    Single pixels are not, which noise has made white.

    Parameters
    ----------
    picture, limit : ndarray of uint8, shape (h, w)
        See `glare_limit`.
    """
    white = cv2.compare(picture, limit, cv2.CMP_GT)
    among_white = cv2.dilate(cv2.medianBlur(white, 3), np.ones((3, 3), np.uint8))
    return np.asarray(cv2.bitwise_and(white, among_white), np.uint8)


def look_through_glare(
    picture: Picture,
    limit: Picture,
    background: Picture,
    arena: Picture,
    width: float,
    threshold: float,
    settings: GlareSettings,
) -> GlareView:
    """Look through the fringe of glare.

    Parameters
    ----------
    picture, limit, background, arena : ndarray of uint8, shape (h, w)
        A window of the picture, of `glare_limit`, of the background, and of where a worm can be.
    width : float
        The worm's, pixels.
    threshold : float
        What counts as object elsewhere.
    settings : GlareSettings

    Notes
    -----
    The light with the glare but without the worm is what is left where dark tracks as narrow as the
    worm are closed.
    """
    white = glare_in(picture, limit)
    size = 2 * round(settings.most_track_width_widths * width / 2) + 1
    closing = np.ones((size, size), np.uint8)
    bright = cv2.morphologyEx(white, cv2.MORPH_CLOSE, closing)
    light = cv2.morphologyEx(picture, cv2.MORPH_CLOSE, closing)
    background = np.where(bright > 0, cv2.max(light, background), background)
    signal = np.asarray(cv2.bitwise_and(cv2.subtract(background, picture), arena), np.uint8)
    smooth = smoothed(signal)
    gain = max(threshold / settings.least_signal_in_glare, 1.0)
    stronger = cv2.convertScaleAbs(smooth, alpha=gain)
    smooth = np.asarray(np.where((bright > 0) & (light >= SATURATED), stronger, smooth), np.uint8)
    reach = 2 * round(settings.fringe_widths * width) + 1
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    return GlareView(signal, smooth, np.asarray(cv2.dilate(bright, around), np.uint8))


def may_occlude(occluder: Picture, points: Floats, reach: float) -> bool:
    """Tell whether any point of a curve, or of its ends continued by a reach, is in an occluder."""
    ends = [
        points[k] + (points[k] - points[j]) * reach / _distance(points[k], points[j])
        for k, j in ((0, 3), (-1, -4))
    ]
    u, v = np.rint(np.concatenate([points, ends])).astype(int).T
    height, width = occluder.shape
    return bool((occluder[v.clip(0, height - 1), u.clip(0, width - 1)] > 0).any())


def _distance(one: Floats, other: Floats) -> float:
    return max(float(np.hypot(*(one - other))), 1e-9)
