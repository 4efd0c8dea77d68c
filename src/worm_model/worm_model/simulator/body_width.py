"""The width of a simulated worm along its body: blunt at the head, slender at the tail."""

import numpy as np

from worm_model.simulator.rig.body import HEAD_TAPER_WIDTHS, TAIL_TAPER_WIDTHS
from worm_msgs_py.arrays import Floats

HEAD_TIP_WIDTH, TAIL_TIP_WIDTH = 0.6, 0.4
"""The width at the tips, which are half circles, as a part of the full one."""


def tapered(s_widths: Floats) -> Floats:
    """Return the width along a body, as a part of the full one.

    Parameters
    ----------
    s_widths : ndarray, shape (n,)
        Arc length from tip to tip, head first, in full widths.
    """
    head = _end(s_widths / HEAD_TAPER_WIDTHS, HEAD_TIP_WIDTH)
    tail = _end((s_widths[-1] - s_widths) / TAIL_TAPER_WIDTHS, TAIL_TIP_WIDTH)
    return np.minimum(head, tail)


def _end(part: Floats, tip: float) -> Floats:
    """Return the width near an end: that of the tip, and half an ellipse from there on."""
    return np.asarray(tip + (1.0 - tip) * np.sqrt(1.0 - (1.0 - np.clip(part, 0.0, 1.0)) ** 2))
