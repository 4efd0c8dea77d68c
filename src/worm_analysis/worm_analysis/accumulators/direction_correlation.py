"""The sums behind C_θ(t) = ⟨sgn θ̇_h(t + t₀) · sgn θ̇_h(t₀)⟩, while frames come in."""

import numpy as np

from worm_analysis.accumulators.direction_bridges import DirectionBridge
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.units import NS_PER_S

CELLS_AT_ONCE = 1024
"""Bounds the memory of the table of pairs."""


def lag_grid(
    max_lag_s: float, fine_lag_s: float, fine_step_s: float, coarse_step_s: float
) -> Integers:
    """Return the lags as multiples of the fine step, ascending from 0."""
    last = round(max_lag_s / fine_step_s)
    ratio = round(coarse_step_s / fine_step_s)
    fine = np.arange(0, min(last, round(fine_lag_s / fine_step_s)) + 1)
    coarse = np.arange(0, last + 1, ratio)
    return np.union1d(fine, coarse).astype(np.int64)


class SignCorrelation:
    """Autocorrelation of a sign over time, one pass, in memory that does not grow.

    Time since the first frame is cut into cells of one fine step; the first frame with a direction
    stands for its cell. Pairs of cells are made within one visit only, over gaps that are bridged
    but over no others: the past cells are forgotten at every break. Sums are kept by blocks of time
    for the error.

    Parameters
    ----------
    lags : ndarray of int64, shape (n,)
        Lags in cells, ascending from 0.
    step_s : float
        Length of a cell.
    """

    def __init__(self, lags: Integers, step_s: float):
        self._lags = lags
        self._step_ns = round(step_s * NS_PER_S)
        self._start_ns: int | None = None
        self._cell = -1
        self._memory = int(lags[-1])
        self._past = np.zeros((2, self._memory))
        self._blocks = BlockSums(2 * len(lags))

    @property
    def lag_s(self) -> Floats:
        """The lags, s."""
        return np.asarray(self._lags * (self._step_ns / NS_PER_S), dtype=np.float64)

    def add(self, stamps_ns: Integers, speed: Floats) -> None:
        """Take frames of an unbroken stretch.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (m,)
            Ascending, and later than all before.
        speed : ndarray, shape (m,)
            Only the signs count; NaN is a frame without a direction.
        """
        known = np.isfinite(speed)
        stamps_ns, speed = stamps_ns[known], speed[known]
        if not len(stamps_ns):
            return
        if self._start_ns is None:
            self._start_ns = int(stamps_ns[0])
        cells = (stamps_ns - self._start_ns) // self._step_ns
        new = np.diff(cells, prepend=self._cell) > 0
        cells, stamps_ns, signs = cells[new], stamps_ns[new], np.sign(speed[new])
        apart = np.flatnonzero(np.diff(cells, prepend=self._cell) > self._memory)
        cuts = np.union1d(apart, np.arange(0, len(cells), CELLS_AT_ONCE))
        for part in np.split(np.arange(len(cells)), cuts):
            if len(part):
                self._add_cells(cells[part], stamps_ns[part], signs[part])

    def bridge(self, gap: DirectionBridge) -> None:
        """Fill the cells of a gap whose sides are known; a reversal is put into its middle."""
        if self._start_ns is None:
            return
        last = (gap.end_ns - self._start_ns) // self._step_ns
        cells = np.arange(self._cell + 1, last, dtype=np.int64)
        stamps_ns = self._start_ns + cells * self._step_ns
        middle_ns = (gap.start_ns + gap.end_ns - self._step_ns) // 2
        signs = np.where(stamps_ns < middle_ns, gap.before, gap.after)
        for start in range(0, len(cells), CELLS_AT_ONCE):
            part = slice(start, start + CELLS_AT_ONCE)
            self._add_cells(cells[part], stamps_ns[part], signs[part])

    def break_off(self) -> None:
        """Say that what follows is not connected: a gap, or another visit."""
        self._past[:] = 0.0

    def _add_cells(self, cells: Integers, stamps_ns: Integers, signs: Floats) -> None:
        """Pair cells with those before; rows of `_past` are signs, and 1 where there is one."""
        first, memory = int(cells[0]), self._memory
        dense = np.zeros((2, memory + int(cells[-1]) - first + 1))
        missing = first - self._cell - 1
        if missing < memory:
            dense[:, : memory - missing] = self._past[:, missing:]
        here = cells - first + memory
        dense[0, here], dense[1, here] = signs, 1.0
        before = here[:, None] - self._lags
        pairs = np.hstack([dense[0, before] * signs[:, None], dense[1, before]])
        self._blocks.add_rows(stamps_ns, pairs)
        self._past = dense[:, dense.shape[1] - memory :].copy()
        self._cell = int(cells[-1])

    def sums(self) -> dict[str, Floats]:
        """Return the number of pairs at each lag, then the sums of their products, by blocks."""
        products, pairs = np.split(self._blocks.rows(), 2, axis=1)
        return {"c_theta": np.hstack([pairs, products])}
