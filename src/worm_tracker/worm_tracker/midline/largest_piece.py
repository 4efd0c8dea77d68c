"""The largest connected piece of a mask."""

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Picture
from worm_tracker.midline.occupied_part import occupied_box


def largest_piece(mask: Picture) -> Complex:
    """Return the pixels, u + iv, of the largest connected piece of a mask, row by row.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)

    Returns
    -------
    ndarray of complex, shape (n,)
        Empty where all of the mask is zero.
    """
    box = occupied_box(mask)
    # Most of a mask is empty. Pieces are numbered by squares of two pixels: those of the whole mask
    # are kept, so that of two that are as large the same one is taken.
    top, left = (each.start - each.start % 2 for each in box)
    part = mask[top : box[0].stop, left : box[1].stop]
    if not part.size:
        return np.zeros(0, np.complex128)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(part, connectivity=8)
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    u, v, width, height = stats[largest, : cv2.CC_STAT_AREA].tolist()
    rows, columns = np.nonzero(labels[v : v + height, u : u + width] == largest)
    return np.asarray((columns + (left + u)) + 1j * (rows + (top + v)), np.complex128)
