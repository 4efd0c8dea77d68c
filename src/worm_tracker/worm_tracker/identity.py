"""Which end is the head: a running log-odds from how the body moves."""

from dataclasses import dataclass
from enum import StrEnum
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from worm_tracker.known import LEAP_LENGTHS, LEAP_WIDTHS
from worm_tracker.outline import as_complex, tangents

Floats = NDArray[np.float64]

ODDS_PER_LENGTH = 6.0
"""Log-odds gained per body length of motion along the body: a worm moves head-first."""
MOST_ODDS = 12.0
"""Cap, so that two lengths the other way undo any belief."""
MOST_STEP = 0.25
"""Most that a single step counts for, in lengths: a jump is an error, not a stride."""
MOST_ACTIVITY_ODDS = 1.0
"""Most that the liveliness of an end can add: the head swings more than the tail."""
ACTIVITY_FRAMES = 100.0
"""Memory of the liveliness."""
CERTAIN_ODDS = 3.0
"""Beyond this (95 %) the head is taken as decided."""
LEAP_RELIABILITY = 0.75
"""The most that a link with such a leap is trusted: the certainty falls, whatever it was."""
SLIGHT_ODDS = 0.01
"""The least that an operator's correction still counts for, after links in doubt."""
LINK_WIDTHS = 0.15
"""Typical distance, in widths, of a body's points from where they were a frame before."""


