"""The centroid of what is seen of a worm, by whole columns and rows of its mask."""

import cv2
import numpy as np

from worm_msgs_py.arrays import Picture


def mask_centroid(mask: Picture) -> tuple[float, float]:
    """Return the centroid (u, v) of the pixels of a mask of 0 and 255; 0, 0 of an empty one.

    Sums of columns and rows give what moments give, at a sixth of the time.
    """
    u, v = (
        float(sums @ np.arange(len(sums))) / max(float(sums.sum()), 1.0)
        for sums in (
            cv2.reduce(mask, axis, cv2.REDUCE_SUM, dtype=cv2.CV_32S).ravel() for axis in (0, 1)
        )
    )
    return u, v
