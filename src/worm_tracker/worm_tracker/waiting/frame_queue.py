"""Frames that wait: coils for a frame that tells how they lay, all for the head to be decided."""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import ceil

from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.status import Status
from worm_msgs_py.files.corrections import Correction
from worm_tracker.head_tail.certainty import (
    LEAST_CERTAINTY,
    both_say,
    certainty,
    certainty_before_link,
    probability,
    smoothed_before_link,
)
from worm_tracker.head_tail.chain_order import KnownAgain
from worm_tracker.head_tail.identity import Exchange, ExchangeKind, HeadTail
from worm_tracker.head_tail.link import LinkDecision
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.waiting.brief_gaps import BriefGaps, BriefGapSettings
from worm_tracker.waiting.frame_state import PendingFrame, tracked_frame
from worm_tracker.waiting.ways_back import Coils, PropagateBack, WayBack


class FrameQueue:
    """Links frames in their order, and gives each when its head need not wait any longer.

    Parameters
    ----------
    head_tail : HeadTail
    hold_back_frames : int
        Most frames that wait.
    px_per_mm : float
        Scale of pictures without a chamber; NaN where it is not known.
    corrections : sequence of Correction
        Whose frames leave with head and tail exchanged.
    most_frames_for_body : int
    agreement : AgreementSettings
    brief_gaps : BriefGapSettings
        See `TrackerSettings`.

    Attributes
    ----------
    exchanges : list of Exchange
        Each time that head and tail were exchanged, by the tracker or by an operator.
    """

    def __init__(
        self,
        head_tail: HeadTail,
        hold_back_frames: int,
        px_per_mm: float,
        corrections: Sequence[Correction] = (),
        *,
        most_frames_for_body: int,
        agreement: AgreementSettings,
        brief_gaps: BriefGapSettings,
    ) -> None:
        self._head_tail = head_tail
        self._most_frames_for_body = min(hold_back_frames, most_frames_for_body)
        self._corrections = corrections
        self._agreement = agreement
        self._brief_gaps = BriefGaps(brief_gaps)
        self._hold_back_frames = hold_back_frames
        self._px_per_mm = px_per_mm
        self._waiting: deque[PendingFrame] = deque()
        self._linked: deque[PendingFrame] = deque()
        self._way_back: WayBack | None = None
        self._body_is_new = False
        self._head_first: bool | None = None
        self._known_of_given = LEAST_CERTAINTY
        self._home = ""
        self.exchanges: list[Exchange] = []

    def __len__(self) -> int:
        return len(self._linked) + len(self._waiting)

    def is_due(self, body_is_learned: bool) -> bool:
        """Tell whether what waits can be told by now.

        A frame that shows the body has come; and that is known well, or well enough and the frames
        have waited for it for long.

        Parameters
        ----------
        body_is_learned : bool
            Whether enough midlines have been seen to know the body by.
        """
        opened = next((told for told in reversed(self._waiting) if told.is_open), None)
        if opened is None:
            return False
        known = opened.observation.kept is None or self._head_tail.corrected
        return known or (len(self) > self._most_frames_for_body and body_is_learned)

    def coils(self) -> list[Coils]:
        """Return the coils that wait, each run of them with the frame that opens it."""
        found, run = [], list[PendingFrame]()
        entered = self._linked[-1] if self._linked and self._linked[-1].is_open else None
        for pending in self._waiting:
            if pending.is_open:
                if run:
                    found.append(Coils(run, pending, entered))
                run, entered = [], pending
            elif pending.observation.unresolved is not None:
                run.append(pending)
            else:
                run, entered = [], None  # nothing tells where the body was meanwhile
        return found

    def go_back(self, propagate_back: PropagateBack, most: int | None = None) -> None:
        """Go back through the coils that wait, from the frames that show how they lay.

        What lies behind the last of these frames is linked at the end. A long fold takes seconds
        to go back through: live, that is spread over the frames after it.

        Parameters
        ----------
        propagate_back : callable
        most : int or None
            Most frames to go back by now, but for what would be left over once no frame can wait
            any longer: that is spread, too. None: all, and those that no frame can wait for.
        """
        if self._way_back is None:
            self._begin_way_back(propagate_back)
        if most is None or len(self) > self._hold_back_frames:
            self._end_way_back()
            return
        steps, most = 0, max(most, self._least_steps())
        while self._way_back is not None and steps < most:
            if self._way_back.step():
                steps += 1
            else:
                self._arrive(self._way_back)

    def reopen(self) -> None:
        """Take back what was told of the frames that wait: their body was not the worm's."""
        self._way_back = None
        while self._linked and self._linked[-1].observation.seen is not None:
            self._waiting.appendleft(self._linked.pop())
        for pending in self._waiting:
            told = pending.observation
            if told.seen is not None:
                pending.observation = Observation(
                    Status.COILED, told.u, told.v, unresolved=told.seen
                )
                pending.reliability = 1.0

    def push(self, pending: PendingFrame) -> None:
        """Take the next frame."""
        if pending.observation.seen is None and not pending.is_open:
            self._end_way_back()  # nothing that waits will be told by a later frame
        if pending.observation.has_midline:
            self._body_is_new = pending.observation.kept is not None
        self._waiting.append(pending)
        if pending.observation.seen is None and not any(
            waiting.observation.kept for waiting in self._waiting
        ):
            behind_coils = pending.is_open and len(self._waiting) > 1
            self._link_oldest(0 if behind_coils else len(self._waiting))

    def link_open(self) -> None:
        """Link what waits up to the last frame that shows the body."""
        self._end_way_back()
        behind = 0
        while behind < len(self._waiting) and not self._waiting[-1 - behind].is_open:
            behind += 1
        self._link_oldest(len(self._waiting) - behind)

    def link_all(self) -> None:
        """Link what waits as it is now."""
        self._end_way_back()
        self._link_oldest(len(self._waiting))

    def release(self, body_in_doubt: bool = False, others: int = 0) -> list[TrackedFrame]:
        """Return the frames that need not wait any longer.

        Parameters
        ----------
        body_in_doubt : bool
            Whether what is known of the body now may be that of a worm laid double: neither end of
            what was found by it is told as the head for certain.
        others : int
            Frames that wait elsewhere, between these.
        """
        over = len(self) + others - self._hold_back_frames
        if over > 0:
            self._end_way_back()
        self._link_oldest(min(len(self._waiting), over - len(self._linked)))
        ready = 0
        if self._head_tail.corrected or (self._head_tail.certain and not self._body_is_new):
            ready = len(self._linked)
        else:
            for pending in self._linked:
                if pending.observation.has_midline:
                    break
                ready += 1
        if ready:
            newest_ns = (self._waiting or self._linked)[-1].stamp_ns
            ready = self._brief_gaps.ready(list(self._linked), ready, newest_ns)
        return self._give(max(ready, min(over, len(self._linked))), body_in_doubt)

    def finish(self, body_in_doubt: bool = False) -> list[TrackedFrame]:
        """Return all frames that wait, as `release` does; none comes after them."""
        self.link_all()
        return self._give(len(self._linked), body_in_doubt)

    def swap_head(self, next_frame: int, last_ns: int) -> Exchange | None:
        """Exchange head and tail on an operator's word, for the frames that wait and all to come.

        Parameters
        ----------
        next_frame, last_ns : int
            Number of the frame to come, and stamp of the last one: where none waits.
        """
        self.link_open()
        if not self._head_tail.begun:
            return None
        self._head_tail.correct()
        _forget_head(self._linked)
        oldest = next(iter([*self._linked, *self._waiting]), None)
        exchange = Exchange(
            ExchangeKind.CORRECTION,
            oldest.frame if oldest else next_frame,
            oldest.stamp_ns if oldest else last_ns,
            certainty(self._head_tail.log_odds),
        )
        self.exchanges.append(exchange)
        self._head_first, self._known_of_given = None, LEAST_CERTAINTY
        return exchange

    def _least_steps(self) -> int:
        """Return by how many frames to go back with each new one to arrive while all can wait."""
        left = self._way_back.left if self._way_back else 0
        return ceil(left / (1 + self._hold_back_frames - len(self)))

    def _begin_way_back(self, propagate_back: PropagateBack) -> None:
        """Begin to go back from the last frame that shows the body, where one waits."""
        self._way_back = None
        opened = next((told for told in reversed(self._waiting) if told.is_open), None)
        if opened is not None:
            runs = self.coils()
            self._way_back = WayBack(opened.frame, propagate_back, runs, self._agreement)

    def _arrive(self, way: WayBack) -> None:
        """Link what a way back has told, and begin the next where a fold has opened meanwhile."""
        while self._waiting and self._waiting[0].frame <= way.opened:
            self._link_oldest(1)
        self._begin_way_back(way.propagate_back)

    def _end_way_back(self) -> None:
        """Go the rest of a way back that was begun, and of those after it."""
        while self._way_back is not None:
            if not self._way_back.step():
                self._arrive(self._way_back)

    def _link_oldest(self, count: int) -> None:
        for _ in range(count):
            self._link(self._waiting.popleft())

    def _link(self, pending: PendingFrame) -> None:
        """Link a frame to those before it."""
        self._head_tail.skip(pending.elapsed.frames_missing)
        observation, decision = pending.observation, None
        if observation.has_midline:
            link = self._head_tail.push(observation)
            pending.observation, decision = link.observation, link.decision
        elif observation.followed is not None:
            link = self._head_tail.follow(observation.followed)
        else:
            link = None
            self._head_tail.miss()
        if link is not None:
            pending.reliability, pending.own_reliability = link.reliability, link.own_reliability
            if link.known_again is not None:
                self._know_again(pending, link.known_again)
            if link.is_new_body:
                _forget_head(self._linked)
        pending.first_is_head = probability(self._head_tail.log_odds)
        if decision is not None:
            self._revise(decision)
        self._linked.append(pending)

    def _know_again(self, pending: PendingFrame, again: KnownAgain) -> None:
        """Let a frame's widths tell its order, and what is between it and the last that told it.

        What lies between is known from the frames to either side. Where these say that one of the
        links between is the wrong way round, what lies behind the least sure one is turned round.
        """
        between = list(self._linked)[-again.frames_between :] if again.frames_between else []
        kept = 1.0 if len(between) == again.frames_between else LEAST_CERTAINTY
        there = []
        for each in between:
            kept = certainty_before_link(kept, each.reliability)
            there.append(kept)
        back = pending.reliability
        for each, kept in zip(reversed(between), reversed(there), strict=True):
            order = both_say(kept, 1 - back if again.way_was_wrong else back)
            if order < LEAST_CERTAINTY and each.observation.has_midline:
                each.turn_round()
            back = certainty_before_link(back, each.reliability)
            each.own_reliability = min(each.own_reliability, max(order, 1 - order))
            each.reliability = 1.0
        pending.reliability, pending.own_reliability = 1.0, again.reliability

    def _revise(self, decision: LinkDecision) -> None:
        """Revise a link that was in doubt, as far as its frames wait: those given stay as told."""
        after = len(self._linked) - decision.frames
        if after >= 0 and decision.frames:
            self._linked[after].reliability = decision.reliability
        if not decision.was_reversed:
            return
        for k in range(max(after, 0), len(self._linked)):
            self._linked[k].turn_round()
        if after < 0:
            self._known_of_given = 1 - self._known_of_given
            if self._head_first is not None:
                self._head_first = not self._head_first

    def _give(self, count: int, body_in_doubt: bool) -> list[TrackedFrame]:
        """Return the oldest frames with the head as it is known by now."""
        if count <= 0:
            return []
        unsure = body_in_doubt and not self._head_tail.corrected
        first_is_head, self._known_of_given = self._first_is_head(count)
        told = []
        for sure, pending in zip(first_is_head, self._linked, strict=True):
            own = certainty_before_link(sure, pending.own_reliability)
            in_doubt = unsure and pending.observation.seen is not None
            told.append((sure >= 0.5, LEAST_CERTAINTY if in_doubt else max(own, 1 - own)))
        observations = self._brief_gaps.tell(self._linked, count)
        given = [
            replace(self._linked.popleft(), observation=observation) for observation in observations
        ]
        return [
            self._tracked(pending, *each) for pending, each in zip(given, told[:count], strict=True)
        ]

    def _first_is_head(self, given: int) -> tuple[list[float], float]:
        """Return how probable it is of each linked frame that its first end is the head.

        By what is known now, back over the links; or by what was known when widths last told the
        order of the ends, over the links since, where that tells more.

        Parameters
        ----------
        given : int
            How many of these frames are given now: of the last of them what was known when widths
            told the order is returned, too, for those that come after it.
        """
        links, (ago, odds_then) = list(self._linked), self._head_tail.when_known
        known, then = len(links) - 1 - ago, probability(odds_then)
        back, sure = [LEAST_CERTAINTY] * len(links), probability(self._head_tail.log_odds)
        for k in reversed(range(len(links))):
            back[k] = sure = _surer(sure, then) if k == known else sure
            was = links[k - 1].first_is_head if k else LEAST_CERTAINTY
            sure = smoothed_before_link(sure, was, links[k].reliability)
        since, sure = [], self._known_of_given
        for k, pending in enumerate(links):
            sure = then if k == known else certainty_before_link(sure, pending.reliability)
            since.append(sure)
        for k in range(max(known, 0), len(links)):
            back[k] = _surer(back[k], since[k])
        return back, since[given - 1]

    def _tracked(self, pending: PendingFrame, head_first: bool, sure: float) -> TrackedFrame:
        """Return what is said of a frame, and count it."""
        if pending.observation.has_midline:
            if self._head_first is not None and head_first != self._head_first:
                # A frame is given whose head is the end that was the tail before it.
                swap = Exchange(ExchangeKind.SWAP, pending.frame, pending.stamp_ns, sure)
                self.exchanges.append(swap)
            self._head_first = head_first
        if any(told.swaps(pending.frame) for told in self._corrections):
            head_first, sure = not head_first, self._head_tail.certainty_by_word
        tracked = tracked_frame(pending, head_first, sure, self._px_per_mm, self._home)
        self._home = tracked.state.frame_id
        return tracked


def _forget_head(linked: Iterable[PendingFrame]) -> None:
    """Let frames that wait be told by what comes after them alone."""
    for pending in linked:
        pending.first_is_head = LEAST_CERTAINTY


def _surer(one: float, other: float) -> float:
    """Return the probability that tells more."""
    return max(one, other, key=lambda each: abs(each - 0.5))
