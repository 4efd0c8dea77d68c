"""Which end is the head: running log odds from how the body moves.

Links between frames carry them on. A link that may be the wrong way round takes their certainty
away; the appearance of the ends, before and after, can give it back.
"""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import exp, log

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_tracker.head_tail.appearance import AppearanceModel, AppearanceSettings
from worm_tracker.head_tail.certainty import certainty, diluted
from worm_tracker.head_tail.chain_order import KnownAgain
from worm_tracker.head_tail.forward_motion import (
    ForwardMotionSettings,
    together,
    with_motion,
)
from worm_tracker.head_tail.link import (
    BodyMotion,
    Chain,
    Link,
    LinkDecision,
    LinkSettings,
)
from worm_tracker.observation import Observation
from worm_tracker.worm_track import WormTrack


@dataclass(frozen=True, slots=True)
class HeadTailSettings:
    """How much each thing tells which end is the head, in log odds."""

    forward: ForwardMotionSettings = field(default_factory=ForwardMotionSettings)
    """A worm moves head-first."""
    most_step_lengths: float = 0.25
    """Most that a single step counts for: a jump is an error, not a stride."""
    most_log_odds: float = 12.0
    """Cap, so that some two lengths the other way undo any belief."""
    most_appearance_log_odds: float = 1.0
    """Most that the appearance of an end can add: it is like the head's while that was certain."""
    certain_log_odds: float = 3.6
    """Beyond this (97 %), half a length of motion, the head is taken as decided."""
    least_corrected_log_odds: float = 0.01
    """The least that an operator's correction still counts for, after links in doubt."""
    doubtful_below_reliability: float = 0.99
    """A link less reliable than this is decided by the appearance of the ends, if they differ."""
    deciding_frames: int = 15
    """Frames after such a link whose mean appearance decides it."""
    link: LinkSettings = field(default_factory=LinkSettings)
    appearance: AppearanceSettings = field(default_factory=AppearanceSettings)


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
class _Doubt:
    """A link that may be the wrong way round, and what has been seen since.

    Attributes
    ----------
    before : float
        Log odds before the link, in the order from before it.
    same : float
        Log odds that the order is the same after it, by where the body was.
    worst : float
        Reliability of the least reliable of the links in doubt.
    frames : int
        How many frames ago it was.
    since : float
        Log odds from motion after it, in the order from after it.
    appearance : ndarray
        Sum of the differences of the ends' appearance seen after it.
    frames_seen : int
        How many frames that was.
    """

    before: float
    same: float
    worst: float
    frames: int = 0
    since: float = 0.0
    appearance: Floats = field(default_factory=lambda: np.zeros(1))
    frames_seen: int = 0

    def over_link(self, reliability: float) -> "_Doubt":
        """Return the doubt after a further link."""
        worst, frames = self.worst, self.frames + 1
        if reliability < worst:
            worst, frames = reliability, 0
        return replace(
            self,
            same=diluted(self.same, reliability),
            since=diluted(self.since, reliability),
            worst=worst,
            frames=frames,
        )


@dataclass(frozen=True, eq=False, slots=True)
class _Appearance:
    """How the ends differ: in the chain's order, and in that of the head while it was certain."""

    body: AppearanceModel
    head: AppearanceModel

    @classmethod
    def unknown(cls, settings: AppearanceSettings) -> "_Appearance":
        return cls(AppearanceModel(settings), AppearanceModel(settings))

    def updated(self, difference: Floats, head_first: Floats | None) -> "_Appearance":
        head = self.head if head_first is None else self.head.updated(head_first)
        return _Appearance(self.body.updated(difference), head)


