"""A median over any number of values in fixed memory, the same for the same values in any order."""

from math import isfinite

import numpy as np

from worm_msgs_py.arrays import Integers


class RunningMedian:
    """Median of all values so far, from a histogram with fixed bins.

    Parameters
    ----------
    bin_width : float
        Resolution; within a bin the median is interpolated.
    n_bins : int
        Values at or above ``n_bins·bin_width`` count in the last bin.
    """

    def __init__(self, bin_width: float, n_bins: int):
        self._bin_width = bin_width
        self._counts = [0] * n_bins
        self._n = 0
        self._bin = 0
        self._below = 0

    @property
    def n(self) -> int:
        """Number of values."""
        return self._n

    @property
    def counts(self) -> Integers:
        """Number of values in each bin."""
        return np.array(self._counts, dtype=np.int64)

    def push(self, value: float) -> None:
        """Take a value; NaN, and what is below zero, is left out."""
        if not isfinite(value) or value < 0:
            return
        index = min(int(value / self._bin_width), len(self._counts) - 1)
        self._counts[index] += 1
        self._n += 1
        if index < self._bin:
            self._below += 1
        half = self._n / 2
        while self._below >= half and self._bin > 0:
            self._bin -= 1
            self._below -= self._counts[self._bin]
        while self._below + self._counts[self._bin] < half:
            self._below += self._counts[self._bin]
            self._bin += 1

    def value(self) -> float:
        """Return the median; NaN before the first value."""
        if self._n == 0:
            return float("nan")
        inside = (self._n / 2 - self._below) / self._counts[self._bin]
        return (self._bin + inside) * self._bin_width
