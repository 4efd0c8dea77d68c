"""Which end is the head: a running log-odds from how the body moves.

Links between frames carry it on. A link that may be the wrong way round takes its certainty away;
how the ends look, before and after, can give it back.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from worm_tracker.body_model import LEAP_LENGTHS, LEAP_WIDTHS
from worm_tracker.head_tail_appearance import Appearance
from worm_tracker.midline.contour_midline import arc, as_complex, as_points, tangents

Floats = NDArray[np.float64]

ODDS_PER_LENGTH = 6.0
"""Log-odds gained per body length of motion along the body: a worm moves head-first."""
MOST_ODDS = 12.0
"""Cap, so that two lengths the other way undo any belief."""
MOST_STEP = 0.25
"""Most that a single step counts for, in lengths: a jump is an error, not a stride."""
MOST_ACTIVITY_ODDS = 1.0
"""Most that the liveliness of an end can add: the head swings more than the tail."""
MOST_LOOKS_ODDS = 1.0
"""Most that the looks of an end can add: it looks as the head did while that was certain."""
ACTIVITY_FRAMES = 100.0
"""Memory of the liveliness."""
CERTAIN_ODDS = 3.0
"""Beyond this (95 %) the head is taken as decided."""
NEARLY_A_LEAP = 0.85
"""Part of the farthest way of an end from which on it casts doubt on the link."""
LEAP_RELIABILITY = 0.75
"""The most that a link with such a leap is trusted: the certainty falls, whatever it was."""
SLIGHT_ODDS = 0.01
"""The least that an operator's correction still counts for, after links in doubt."""
LINK_WIDTHS = 0.15
"""Typical distance, in widths, of a body's points from where they were a frame before."""
SPEED_FRAMES = 30.0
"""Memory of how far a body's points move in a frame."""
POOR = 0.8
"""A body that explains the picture less well than this does not tell where the ends are."""
NEARLY_SURE = 0.9999
"""A link less reliable than this is looked at again, the body slid along itself."""
DOUBTFUL = 0.99
"""A link less reliable than this is decided by how the ends look, if they differ."""
LOOKS = 15
"""Looks at the ends after such a link, the mean of which decides."""


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


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the ends' looks say of a link that was in doubt.

    Attributes
    ----------
    frames : int
        How many frames before this one it led to.
    wrong : bool
        Whether it was the wrong way round: what came after it is turned round.
    reliability : float
        Probability, 0.5 to 1, of that.
    """

    frames: int
    wrong: bool
    reliability: float


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
    verdict : Verdict or None
        On an earlier link, where this frame's looks have decided it.
    """

    points: Floats
    reliability: float
    flipped: bool
    verdict: "Verdict | None" = None


