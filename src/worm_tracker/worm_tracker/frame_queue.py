"""Frames that wait: coils for a frame that tells how they lay, all for the head to be decided."""

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil

from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.status import Status
from worm_msgs_py.files.corrections import Correction
from worm_tracker.frame_state import PendingFrame, tracked_frame
from worm_tracker.head_tail.identity import (
    LEAST_CERTAINTY,
    Exchange,
    ExchangeKind,
    HeadTail,
    certainty,
    certainty_before_link,
)
from worm_tracker.head_tail.link import LinkDecision
from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import PastDetection
from worm_tracker.propagation.opening import AgreementSettings, told_of_fold

PropagateBack = Callable[[Observation, Sequence[PastDetection]], Iterator[Observation]]
"""What a frame that shows the body tells of the pictures before it, the latest first."""


@dataclass(frozen=True, eq=False, slots=True)
class Coils:
    """Coils one after the other, and the frame after them that shows the body.

    Attributes
    ----------
    frames : list of PendingFrame
        In their order: the latest is the next to be gone back through.
    opened : PendingFrame
        The frame after them; it has a midline.
    """

    frames: list[PendingFrame]
    opened: PendingFrame

    @property
    def detections(self) -> list[PastDetection]:
        """What was kept of their pictures, the latest first."""
        kept, later = [], self.opened
        for pending in reversed(self.frames):
            if pending.observation.unresolved is not None:
                kept.append(PastDetection(pending.observation.unresolved, later.elapsed.steps))
            later = pending
        return kept


