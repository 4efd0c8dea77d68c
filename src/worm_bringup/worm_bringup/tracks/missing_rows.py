"""Counts the rows that a table of tracks skips, by the steps of its stamps."""

import numpy as np

from worm_msgs_py import SourceEvent, SourceEventKind
from worm_msgs_py.arrays import Integers
from worm_msgs_py.units import NS_PER_S

LONG_STEP = 1.5
"""A step between two rows that is longer than so many usual ones skips a frame."""


class MissingRows:
    """Steps of a table's stamps that are longer than the usual one.

    The usual step is the median of the first rows, some ten thousand.
    """

    def __init__(self) -> None:
        self._step_ns = 0.0
        self._last_ns: int | None = None
        self._first: tuple[int, int] | None = None
        self._rows = self._gaps = self._missing = self._longest_ns = 0

    def take(self, stamp_ns: Integers) -> None:
        """Take the stamps of the next rows, ascending."""
        before = np.array([] if self._last_ns is None else [self._last_ns], dtype=np.int64)
        stamps = np.concatenate([before, stamp_ns])
        steps = np.diff(stamps)
        if not self._step_ns and len(steps):
            self._step_ns = float(np.median(steps))
        long = np.flatnonzero(steps > LONG_STEP * self._step_ns)
        if len(long):
            after = int(long[0]) + 1
            row = self._rows - len(before) + after
            self._first = self._first or (row, int(stamps[after]))
            self._gaps += len(long)
            self._missing += int(np.sum(np.rint(steps[long] / self._step_ns) - 1))
            self._longest_ns = max(self._longest_ns, int(steps[long].max()))
        self._rows += len(stamp_ns)
        self._last_ns = int(stamp_ns[-1])

    def events(self) -> list[SourceEvent]:
        """Return what is to be told; nothing where no row is missing."""
        if self._first is None:
            return []
        rate, longest_s = NS_PER_S / self._step_ns, self._longest_ns / NS_PER_S
        places = "1 place" if self._gaps == 1 else f"{self._gaps} places"
        why = (
            f"about {self._missing} rows are missing from the table, at {places}, up to "
            f"{longest_s:.3g} s: it has {self._rows}, elsewhere {rate:.4g} a second"
        )
        kind = SourceEventKind.MISSING_ROWS
        return [SourceEvent(kind, *self._first, why, count=self._missing)]
