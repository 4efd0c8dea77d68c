"""Histograms with fixed bins."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def bin_centres(edges: Floats) -> Floats:
    """Return the middle of each bin."""
    centres: Floats = (edges[1:] + edges[:-1]) / 2
    return centres
