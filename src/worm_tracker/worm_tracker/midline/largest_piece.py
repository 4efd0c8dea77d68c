"""The largest connected piece of a mask."""

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Picture


def largest_piece(mask: Picture) -> Complex:
    """Return the pixels, u + iv, of the largest connected piece of a mask, row by row.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)

    Returns
    -------
    ndarray of complex, shape (n,)
        None where all of the mask is zero.
    """
    u0, v0, width, height = cv2.boundingRect(mask)
    # Most of a mask is empty. Pieces are numbered by squares of two pixels: those of the whole mask
    # are kept, so that of two that are as large the same one is taken.
    left, top = u0 - u0 % 2, v0 - v0 % 2
    part = mask[top : v0 + height, left : u0 + width]
    if not part.size:
        return np.zeros(0, np.complex128)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(part, connectivity=8)
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    u, v, width, height = stats[largest, : cv2.CC_STAT_AREA].tolist()
    rows, columns = np.nonzero(labels[v : v + height, u : u + width] == largest)
    return np.asarray((columns + (left + u)) + 1j * (rows + (top + v)), np.complex128)
