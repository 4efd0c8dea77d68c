"""A body's widths up to its tips, which are as round as they are blunt."""

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_tracker.midline.curve import unit_grid


def rounded_half_widths(part: Floats, widths: Floats) -> Floats:
    """Return half the width at parts of a body's length, with its ends as round as they are blunt.

    Parameters
    ----------
    part : ndarray, shape (n,)
        0 to 1.
    widths : ndarray, shape (m,)
        At equal steps.
    """
    half = np.interp(part, unit_grid(len(widths)), widths / 2)
    spacing, most = 1 / (len(widths) - 1), float(widths.max()) / 2
    for beside, from_end in ((widths[1] / 2, part), (widths[-2] / 2, 1 - part)):
        near = from_end < spacing
        power = min(max(1 - beside / most, 0.45), 1.0)
        half[near] = beside * (from_end[near].clip(0) / spacing) ** power
    return half
