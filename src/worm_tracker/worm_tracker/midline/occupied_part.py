"""The part of a mask that holds all of what it shows: most of a worm's window is water."""

import cv2

from worm_msgs_py.arrays import Picture


def occupied_box(mask: Picture) -> tuple[slice, slice]:
    """Return the rows and columns of a mask, (h, w), that hold all that is not zero."""
    u, v, width, height = cv2.boundingRect(mask)
    return slice(v, v + height), slice(u, u + width)


def occupied_part(mask: Picture) -> Picture:
    """Return the smallest part of a mask that holds all that is not zero, and a pixel around it.

    What is far from that tells nothing of its pieces or its thickness.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)

    Returns
    -------
    ndarray of uint8
        A view; a pixel of the mask where all of it is zero.
    """
    rows, columns = occupied_box(mask)
    return mask[
        max(rows.start - 1, 0) : rows.stop + 1, max(columns.start - 1, 0) : columns.stop + 1
    ]
