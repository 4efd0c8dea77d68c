"""Sums over blocks of time, from which correlated series get honest errors in fixed memory."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from worm_analysis.kinematics.angular_speed import NS

Floats = NDArray[np.float64]

Columns = slice | list[int]
EVERY = slice(None)

MOST_BLOCKS = 128
FEWEST_BLOCKS = 8


class BlockSums:
    """Sums of a vector over consecutive blocks of time, at most 128 of them.

    When the trial outgrows them, neighbours are added up and blocks become twice as long: a trial
    of any length has between 64 and 128 blocks.

    Parameters
    ----------
    size : int
        Length of the vector.
    block_s : float
        Length of the first blocks.
    """

    def __init__(self, size: int, block_s: float = 5.0):
        self._rows: Floats = np.zeros((MOST_BLOCKS, size))
        self._block_ns = round(block_s * NS)
        self._start_ns: int | None = None
        self._used = 0

    def row(self, stamp_ns: int) -> Floats:
        """Return the block of this time, to be added to; times must not go back."""
        if self._start_ns is None:
            self._start_ns = stamp_ns
        index = (stamp_ns - self._start_ns) // self._block_ns
        while index >= MOST_BLOCKS:
            half = MOST_BLOCKS // 2
            self._rows[:half] = self._rows[0::2] + self._rows[1::2]
            self._rows[half:] = 0.0
            self._block_ns *= 2
            index //= 2
        self._used = max(self._used, index + 1)
        row: Floats = self._rows[index]
        return row

    def add(self, stamps_ns: NDArray[np.int64], columns: NDArray[np.intp], values: Floats) -> None:
        """Add many values at once, to the last bit as if they came one by one.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (m,)
            Times; they must not go back.
        columns : ndarray of int, shape (m, k)
            Which element of the vector each value is added to; below 0: none.
        values : ndarray, shape (m, k)
            What is added.
        """
        done = 0
        while done < len(stamps_ns):
            self.row(int(stamps_ns[done]))  # makes room for it, where the blocks are full
            assert self._start_ns is not None
            upto = int(np.searchsorted(stamps_ns, self._start_ns + MOST_BLOCKS * self._block_ns))
            index = (stamps_ns[done:upto] - self._start_ns) // self._block_ns
            wanted = columns[done:upto] >= 0
            at = (index[:, None] * self._rows.shape[1] + columns[done:upto])[wanted]
            np.add.at(self._rows.reshape(-1), at, values[done:upto][wanted])
            self._used = max(self._used, int(index[-1]) + 1)
            done = upto

    def add_rows(self, stamps_ns: NDArray[np.int64], rows: Floats) -> None:
        """Add whole vectors of whole numbers, whose sums are exact in any order.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (m,)
            Times; they must not go back.
        rows : ndarray, shape (m, size)
            A vector for each time.
        """
        done = 0
        while done < len(stamps_ns):
            self.row(int(stamps_ns[done]))
            assert self._start_ns is not None
            upto = int(np.searchsorted(stamps_ns, self._start_ns + MOST_BLOCKS * self._block_ns))
            index = (stamps_ns[done:upto] - self._start_ns) // self._block_ns
            starts = np.flatnonzero(np.diff(index, prepend=-1))
            self._rows[index[starts]] += np.add.reduceat(rows[done:upto], starts, axis=0)
            self._used = max(self._used, int(index[-1]) + 1)
            done = upto

    def total(self) -> Floats:
        """Return the sum over all blocks, shape (size,)."""
        total: Floats = self._rows[: self._used].sum(axis=0)
        return total

    def levels(self, columns: Columns = EVERY) -> Iterator[Floats]:
        """Yield the blocks, at most 64, then pairs of them, and so on, down to eight.

        Parameters
        ----------
        columns : slice or sequence of int
            The part of the vector that is wanted.

        Yields
        ------
        ndarray, shape (blocks, columns)
            Blocks in which nothing was summed are left out.
        """
        rows = self._rows[: self._used, columns]
        while True:
            if len(rows) <= MOST_BLOCKS // 2:
                filled = rows[rows.any(axis=1)]
                if len(filled) < FEWEST_BLOCKS:
                    return
                yield filled
            if len(rows) % 2:
                rows = np.vstack([rows, np.zeros_like(rows[:1])])
            rows = rows[0::2] + rows[1::2]


def jackknife_half_width(
    blocks: BlockSums,
    estimate: Callable[[Floats], Floats],
    columns: Columns = EVERY,
    level: float = 0.95,
) -> float | None:
    """Return the half width of the confidence interval of an estimate from sums.

    Each block is left out in turn. Blocks shorter than the correlation time give errors that are
    too small, so all lengths of blocks down to eight of them are tried and the largest error is
    taken.

    Parameters
    ----------
    blocks : BlockSums
        The sums.
    estimate : callable
        Maps sums of shape (m, columns) to m estimates.
    columns : slice or sequence of int
        The part of the sums that it needs.
    level : float
        Confidence.

    Returns
    -------
    float or None
        None where there are fewer than eight blocks, or an estimate without one of them is NaN.
    """

    def column(sums: Floats) -> Floats:
        return estimate(sums)[:, None]

    half = float(jackknife_half_widths(blocks, column, 1, columns, level)[0])
    return half if np.isfinite(half) else None


def jackknife_half_widths(
    blocks: BlockSums,
    estimate: Callable[[Floats], Floats],
    n_estimates: int,
    columns: Columns = EVERY,
    level: float = 0.95,
) -> Floats:
    """Return the half widths of several estimates from the same sums, shape (n_estimates,).

    As `jackknife_half_width`, with an `estimate` that maps sums of shape (m, columns) to estimates
    of shape (m, n_estimates); NaN in place of None.
    """
    widest: Floats = np.full(n_estimates, np.nan)
    unknown = np.zeros(n_estimates, dtype=np.bool_)
    for rows in blocks.levels(columns):
        left_out = estimate(rows.sum(axis=0) - rows)
        k = len(rows)
        error = np.sqrt((k - 1) / k * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
        unknown |= ~np.isfinite(error)
        widest = np.fmax(widest, float(stdtrit(k - 1, (1 + level) / 2)) * error)
    widest[unknown] = np.nan
    return widest
