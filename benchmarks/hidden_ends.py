"""Which ends of a true body lie under another part of it, where one shade shows nothing of them."""

import numpy as np
from numpy.typing import NDArray

HIDDEN_WIDTHS = 1.0
"""How long a stretch of an end is hidden at least: a midline may be off by as much."""
STICKS_OUT_WIDTHS = 0.1
"""How far it may stick out beside the other part and still not be seen."""
OTHER_PART_WIDTHS = 2.5
"""How far along the body from an end another part of it begins."""


def hides_end(midline: NDArray[np.float64], half_width: NDArray[np.float64], width: float) -> bool:
    """Tell whether an end lies under another part of the body, by a width of its length or more.

    Where overlaps are no darker, such an end may lie anywhere along that part.

    Parameters
    ----------
    midline : ndarray, shape (n, 2)
        True midline, pixels.
    half_width : ndarray, shape (n,)
        Half of the body's true width there, pixels.
    width : float
        That of most of the body, pixels.
    """
    steps = np.hypot(*np.diff(midline, axis=0).T)
    for turn in (1, -1):
        line, half = midline[::turn], half_width[::turn]
        along = np.concatenate([[0.0], np.cumsum(steps[::turn])]) / width
        end, other = along <= HIDDEN_WIDTHS, along > OTHER_PART_WIDTHS
        if not other.any():
            continue
        away = np.hypot(*np.moveaxis(line[end][:, None] - line[other], 2, 0))
        inside = (half[other] - away).max(axis=1)
        if (half[end] - inside <= STICKS_OUT_WIDTHS * width).all():
            return True
    return False
