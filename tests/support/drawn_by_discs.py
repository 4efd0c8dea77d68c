"""Bodies drawn by discs: nothing that the tracker draws by."""

import cv2
import numpy as np


def drawn_by_discs(shape, points, widths, level=255):
    """Return a picture of that shape, 0 but where a body of points (n, 2) and widths (n,) lies."""
    picture = np.zeros(shape, np.uint8)
    for (u, v), width in zip(points, widths, strict=True):
        centre = round(16 * u), round(16 * v)
        cv2.circle(picture, centre, round(8 * width), level, -1, cv2.LINE_8, 4)
    return picture


def finely(values, count):
    """Return values (n, ...) at so many places, evenly."""
    at = np.linspace(0, len(values) - 1, count)
    columns = np.reshape(values, (len(values), -1)).T
    fine = np.stack([np.interp(at, np.arange(len(values)), each) for each in columns], axis=1)
    return fine.reshape(count, *np.shape(values)[1:])
