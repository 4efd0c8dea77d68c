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
        is_inside = np.asarray(fine > level)
        inside = is_inside.view(np.uint8) * np.uint8(255)
        to_object = cv2.distanceTransform(cv2.bitwise_not(inside), cv2.DIST_L2, 5)
        to_water = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
        to_edge = np.where(is_inside, np.float32(0.5), np.float32(-0.5))
        signed = cv2.add(cv2.subtract(to_object, to_water), to_edge)
        smooth = cv2.GaussianBlur(signed, (0, 0), 1.0)
        distance = np.asarray(cv2.resize(smooth, size, interpolation=cv2.INTER_AREA), np.float32)
        distance /= 2
        on_it = cv2.findNonZero(cv2.inRange(distance, -0.5, 0.5))
        u, v = np.zeros((2, 0)) if on_it is None else np.asarray(on_it).reshape(-1, 2).T
        return cls(distance, u + 1j * v)

    def near(self, place: complex, reach: float) -> "Outline":
        """Return the outline with the pixels alone that are so near to a place."""
        return Outline(self.distance, self.pixels[np.abs(self.pixels - place) <= reach])