class HeadTail:
    """Holds the belief which end of the chained midlines is the head.

    Parameters
    ----------
    track : WormTrack
        Which remembers the last midline.
    settings : HeadTailSettings

    Attributes
    ----------
    swaps : int
        Times that a decision, once certain, was turned into its contrary.
    """

    def __init__(self, track: WormTrack, settings: HeadTailSettings) -> None:
        self._settings = settings
        self._chain = Chain(track, settings.link)
        self._motion = 0.0
        self._appearance = _Appearance.unknown(settings.appearance)
        self._doubt: _Doubt | None = None
        self._when_known: tuple[float, _Doubt | None] = 0.0, None
        self._motion_since_known = 0.0
        self._decided = 0
        self._corrected = False
        self.swaps = 0

    @property
    def log_odds(self) -> float:
        """Log odds that the first end is the head, from motion and appearance.

        Their sign is the decision.
        """
        return self._motion + self._from_appearance

    @property
    def _from_appearance(self) -> float:
        """Log odds from the appearance of the head while it was certain."""
        few = self._appearance.body.frames < self._settings.deciding_frames
        if self._corrected or self._doubt is not None or few:
            return 0.0
        most = self._settings.most_appearance_log_odds
        return min(max(self._appearance.head.log_odds(self._appearance.body.mean), -most), most)

    @property
    def begun(self) -> bool:
        """Whether there is a body to speak of."""
        return self._chain.begun

    @property
    def certain(self) -> bool:
        """Whether the head is decided."""
        return abs(self.log_odds) >= self._settings.certain_log_odds

    @property
    def when_known(self) -> tuple[int, float]:
        """How many frames ago widths last told the order of the ends, and the log odds then."""
        frames = self._chain.frames_unknown
        return frames, self._when_known[0] if frames else self.log_odds

    @property
    def corrected(self) -> bool:
        """Whether an operator has said which end is the head."""
        return self._corrected

    @property
    def certainty_by_word(self) -> float:
        """How sure the head is where a person has said it: a person may be wrong, too."""
        return certainty(self._settings.most_log_odds)

    def correct(self) -> None:
        """Exchange head and tail on an operator's word, for good.

        From now on motion may confirm the head, after a link that left it in doubt,
        but never exchange it again.
        """
        sign = -1.0 if self.log_odds >= 0 else 1.0
        self._motion = sign * self._settings.most_log_odds
        self._doubt = None
        self._when_known, self._motion_since_known = (self._motion, None), 0.0
        self._corrected = True
        self._decided = int(sign)

    def skip(self, frames: int) -> None:
        """Note that frames are missing: the next link is over a longer time."""
        self._chain.skip(frames)

    def miss(self) -> None:
        """Note a frame without a midline: the next link is less sure."""
        self._chain.miss()
        if self._doubt is not None:
            self._doubt = replace(self._doubt, frames=self._doubt.frames + 1)

    def follow(self, observation: Observation) -> Link:
        """Carry the order of the ends on over a midline that is not told."""
        return self._link(observation)

    def push(self, observation: Observation) -> Link:
        """Join the next midline, which may be either way round, and weigh what it says."""
        link = self._link(observation)
        seen, reliability = link.observation, link.reliability
        if link.motion is not None:
            self._add_motion(link.motion, 2 * reliability - 1)
        decision = None if seen.appearance is None else self._add_appearance(seen.appearance)
        if decision is not None and decision.was_reversed:
            self._chain.reverse(decision.frames)
            if self._chain.frames_unknown <= decision.frames:
                self._when_known = -self._when_known[0], self._when_known[1]
            self._motion_since_known *= -1
            seen = seen.reversed()
        self._note_swap()
        return replace(link, observation=seen, decision=decision)

    def _link(self, observation: Observation) -> Link:
        """Join a midline, and take the belief over the link."""
        if self._chain.is_known:
            self._when_known, self._motion_since_known = (self._motion, self._doubt), 0.0
        link = self._chain.push(observation)
        if link.is_new_body and not self._corrected:
            self._forget()
        again = link.known_again
        if again is None:
            self._cross(link.reliability)
        elif self._corrected or not (again.frames_between or again.way_was_wrong):
            self._cross(1.0)
        else:
            self._know_again(again)
        return link

    def _know_again(self, again: KnownAgain) -> None:
        """Take up the belief of the last midline whose widths told the order of its ends."""
        settings, since = self._settings.forward, self._motion_since_known
        since = 0.0 if again.way_was_wrong else since
        self._motion, doubt = self._when_known
        self._motion = self._bounded(together(self._motion, since, settings))
        if doubt is not None:
            frames = doubt.frames + again.frames_between + 1
            doubt = replace(doubt, frames=frames, since=together(doubt.since, since, settings))
        self._doubt = doubt

    def _forget(self) -> None:
        """Forget what was held to be the head's looks and motion: it was not of this body."""
        self._motion, self._doubt = 0.0, None
        self._appearance = _Appearance.unknown(self._settings.appearance)

    def _cross(self, reliability: float) -> None:
        """Take the belief over a link."""
        if self._doubt is not None:
            self._doubt = self._doubt.over_link(reliability)
        elif reliability < self._settings.doubtful_below_reliability:
            same = log(reliability / (1 - reliability))
            self._doubt = _Doubt(self._motion, same, reliability)
        self._motion = self._bounded(diluted(self._motion, reliability))
        self._motion_since_known = diluted(self._motion_since_known, reliability)

    def _add_appearance(self, appearance: Floats) -> LinkDecision | None:
        """Remember the ends' appearance, or tell by it which way round a link in doubt was."""
        settings, doubt = self._settings, self._doubt
        if doubt is None:
            belief = self._motion
            is_certain = abs(belief) >= settings.certain_log_odds
            head = (appearance if belief > 0 else -appearance) if is_certain else None
            self._appearance = self._appearance.updated(appearance, head)
            return None
        doubt = replace(
            doubt, appearance=doubt.appearance + appearance, frames_seen=doubt.frames_seen + 1
        )
        same = doubt.same + self._appearance.body.log_odds(doubt.appearance / doubt.frames_seen)
        before = diluted(doubt.before, 1 / (1 + exp(-same)))
        self._motion = self._bounded(together(before, doubt.since, settings.forward))
        self._doubt = doubt
        if doubt.frames_seen < settings.deciding_frames:
            return None
        self._doubt = None
        if same < 0:  # back to the order from before the link
            before = diluted(doubt.before, certainty(same))
            self._motion = self._bounded(together(before, -doubt.since, settings.forward))
        return LinkDecision(doubt.frames, same < 0, certainty(same))

    def _add_motion(self, motion: BodyMotion, trust: float) -> None:
        """Add what the motion between two midlines says, as far as their link is trusted."""
        settings = self._settings
        most = settings.most_step_lengths
        part = min(max(motion.forward_lengths, -most), most)
        told = trust * part
        if self._doubt is not None:
            since = with_motion(self._doubt.since, told, settings.forward)
            self._doubt = replace(self._doubt, since=since)
        since_known = with_motion(self._motion_since_known, told, settings.forward)
        self._motion_since_known = self._bounded(since_known)
        self._motion = self._bounded(with_motion(self._motion, told, settings.forward))

    def _bounded(self, odds: float) -> float:
        """Return log odds within their limits, on the side that an operator has chosen."""
        high = self._settings.most_log_odds
        low = -high
        if self._corrected:
            least = self._settings.least_corrected_log_odds
            low, high = (least, high) if self._decided > 0 else (low, -least)
        return min(max(odds, low), high)

    def _note_swap(self) -> None:
        odds = self.log_odds
        if abs(odds) < self._settings.certain_log_odds:
            return
        sign = 1 if odds > 0 else -1
        if self._decided == -sign:
            self.swaps += 1
        self._decided = sign
