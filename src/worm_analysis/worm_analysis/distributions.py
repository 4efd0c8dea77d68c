"""Histograms with fixed bins that grow while frames and episodes come in."""

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py import Distribution

Floats = NDArray[np.float64]


class ExcessSums:
    """Lengths of episodes in fine bins, each with its count and its sum, complete and censored.

    From these the maximum-likelihood mean of an exponential law that is cut off on the left can be
    had for any cut-off at a bin's edge, exactly, after the trial.

    Parameters
    ----------
    bin_m : float
        Width of a bin.
    n_bins : int
        Longer episodes are in the last bin, and their full length in its sum.
    """

    def __init__(self, bin_m: float, n_bins: int):
        self._bin_m = bin_m
        self._n = np.zeros((2, n_bins), dtype=np.int64)
        self._sum = np.zeros((2, n_bins))

    def push(self, length_m: float, *, complete: bool) -> None:
        """Take an episode; one that was cut short is censored: longer than what was seen."""
        bin_ = min(int(length_m / self._bin_m), self._n.shape[1] - 1)
        self._n[int(complete), bin_] += 1
        self._sum[int(complete), bin_] += length_m

    def above(self, cutoff_m: float) -> tuple[int, float, float]:
        """Return what the likelihood needs.

        Returns
        -------
        n : int
            Complete episodes that are at least as long as the cut-off.
        excess_m : float
            Sum of what all episodes, censored ones too, are longer than the cut-off.
        cutoff_m : float
            The cut-off that was used: the next edge of a bin.
        """
        first = min(int(np.ceil(cutoff_m / self._bin_m - 1e-9)), self._n.shape[1] - 1)
        edge_m = first * self._bin_m
        n, total = self._n[:, first:].sum(axis=1), self._sum[:, first:].sum()
        return int(n[1]), float(total - n.sum() * edge_m), edge_m

    def distribution(self, name: str, bin_m: float, longest_m: float) -> Distribution:
        """Return the complete episodes in bins for people, up to a longest one."""
        per_bin, bins = round(bin_m / self._bin_m), round(longest_m / bin_m)
        counts = self._n[1, : per_bin * bins].reshape(bins, per_bin).sum(axis=1)
        edges = np.linspace(0.0, bins * bin_m, bins + 1)
        return Distribution(name, "m", edges, counts.astype(np.int64))


def bin_centres(edges: Floats) -> Floats:
    """Return the middle of each bin."""
    centres: Floats = (edges[1:] + edges[:-1]) / 2
    return centres
