"""Sums of lengths of episodes, from which exponential laws are fitted above any cut-off."""

import numpy as np

from worm_analysis.statistics.block_jackknife import BlockSums
from worm_msgs_py import Distribution
from worm_msgs_py.arrays import Floats


def next_edge(cutoff: float, bin_width: float) -> float:
    """Return the edge of a bin at which what is above a cut-off begins."""
    return float(np.ceil(cutoff / bin_width - 1e-9)) * bin_width


class ExcessSums:
    """Lengths of episodes in fine bins, each with its count and its sum, complete and censored.

    From these the maximum-likelihood mean of an exponential law that is cut off on the left can be
    had for any cut-off at a bin's edge, exactly, after the trial.

    Parameters
    ----------
    bin_width : float
        Width of a bin, in the unit of the lengths.
    n_bins : int
        Longer episodes are in the last bin, and their full length in its sum.
    """

    def __init__(self, bin_width: float, n_bins: int):
        self._bin_width = bin_width
        self._n = np.zeros((2, n_bins), dtype=np.int64)
        self._sum = np.zeros((2, n_bins))

    def push(self, length: float, *, complete: bool) -> None:
        """Take an episode; one that was cut short is censored: longer than what was seen."""
        bin_ = min(int(length / self._bin_width), self._n.shape[1] - 1)
        self._n[int(complete), bin_] += 1
        self._sum[int(complete), bin_] += length

    def above(self, cutoff: float) -> tuple[int, float, float]:
        """Return what the likelihood needs.

        Returns
        -------
        n : int
            Complete episodes that are at least as long as the cut-off.
        excess : float
            Sum of what all episodes, censored ones too, are longer than the cut-off.
        cutoff : float
            The cut-off that was used: the next edge of a bin.
        """
        first = min(int(np.ceil(cutoff / self._bin_width - 1e-9)), self._n.shape[1] - 1)
        edge = first * self._bin_width
        n, total = self._n[:, first:].sum(axis=1), self._sum[:, first:].sum()
        return int(n[1]), float(total - n.sum() * edge), edge

    def row(self, cutoff: float) -> Floats:
        """Return what is above a cut-off, shape (1, 4).

        Complete episodes above it, the sum of what all above it exceed it by, complete episodes of
        any length, and the length of all episodes.
        """
        n, excess, _ = self.above(cutoff)
        return np.array([[n, excess, self._n[1].sum(), self._sum.sum()]], dtype=np.float64)

    def excess_histogram(self, cutoff: float) -> Floats:
        """Return the counts of complete episodes in fine bins from the cut-off on, and their sum.

        Returns
        -------
        ndarray, shape (1, n_bins + 1)
            The first bin begins at the cut-off; last, the sum of what they are longer than it.
        """
        first = min(int(np.ceil(cutoff / self._bin_width - 1e-9)), self._n.shape[1] - 1)
        counts = self._n[1, first:]
        row = np.zeros((1, self._n.shape[1] + 1))
        row[0, : len(counts)] = counts
        excess = self._sum[1, first:].sum() - counts.sum() * first * self._bin_width
        row[0, -1] = excess
        return row

    @property
    def bin_width(self) -> float:
        """Width of a fine bin."""
        return self._bin_width

    def distribution(
        self, name: str, bin_width: float, longest: float, unit: str = "m"
    ) -> Distribution:
        """Return the complete episodes in bins for people, up to a longest one."""
        per_bin, bins = round(bin_width / self._bin_width), round(longest / bin_width)
        counts = self._n[1, : per_bin * bins].reshape(bins, per_bin).sum(axis=1)
        edges = np.linspace(0.0, bins * bin_width, bins + 1)
        return Distribution(name, unit, edges, counts.astype(np.int64))


class ExcessBlocks:
    """The same sums by blocks of time, for the interval of a mean under a worm that changes.

    Parameters
    ----------
    bin_width : float
        Width of a bin, in the unit of the lengths.
    n_bins : int
        Bins; all that is longer is in the last one. A cut-off beyond it has no interval.
    """

    def __init__(self, bin_width: float, n_bins: int):
        self._bin_width = bin_width
        self._bins = n_bins
        self._blocks = BlockSums(3 * n_bins)

    def push(self, stamp_ns: int, length: float, *, complete: bool) -> None:
        """Take an episode with the stamp of its start; they come in order."""
        bin_ = min(int(length / self._bin_width), self._bins - 1)
        row = self._blocks.row(stamp_ns)
        row[bin_] += complete
        row[self._bins + bin_] += 1.0
        row[2 * self._bins + bin_] += length

    def rows(self, cutoff: float) -> Floats | None:
        """Return what is above a cut-off by blocks of time.

        Returns
        -------
        ndarray, shape (blocks, 4), or None
            As `ExcessSums.row`; None where the cut-off is beyond the last bin.
        """
        first = int(np.ceil(cutoff / self._bin_width - 1e-9))
        if first >= self._bins:
            return None
        complete, everyone, length = np.split(self._blocks.rows(), 3, axis=1)
        excess = length[:, first:].sum(axis=1)
        excess -= first * self._bin_width * everyone[:, first:].sum(axis=1)
        return np.stack(
            [complete[:, first:].sum(axis=1), excess, complete.sum(axis=1), length.sum(axis=1)],
            axis=1,
        )
