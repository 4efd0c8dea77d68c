"""Dirt that a picture shows where the worm is not: it says nothing of a body that lay on it."""

from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Picture
from worm_tracker.detection.blobs import Blob, Window, draw_blob
from worm_tracker.detection.debris import DebrisSettings


@dataclass(frozen=True, eq=False, slots=True)
class LastPicture:
    """The last picture, and where the worm was in it.

    Attributes
    ----------
    picture : ndarray of uint8, shape (h, w)
    gain : float
        Its brightness over the background's.
    worm : Blob
    threshold : float
        Signal of an object, grey levels.
    """

    picture: Picture
    gain: float
    worm: Blob
    threshold: float


def dark_beside(
    signal: Picture, window: Window, last: LastPicture, settings: DebrisSettings
) -> Picture:
    """Return what is dark in a window away from the worm, with its blur; 0 or 255.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        How much darker than the background the window is in the last picture.
    window : Window
    last : LastPicture
    settings : DebrisSettings
    """
    _, dark = cv2.threshold(signal, last.threshold, 255, cv2.THRESH_BINARY)
    blur = settings.worm_blur_px
    if last.worm.near(window, 2 * blur):
        dark[draw_blob(last.worm, window, 2 * blur) > 0] = 0
    size = 2 * settings.dirt_rim_px + 1
    return np.asarray(cv2.dilate(dark, np.ones((size, size), np.uint8)), np.uint8)


def specks(dirt: Picture, most_px2: float) -> Picture | None:
    """Return those pieces of a mask of dirt that are no larger than this; None where none is.

    A hair, or a bubble's rim, may hang on to the worm for much of its length, and is no excuse for
    all that a body leaves over there.
    """
    u, v, w, h = cv2.boundingRect(dirt)
    if not w:
        return None
    box = slice(v, v + h), slice(u, u + w)
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(dirt[box], connectivity=8)
    small = np.zeros(count, np.uint8)
    small[1:] = np.where(stats[1:, cv2.CC_STAT_AREA] <= most_px2, 255, 0)
    if not small.any():
        return None
    found = np.zeros_like(dirt)
    found[box] = small[pieces]
    return found