@dataclass(eq=False, slots=True)
class _Doubt:
    """A link that may be the wrong way round, and what has been seen since.

    Attributes
    ----------
    before : float
        Log-odds before the link, in the order from before it.
    same : float
        Log-odds that the order is the same after it, by where the body was.
    since : float
        Log-odds from motion after it, in the order from after it.
    marks : ndarray
        Sum of the marks seen after it.
    looks : int
        How many.
    worst : float
        Reliability of the least reliable of the links in doubt.
    frames : int
        How many frames ago it was.
    """

    before: float
    same: float
    worst: float
    frames: int = 0
    since: float = 0.0
    marks: Floats = field(default_factory=lambda: np.zeros(1))
    looks: int = 0


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
        self._unsure = 0
        self._speed = 0.0
        self._forward = 0.0
        self._looks = Appearance()
        self._head = Appearance()
        self._doubt: _Doubt | None = None
        self._decided = 0
        self._corrected = False
        self.swaps = 0

    @property
    def log_odds(self) -> float:
        """Log-odds that the first end is the head, from motion, liveliness and looks."""
        return self._moved + self._looked

    @property
    def _moved(self) -> float:
        """Log-odds from motion and liveliness."""
        if self._corrected or self._seen <= ACTIVITY_FRAMES / 4:
            return self._motion
        first, last = self._activity.tolist()
        lively = log((first + 1e-6) / (last + 1e-6)) / 2
        return self._motion + min(max(lively, -MOST_ACTIVITY_ODDS), MOST_ACTIVITY_ODDS)

    @property
    def _looked(self) -> float:
        """Log-odds from how the head looked while it was certain."""
        if self._corrected or self._doubt is not None or self._looks.frames < LOOKS:
            return 0.0
        told = self._head.log_odds(self._looks.mean)
        return min(max(told, -MOST_LOOKS_ODDS), MOST_LOOKS_ODDS)

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
        self._doubt = None
        self._corrected = True
        self._decided = int(sign)

    def miss(self) -> None:
        """Note a frame without a midline: the next link is less sure."""
        self._gap += 1
        if self._doubt is not None:
            self._doubt.frames += 1

    def push(
        self,
        points: Floats,
        width: float,
        marks: Floats | None = None,
        confidence: float = 1.0,
    ) -> Linked:
        """Join the next midline to the chain and weigh what it says.

        Parameters
        ----------
        points : ndarray, shape (n, 2)
            Points at equal steps from tip to tip, either way round.
        width : float
            The body's width, pixels.
        marks : ndarray, shape (2 BINS,), or None
            How the first half differs in looks from the last one, see `marks_of`; None where the
            body lies on itself.
        confidence : float
            How well the body explains the picture, 0 to 1.
        """
        if self._last is None:
            self._last = points
            self._look(marks)
            return Linked(points, 1.0, False)
        straight = _distance(points, self._last)
        turned = _distance(points[::-1], self._last)
        flipped = turned < straight
        points = points[::-1] if flipped else points
        near, far = sorted((straight, turned))
        frames = self._gap + self._unsure
        if frames == 1:
            self._speed += (near - self._speed) / SPEED_FRAMES
        # A body not seen for long may be anywhere. Where even the better way is far off, only the
        # ratio of the two says anything.
        gone = self._speed * (frames - 1)
        spread = (LINK_WIDTHS * width) ** 2 * self._gap + gone**2 + near**2
        reliability = 1 / (1 + exp(-min((far**2 - near**2) / (2 * spread), 30.0)))
        if frames == 1 and reliability < NEARLY_SURE:
            # In a coil the turns lie near each other: what counts is the way from where it slid to.
            near = min(near, _distance(points, _slid(self._last, self._forward)))
            spread = (LINK_WIDTHS * width) ** 2 + near**2
            reliability = 1 / (1 + exp(-min((far**2 - near**2) / (2 * spread), 30.0)))
        if self._leaps(points, width):
            reliability = min(reliability, LEAP_RELIABILITY)
        self._carry_on(float(reliability))
        if self._gap <= 3:
            self._weigh(points, self._last, 2 * float(reliability) - 1)
        self._unsure = self._unsure + self._gap if confidence < POOR else 0
        verdict = self._look(None if marks is None else -marks if flipped else marks)
        if verdict is not None and verdict.wrong:
            points, flipped = points[::-1], not flipped
        self._last, self._gap = points, 1
        self._note_swap()
        return Linked(points, float(reliability), bool(flipped), verdict)

    def _carry_on(self, reliability: float) -> None:
        """Take the belief over a link."""
        doubt = self._doubt
        if doubt is not None:
            doubt.same = _dilute(doubt.same, reliability)
            doubt.since = _dilute(doubt.since, reliability)
            doubt.frames += 1
            if reliability < doubt.worst:
                doubt.worst, doubt.frames = reliability, 0
        elif reliability < DOUBTFUL:
            same = log(reliability / (1 - reliability))
            self._doubt = _Doubt(self._motion, same, reliability)
        self._motion = self._bounded(_dilute(self._motion, reliability))

    def _look(self, marks: Floats | None) -> Verdict | None:
        """Remember how the ends look, or tell by it which way round a link in doubt was."""
        if marks is None:
            return None
        doubt = self._doubt
        if doubt is None:
            self._looks.learn(marks)
            if abs(self._moved) >= CERTAIN_ODDS:
                self._head.learn(marks if self._moved > 0 else -marks)
            return None
        doubt.marks, doubt.looks = doubt.marks + marks, doubt.looks + 1
        same = doubt.same + self._looks.log_odds(doubt.marks / doubt.looks)
        self._motion = self._bounded(_dilute(doubt.before, 1 / (1 + exp(-same))) + doubt.since)
        if doubt.looks < LOOKS:
            return None
        self._doubt = None
        wrong = same < 0
        if wrong:  # back to the order from before the link
            self._motion = self._bounded(_dilute(doubt.before, certainty(same)) - doubt.since)
            self._activity = self._activity[::-1].copy()
        return Verdict(doubt.frames, wrong, certainty(same))

    def _leaps(self, points: Floats, width: float) -> bool:
        """Tell whether an end is farther from where it was than an end can have got."""
        if self._last is None:
            return False
        line = as_complex(self._last)
        far = max(LEAP_WIDTHS * width, LEAP_LENGTHS * float(np.abs(line[1:] - line[:-1]).sum()))
        moved = np.abs(as_complex(points[[0, -1]]) - line[[0, -1]])
        return float(moved.max()) > NEARLY_A_LEAP * far * self._gap

    def _weigh(self, points: Floats, last: Floats, trust: float) -> None:
        """Add what the motion between two midlines says, as far as their link is trusted."""
        line = as_complex(last)
        length = float(np.abs(line[1:] - line[:-1]).sum())
        # Along the tangent towards the first end, and sideways.
        moved = (as_complex(points) - line) * -tangents(line).conj()
        n = len(points)
        forward = float(moved.real[n // 8 : n - n // 8].mean())
        self._forward = forward
        part = min(max(forward / length, -MOST_STEP), MOST_STEP)
        told = trust * ODDS_PER_LENGTH * part
        self._motion += told
        if self._doubt is not None:
            self._doubt.since += told
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
    if reliability == 1.0:
        return log_odds
    p = chained(1 / (1 + exp(-log_odds)), reliability)
    return log(p / (1 - p))


def _distance(a: Floats, b: Floats) -> float:
    """Return the mean distance of corresponding points."""
    return float(np.abs(as_complex(a - b)).mean())


def _slid(points: Floats, forward: float) -> Floats:
    """Return a midline slid along itself by a length, towards its first end."""
    line = as_complex(points)
    s = arc(line)
    at = s - forward
    slid = np.interp(at, s, line)
    slid += np.minimum(at, 0.0) * (line[1] - line[0]) / max(s[1], 1e-9)
    slid += np.maximum(at - s[-1], 0.0) * (line[-1] - line[-2]) / max(s[-1] - s[-2], 1e-9)
    return as_points(slid)
