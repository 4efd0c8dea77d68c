"""An object's outline to a fraction of a pixel, and how far places are from it."""

from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats32, Picture


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """An object's outline.

    Attributes
    ----------
    distance : ndarray of float32, shape (h, w)
        How far each pixel is from it, less than 0 within the object.
    pixels : ndarray of complex, shape (n,)
        Those on it, u + iv.
    """

    distance: Floats32
    pixels: Complex

    @classmethod
    def of(cls, signal: Picture, level: float) -> "Outline":
        """Return the outline of what has more than a level of signal."""
        size = signal.shape[1], signal.shape[0]
        fine = cv2.resize(signal.astype(np.float32), None, None, 2, 2, cv2.INTER_CUBIC)
        inside = (fine > level).astype(np.uint8)
        to_object = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
        to_water = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
        distance = np.where(inside > 0, 0.5 - to_water, to_object - 0.5).astype(np.float32)
        smooth = cv2.GaussianBlur(distance, (0, 0), 1.0) / 2
        distance = np.asarray(cv2.resize(smooth, size, interpolation=cv2.INTER_AREA), np.float32)
        v, u = np.nonzero(np.abs(distance) < 0.5)
        return cls(distance, u + 1j * v)