class ExchangeKind(StrEnum):
    """Who exchanged head and tail."""

    SWAP = "swap"
    """The tracker: from here on it takes the other end for the head than it did before."""
    CORRECTION = "correction"
    """An operator."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """From one frame on, the end is the head that was the tail before.

    Attributes
    ----------
    kind : ExchangeKind
    frame, stamp_ns : int
        The first frame to which it applies.
    head_certainty : float
        How sure the new head is at that frame, 0.5 to 1.
    """

    kind: ExchangeKind
    frame: int
    stamp_ns: int
    head_certainty: float


@dataclass(frozen=True, eq=False, slots=True)
class Linked:
    """A midline joined to those before it.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        In the order of the chain, which is the same for all linked midlines.
    reliability : float
        Probability, 0.5 to 1, that the link to the one before is not the wrong way round.
    flipped : bool
        Whether the points were turned round to get there.
    """

    points: Floats
    reliability: float
    flipped: bool


class HeadTail:
    """Carries the order of the ends through time, and the belief which one is the head.

    Attributes
    ----------
    log_odds : float
        That the chain's first end is the head; its sign is the decision.
    swaps : int
        Times that a decision, once certain, was turned into its contrary.
    """

    def __init__(self) -> None:
        self._motion = 0.0
        self._activity = np.zeros(2)
        self._seen = 0
        self._last: Floats | None = None
        self._gap = 1
        self._decided = 0
        self._corrected = False
        self.swaps = 0

    @property
    def log_odds(self) -> float:
        """Log-odds that the first end is the head, from motion and liveliness."""
        if self._corrected or self._seen <= ACTIVITY_FRAMES / 4:
            return self._motion
        first, last = self._activity.tolist()
        lively = log((first + 1e-6) / (last + 1e-6)) / 2
        return self._motion + min(max(lively, -MOST_ACTIVITY_ODDS), MOST_ACTIVITY_ODDS)

    @property
    def begun(self) -> bool:
        """Whether there is a body to speak of."""
        return self._last is not None

    @property
    def certain(self) -> bool:
        """Whether the head is decided."""
        return abs(self.log_odds) >= CERTAIN_ODDS

    def correct(self) -> None:
        """Exchange head and tail on an operator's word, for good.

        From now on motion and liveliness may confirm the head, after a link that left it in doubt,
        but never exchange it again.
        """
        sign = -1.0 if self.log_odds >= 0 else 1.0
        self._motion = sign * MOST_ODDS
        self._corrected = True
        self._decided = int(sign)

    def miss(self) -> None:
        """Note a frame without a midline: the next link is less sure."""
        self._gap += 1

    def push(self, points: Floats, width: float) -> Linked:
        """Join the next midline to the chain and weigh what it says.

        Parameters
        ----------
        points : ndarray, shape (n, 2)
            Points at equal steps from tip to tip, either way round.
        width : float
            The body's width, pixels.
        """
        if self._last is None:
            self._last = points
            return Linked(points, 1.0, False)
        straight = _distance(points, self._last)
        turned = _distance(points[::-1], self._last)
        flipped = turned < straight
        points = points[::-1] if flipped else points
        near, far = sorted((straight, turned))
        # Where even the better way is far off, only the ratio of the two says anything.
        spread = (LINK_WIDTHS * width) ** 2 * self._gap + near**2
        reliability = 1 / (1 + exp(-min((far**2 - near**2) / (2 * spread), 30.0)))
        if self._leaps(points, width):
            reliability = min(reliability, LEAP_RELIABILITY)
        self._motion = self._bounded(_dilute(self._motion, float(reliability)))
        if self._gap <= 3:
            self._weigh(points, self._last, 2 * float(reliability) - 1)
        self._last, self._gap = points, 1
        self._note_swap()
        return Linked(points, float(reliability), bool(flipped))

    def _leaps(self, points: Floats, width: float) -> bool:
        """Tell whether an end is farther from where it was than an end can have got."""
        if self._last is None:
            return False
        line = as_complex(self._last)
        far = max(LEAP_WIDTHS * width, LEAP_LENGTHS * float(np.abs(line[1:] - line[:-1]).sum()))
        moved = np.abs(as_complex(points[[0, -1]]) - line[[0, -1]])
        return float(moved.max()) > far * self._gap

    def _weigh(self, points: Floats, last: Floats, trust: float) -> None:
        """Add what the motion between two midlines says, as far as their link is trusted."""
        line = as_complex(last)
        length = float(np.abs(line[1:] - line[:-1]).sum())
        # Along the tangent towards the first end, and sideways.
        moved = (as_complex(points) - line) * -tangents(line).conj()
        n = len(points)
        forward = float(moved.real[n // 8 : n - n // 8].mean())
        part = min(max(forward / length, -MOST_STEP), MOST_STEP)
        self._motion += trust * ODDS_PER_LENGTH * part
        self._motion = self._bounded(self._motion)
        sideways = moved.imag
        k = max(1, n // 10)
        ends = np.array([sideways[:k] @ sideways[:k], sideways[-k:] @ sideways[-k:]]) / k
        self._activity += (ends - self._activity) / min(self._seen + 1.0, ACTIVITY_FRAMES)
        self._seen += 1

    def _bounded(self, odds: float) -> float:
        """Return log-odds within their limits, on the side that an operator has chosen."""
        low, high = -MOST_ODDS, MOST_ODDS
        if self._corrected:
            low, high = (SLIGHT_ODDS, high) if self._decided > 0 else (low, -SLIGHT_ODDS)
        return min(max(odds, low), high)

    def _note_swap(self) -> None:
        if not self.certain:
            return
        sign = 1 if self.log_odds > 0 else -1
        if self._decided == -sign:
            self.swaps += 1
        self._decided = sign


def certainty(log_odds: float) -> float:
    """Return the probability of the likelier way round, 0.5 to 1."""
    return 1 / (1 + exp(-abs(log_odds)))


def chained(certainty_after: float, reliability: float) -> float:
    """Return the certainty before a link from that after it."""
    return certainty_after * reliability + (1 - certainty_after) * (1 - reliability)


def _dilute(log_odds: float, reliability: float) -> float:
    """Return the log-odds after a link that may be the wrong way round."""
    p = chained(1 / (1 + exp(-log_odds)), reliability)
    return log(p / (1 - p))


def _distance(a: Floats, b: Floats) -> float:
    """Return the mean distance of corresponding points."""
    return float(np.abs(as_complex(a - b)).mean())
