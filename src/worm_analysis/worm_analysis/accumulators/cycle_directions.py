"""Reversals from one cycle of slide and hop to the next, also over gaps in the track."""

from dataclasses import dataclass
from math import nan

import numpy as np

from worm_analysis.events.contacts import ClosedEpisode
from worm_msgs_py import EpisodeKind
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import NS_PER_S


@dataclass(slots=True)
class _Cycle:
    """A contact and the excursion after it, or what was seen of them."""

    start_ns: int
    start_seen: bool
    turn_rad: float = 0.0


class CycleDirections:
    """Counts cycles that go the other way than the one before.

    Neighbours in an unbroken track are a pair. Where a gap is bridged, what was seen of the cycles
    at its edges counts as cycles too, each a pair with its neighbour on its own side, and the two
    are compared across the gap.

    Attributes
    ----------
    pairs : ndarray, shape (2,)
        Pairs of successive cycles, and those that differ in direction.
    gaps : ndarray, shape (3,)
        Gaps with a direction on both sides, those across which it differs, and their length, s.
    whole : ndarray, shape (2,)
        Whole cycles, and the time that they took, s.
    """

    def __init__(self) -> None:
        self.pairs, self.gaps, self.whole = np.zeros(2), np.zeros(3), np.zeros(2)
        self._cycle: _Cycle | None = None
        self._last = 0
        self._before_gap = (0, nan)

    def push(self, closed: ClosedEpisode, gap_s: float = nan) -> None:
        """Add an episode.

        Parameters
        ----------
        closed : ClosedEpisode
            In the order in which they closed.
        gap_s : float
            Where the episode was cut by a gap that is bridged, its length; NaN elsewhere.
        """
        in_contact = closed.episode.kind is EpisodeKind.CONTACT
        if in_contact or self._cycle is None:
            start_seen = in_contact and closed.start_seen
            self._cycle = _Cycle(closed.episode.start_ns, start_seen)
        self._cycle.turn_rad += closed.turn_rad
        if not in_contact and (closed.episode.complete or not closed.cut):
            self._end(self._cycle, closed.episode.end_ns)
        elif closed.cut and (gap_s == gap_s or not self._cycle.start_seen):
            self._end(self._cycle, None)
        if closed.cut:
            self._before_gap = (self._last if gap_s == gap_s else 0, gap_s)
            self._last = 0
        if closed.cut or not in_contact:
            self._cycle = None

    def _end(self, cycle: _Cycle, end_ns: int | None) -> None:
        """Compare a cycle with the one before it; `end_ns` is None where a gap cut it."""
        direction = (cycle.turn_rad > 0) - (cycle.turn_rad < 0)
        before, gap_s = self._before_gap
        if not cycle.start_seen and not before:
            self._last = 0 if end_ns is not None else direction
            return
        if not cycle.start_seen:
            self._before_gap = (0, nan)
            if direction:
                self.gaps += (1, direction != before, gap_s)
        elif self._last and direction:
            self.pairs += (1, direction != self._last)
        if cycle.start_seen and end_ns is not None:
            self.whole += (1, (end_ns - cycle.start_ns) / NS_PER_S)
        self._last = direction

    def sums(self) -> dict[str, Floats]:
        """Return the counts of pairs, and of gaps with what tells how many cycles they hide."""
        return {
            "reversal_per_cycle": self.pairs[None].copy(),
            "reversal_per_cycle_gaps": np.concatenate([self.gaps, self.whole])[None],
        }
