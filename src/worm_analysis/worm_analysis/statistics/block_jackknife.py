"""Sums over blocks of time, from which correlated series get honest errors in fixed memory."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import nan
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.units import NS_PER_S

Value = TypeVar("Value")

MOST_BLOCKS = 128
MOST_UNITS = MOST_BLOCKS // 2
"""Of time, while a trial goes on and in its `sums.parquet`: memory stays the same."""


@dataclass(frozen=True, slots=True)
class JackknifeSettings:
    """How many parts tell an error.

    Attributes
    ----------
    fewest_blocks : int
        Fewer parts tell nothing of an error.
    fewest_trials : int
        Fewer trials cannot say by how much trials differ.
    """

    fewest_blocks: int = 8
    fewest_trials: int = 5


JACKKNIFE = JackknifeSettings()


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
        self._block_ns = round(block_s * NS_PER_S)
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

    def add(self, stamps_ns: Integers, columns: NDArray[np.intp], values: Floats) -> None:
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

    def add_rows(self, stamps_ns: Integers, rows: Floats) -> None:
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

    def total(self, columns: slice) -> Floats:
        """Return the sum of some elements of the vector over all blocks."""
        total: Floats = self._rows[: self._used, columns].sum(axis=0)
        return total

    def rows(self) -> Floats:
        """Return a copy of the blocks, 1 to 64 of them, shape (blocks, size)."""
        rows = self._rows[: max(1, self._used)]
        return rows.copy() if len(rows) <= MOST_UNITS else _in_pairs(rows)


class Units:
    """Parts of the data that can be left out in turn: blocks of time, and whole trials.

    The largest error over all sizes of parts is the honest one (`jackknife_half_width`): blocks of
    time allow for frames that follow each other, whole trials for worms that differ.

    Parameters
    ----------
    trials : sequence of ndarray, each of shape (blocks, size)
        The sums of each trial by blocks of time; one block where they were not kept by time.
    settings : JackknifeSettings
    """

    def __init__(self, trials: Sequence[Floats], settings: JackknifeSettings = JACKKNIFE):
        self.settings = settings
        # In one order of memory: sums are then the same to the last bit, read or just made.
        self._trials = [np.ascontiguousarray(rows) for rows in trials]
        self._total: Floats | None = None
        self._levels: list[Floats] | None = None
        self._without: tuple[Floats, Integers] | None = None
        self._found: dict[str, Any] = {}

    def once(self, name: str, find: Callable[[], Value]) -> Value:
        """Return what follows from these sums and several numbers need, found the first time."""
        if name not in self._found:
            self._found[name] = find()
        found: Value = self._found[name]
        return found

    def total(self) -> Floats:
        """Return the sum over everything, shape (size,)."""
        if self._total is None:
            sums = [rows.sum(axis=0) for rows in self._trials]
            self._total = sums[0] if len(sums) == 1 else np.sum(sums, axis=0)
        return self._total

    def levels(self) -> list[Floats]:
        """Return the parts: blocks of time, pairs of them, and so on, and at last whole trials.

        Each trial's blocks are added up in pairs down to eight of them; a trial of fewer is one
        part. Whole trials come where there are five or more.

        Returns
        -------
        list of ndarray, shape (parts, size)
            Parts in which nothing was summed are left out.
        """
        if self._levels is None:
            self._levels = list(self._each_level())
        return self._levels

    def without_one(self) -> tuple[Floats, Integers]:
        """Return the sums over all parts but one, for each part of each level in turn.

        Returns
        -------
        sums : ndarray, shape (parts of all levels, size)
            Together: one estimate of many rows costs no more than one of a few.
        parts : ndarray of int, shape (levels,)
            How many of them each level has.
        """
        if self._without is None:
            levels = self.levels()
            parts = np.array([len(part) for part in levels], dtype=np.int64)
            rows = np.empty((int(parts.sum()), self.total().shape[0]))
            upto = 0
            for part in levels:
                first, upto = upto, upto + len(part)
                np.subtract(part.sum(axis=0), part, out=rows[first:upto])
            self._without = rows, parts
        return self._without

    def _each_level(self) -> Iterator[Floats]:
        if len(self._trials) == 1:
            yield from _levels_of_one(self._trials[0], self.settings.fewest_blocks)
            return
        fewest = self.settings.fewest_blocks
        trials = [rows for rows in self._trials if rows.any()]
        whole = [rows.sum(axis=0, keepdims=True) for rows in trials]
        rows = list(trials)
        while True:
            filled = [_filled(part) for part in rows]
            enough = [len(part) >= fewest for part in filled]
            if not any(enough):
                break
            choices = zip(filled, enough, whole, strict=True)
            parts = [part if many else one for part, many, one in choices]
            yield parts[0] if len(parts) == 1 else np.vstack(parts)
            if max(map(len, rows)) < 2 * fewest - 1:
                break
            rows = [_in_pairs(part) for part in rows]
        if len(whole) >= self.settings.fewest_trials:
            units = np.vstack(whole)
            while len(units) > MOST_UNITS:
                units = _in_pairs(units)
            yield units


def _levels_of_one(rows: Floats, fewest: int) -> Iterator[Floats]:
    """Return the levels of one trial alone."""
    while len(filled := _filled(rows)) >= fewest:
        yield filled
        if len(rows) < 2 * fewest - 1:
            break
        rows = _in_pairs(rows)


def _filled(rows: Floats) -> Floats:
    """Return the rows in which something was summed."""
    full = rows.any(axis=1)
    return rows if full.all() else rows[full]


def _in_pairs(rows: Floats) -> Floats:
    """Return neighbouring rows added up; an odd last one stays alone."""
    if len(rows) % 2 == 0:
        even: Floats = rows[0::2] + rows[1::2]
        return even
    pairs: Floats = rows[0::2].copy()
    pairs[:-1] += rows[1::2]
    return pairs


def jackknife_half_width(
    units: Units, estimate: Callable[[Floats], Floats], level: float = 0.95
) -> float:
    """Return the half width of the confidence interval of an estimate from sums.

    Each part is left out in turn. Blocks shorter than the correlation time give errors that are
    too small, so all sizes of parts are tried and the largest error is taken.

    Parameters
    ----------
    units : Units
        The sums.
    estimate : callable
        Maps sums of shape (m, size) to m estimates.
    level : float
        Confidence.

    Returns
    -------
    float
        NaN where there are too few parts, or an estimate without one of them is NaN.
    """
    if not units.levels():
        return nan
    rows, parts = units.without_one()
    k, first, shrink, quantile = _of_parts(tuple(parts.tolist()), level)
    without_one = estimate(rows)
    off = without_one - np.repeat(np.add.reduceat(without_one, first) / k, k)
    errors = np.sqrt(shrink * np.add.reduceat(off * off, first))
    half_widths = quantile * errors
    return float(half_widths.max()) if np.isfinite(half_widths).all() else nan


@lru_cache(maxsize=64)
def _of_parts(parts: tuple[int, ...], level: float) -> tuple[Integers, Integers, Floats, Floats]:
    """Return what the number of parts of each level alone says: as few lists come in all trials.

    The numbers, where each level begins, (k − 1)/k, and Student's quantile.
    """
    k = np.array(parts, dtype=np.int64)
    first = np.concatenate([[0], np.cumsum(k)[:-1]]).astype(np.int64)
    quantile: Floats = np.asarray(stdtrit(k - 1, (1 + level) / 2), dtype=np.float64)
    return k, first, (k - 1) / k, quantile