@dataclass(frozen=True, eq=False, slots=True)
class _WayBack:
    """A way back through the coils that waited when a frame showed the body.

    Attributes
    ----------
    opened : int
        Number of that frame; once the way is over, all up to it can be linked.
    propagate_back : callable
    runs : deque of Coils
        Those that are left to go through.
    told : deque of iterator of Observation
        What is told of each.
    agreement : AgreementSettings
    """

    opened: int
    propagate_back: PropagateBack
    runs: deque[Coils]
    told: deque[Iterator[Observation]]
    agreement: AgreementSettings

    def step(self) -> bool:
        """Go back by one frame; False where the way is over."""
        while self.runs:
            observation = next(self.told[0], None) if self.runs[0].frames else None
            if observation is not None:
                pending = self.runs[0].frames.pop()
                followed = pending.observation.may_lie_as
                is_told = observation.status.has_pose and observation.loops_known
                if followed is not None and not is_told and followed.contradicts(observation):
                    self.runs[0].frames.clear()  # one was lost, and nothing tells which
                else:
                    self._tell(pending, observation)
                return True
            self.runs.popleft()
            self.told.popleft()
        return False

    def _tell(self, pending: PendingFrame, back: Observation) -> None:
        """Tell a frame of the run; it may be taken back while the body that opened it may be."""
        told = told_of_fold(pending.observation, back, self.agreement)
        if self.runs[0].opened.observation.kept is not None and told.seen is None:
            told = replace(told, kept=pending.observation.seen)
        pending.observation = told


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
        See `TrackerSettings`.

    Attributes
    ----------
    exchanges : list of Exchange
        Each time that head and tail were exchanged, by the tracker or by an operator.
    statuses : Counter
        Frames given so far, by status.
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
    ) -> None:
        self._head_tail = head_tail
        self._most_frames_for_body = min(hold_back_frames, most_frames_for_body)
        self._corrections = corrections
        self._agreement = agreement
        self._hold_back_frames = hold_back_frames
        self._px_per_mm = px_per_mm
        self._waiting: deque[PendingFrame] = deque()
        self._linked: deque[PendingFrame] = deque()
        self._way_back: _WayBack | None = None
        self._body_is_new = False
        self._head_first: bool | None = None
        self._home = ""
        self.exchanges: list[Exchange] = []
        self.statuses: Counter[Status] = Counter()

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
        for pending in self._waiting:
            if pending.is_open:
                if run:
                    found.append(Coils(run, pending))
                run = []
            elif pending.observation.unresolved is not None:
                run.append(pending)
            else:
                run = []  # nothing tells where the body was meanwhile
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

    def release(self, body_in_doubt: bool = False) -> list[TrackedFrame]:
        """Return the frames that need not wait any longer.

        Parameters
        ----------
        body_in_doubt : bool
            Whether what is known of the body now may be that of a worm laid double: neither end of
            what was found by it is told as the head for certain.
        """
        over = len(self) - self._hold_back_frames
        if over > 0:
            self._end_way_back()
        self._link_oldest(min(len(self._waiting), over - len(self._linked)))
        if self._head_tail.corrected or (self._head_tail.certain and not self._body_is_new):
            return self._give(len(self._linked), body_in_doubt)
        free = 0
        for pending in self._linked:
            if pending.observation.has_midline:
                break
            free += 1
        return self._give(max(free, min(over, len(self._linked))), body_in_doubt)

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
        oldest = next(iter([*self._linked, *self._waiting]), None)
        exchange = Exchange(
            ExchangeKind.CORRECTION,
            oldest.frame if oldest else next_frame,
            oldest.stamp_ns if oldest else last_ns,
            certainty(self._head_tail.log_odds),
        )
        self.exchanges.append(exchange)
        self._head_first = None
        return exchange

    def _least_steps(self) -> int:
        """Return by how many frames to go back with each new one to arrive while all can wait."""
        left = sum(len(run.frames) for run in self._way_back.runs) if self._way_back else 0
        return ceil(left / (1 + self._hold_back_frames - len(self)))

    def _begin_way_back(self, propagate_back: PropagateBack) -> None:
        """Begin to go back from the last frame that shows the body, where one waits."""
        self._way_back = None
        opened = next((told for told in reversed(self._waiting) if told.is_open), None)
        if opened is not None:
            runs = deque(self.coils())
            told = deque(propagate_back(run.opened.observation, run.detections) for run in runs)
            self._way_back = _WayBack(opened.frame, propagate_back, runs, told, self._agreement)

    def _arrive(self, way: _WayBack) -> None:
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
        if pending.observation.has_midline:
            linked = self._head_tail.push(pending.observation)
            pending.observation, pending.reliability = linked.observation, linked.reliability
            self._pass_over(linked.frames_passed)
            if linked.decision is not None:
                self._revise(linked.decision)
        elif pending.observation.followed is not None:
            pending.reliability = self._head_tail.follow(pending.observation.followed)
        else:
            self._head_tail.miss()
        self._linked.append(pending)

    def _pass_over(self, frames: int) -> None:
        """Let no doubt of the last frames' links count: what comes is linked to those before."""
        for k in range(max(len(self._linked) - frames, 0), len(self._linked)):
            self._linked[k].reliability = 1.0

    def _revise(self, decision: LinkDecision) -> None:
        """Revise a link that was in doubt, as far as its frames wait: those given stay as told."""
        after = len(self._linked) - decision.frames
        if after >= 0 and decision.frames:
            self._linked[after].reliability = decision.reliability
        if not decision.was_reversed:
            return
        for k in range(max(after, 0), len(self._linked)):
            self._linked[k].observation = self._linked[k].observation.reversed()
        if after < 0 and self._head_first is not None:
            self._head_first = not self._head_first

    def _give(self, count: int, body_in_doubt: bool) -> list[TrackedFrame]:
        """Return the oldest frames with the head as it is known by now."""
        if count <= 0:
            return []
        odds = self._head_tail.log_odds
        head_first, sure = odds >= 0, certainty(odds)
        certainties = []
        unsure = body_in_doubt and not self._head_tail.corrected
        for pending in reversed(self._linked):
            by_young_body = pending.observation.seen is not None
            certainties.append(LEAST_CERTAINTY if unsure and by_young_body else sure)
            sure = certainty_before_link(sure, pending.reliability)
        certainties.reverse()
        return [
            self._tracked(self._linked.popleft(), head_first, certainties[k]) for k in range(count)
        ]

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
        self.statuses[pending.observation.status] += 1
        return tracked
