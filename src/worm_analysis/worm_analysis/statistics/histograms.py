"""Histograms with fixed bins."""

from worm_msgs_py.arrays import Floats


def bin_centres(edges: Floats) -> Floats:
    """Return the middle of each bin."""
    centres: Floats = (edges[1:] + edges[:-1]) / 2
    return centres
