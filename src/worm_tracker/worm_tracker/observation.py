"""What one picture says of the worm, before anyone knows which end is the head."""

from dataclasses import dataclass, field

import numpy as np

from worm_msgs_py.status import Status
from worm_tracker.midline.contour_midline import Floats


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """What one picture says of the worm, before anyone knows which end is the head.

    Attributes
    ----------
    status : Status
    u, v : float
        Centroid of the body's area; NaN where there is none.
    points, widths : ndarray
        Midline (POINTS, 2) and widths (POINTS,); empty where there is none.
    confidence : float
        How well the body explains the picture, 0 to 1.
    width : float
        Mean width over the middle four fifths; NaN where there is no midline.
    hidden : tuple of int
        How many points at the midline's first, and last, end were not seen but supposed.
    """

    status: Status
    u: float = float("nan")
    v: float = float("nan")
    points: Floats = field(default_factory=lambda: np.empty((0, 2)))
    widths: Floats = field(default_factory=lambda: np.empty(0))
    confidence: float = 0.0
    width: float = float("nan")
    hidden: tuple[int, int] = (0, 0)
