"""Ways back through folds that wait, from the frames after them that show the body.

And there again, where the body that was followed into a fold turned out not to be the worm's.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from worm_msgs_py.contract.status import Status
from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import PastDetection
from worm_tracker.propagation.contradictions import in_doubt_where_contradicted
from worm_tracker.propagation.opening import (
    AgreementSettings,
    body_of,
    supersedes,
    tells_more,
    told_of_fold,
)
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.known_stretches import known_stretches

PropagateBack = Callable[[Observation, Sequence[PastDetection]], Iterator[Observation]]
"""What a frame that shows the body tells of the pictures beside it, the nearest first."""


@dataclass(frozen=True, eq=False, slots=True)
class Coils:
    """Coils one after the other, and the frames beside them that show the body.

    Attributes
    ----------
    frames : list of PendingFrame
        In their order; each has kept what was seen in it.
    opened : PendingFrame
        The frame after them; it has a midline.
    entered : PendingFrame or None
        The one before them, where that shows the body.
    """

    frames: list[PendingFrame]
    opened: PendingFrame
    entered: PendingFrame | None

    @property
    def detections(self) -> list[PastDetection]:
        """What was kept of their pictures, the latest first."""
        later = [*self.frames[1:], self.opened]
        kept = [
            PastDetection(pending.observation.unresolved, after.elapsed.steps)
            for pending, after in zip(self.frames, later, strict=True)
            if pending.observation.unresolved is not None
        ]
        return kept[::-1]


class WayBack:
    """A way back through the coils that waited when a frame showed the body.

    It can be pickled at any step, so that a replay that is stopped goes on from there.

    Parameters
    ----------
    opened : int
        Number of that frame; once the way is over, all up to it can be linked.
    propagate_back : callable
    runs : sequence of Coils
        Those to go through.
    agreement : AgreementSettings
    """

    def __init__(
        self,
        opened: int,
        propagate_back: PropagateBack,
        runs: Sequence[Coils],
        agreement: AgreementSettings,
    ) -> None:
        self.opened, self.propagate_back = opened, propagate_back
        self._passages = deque(_Passage(run, propagate_back, agreement) for run in runs)

    @property
    def left(self) -> int:
        """Most frames that are left to go through."""
        return sum(passage.left for passage in self._passages)

    def step(self) -> bool:
        """Go on by one frame; False where the way is over."""
        while self._passages:
            if self._passages[0].step():
                return True
            self._passages.popleft()
        return False


class _Passage:
    """The way back through one run of coils; and there again where that was not followed."""

    def __init__(
        self, run: Coils, propagate_back: PropagateBack, agreement: AgreementSettings
    ) -> None:
        self._run, self._propagate_back, self._agreement = run, propagate_back, agreement
        self._keeps = run.opened.observation.kept is not None
        self._there = {pending.frame: pending.observation for pending in run.frames}
        self._back = dict[int, Observation]()
        self._frames = deque(reversed(run.frames))
        self._told = propagate_back(run.opened.observation, run.detections)
        self._again: deque[tuple[PendingFrame, list[PendingFrame]]] | None = None
        self.left = _most_steps(run)

    def step(self) -> bool:
        """Go on by one frame; False where all that can be told of the run is told."""
        while True:
            observation = next(self._told, None) if self._frames else None
            if observation is not None:
                self._take(self._frames.popleft(), observation)
                self.left -= 1
                return True
            if not self._enter_again():
                self._tell_known()
                self._doubt_contradicted()
                return False

    def _enter_again(self) -> bool:
        """Begin to go there again, once the way back is over; False where nothing is left."""
        if self._again is None:
            self._again = deque(_entered(self._run, self._there))
        if not self._again:
            return False
        entered, frames = self._again.popleft()
        kept = [
            PastDetection(seen, pending.elapsed.steps)
            for pending in frames
            if (seen := self._there[pending.frame].unresolved) is not None
        ]
        self._frames = deque(frames)
        self._told = self._propagate_back(entered.observation, kept)
        return True

    def _take(self, pending: PendingFrame, observation: Observation) -> None:
        """Take what the present way says of a frame."""
        if self._again is None:
            self._back[pending.frame] = observation
            self._tell(pending, observation)
            return
        self._there[pending.frame] = observation
        if self._may_lie_so(pending.observation, observation):
            self._tell(pending, observation)

    def _may_lie_so(self, told: Observation, again: Observation) -> bool:
        """Tell whether what is seen once more of a frame tells of it: another body may be wrong."""
        before, now = body_of(told), body_of(again)
        if before is None or now is None or not before.explains:
            return True
        return supersedes(now, before, self._agreement)

    def _tell(self, pending: PendingFrame, observation: Observation) -> None:
        """Tell a frame by what a way says of it; nothing where nothing tells which way was lost."""
        followed = pending.observation.may_lie_as
        is_told = observation.status.has_pose and observation.loops_known
        is_told &= not self._may_be_otherwise(pending)
        if not is_told and followed is not None and followed.contradicts(observation):
            return
        self._change(pending, told_of_fold(pending.observation, observation, self._agreement))

    def _may_be_otherwise(self, pending: PendingFrame) -> bool:
        """Tell whether a loop in doubt may be passed as it was followed, against the way back.

        A frame that opens a run and is still folded tells by its bends alone how its own are.
        """
        opened, there = self._run.opened.observation, pending.observation
        is_open = opened.status is Status.TRACKED
        return not is_open and not there.loops_known and not any(there.occluded)

    def _tell_known(self) -> None:
        """Tell what was only followed, where that is known by the other way."""
        numbers = [pending.frame for pending in self._run.frames]
        known = known_stretches(numbers, self._there, self._back, self._agreement)
        for pending in self._run.frames:
            for frames, said in zip(known, (self._there, self._back), strict=True):
                body = said[pending.frame].followed if pending.frame in frames else None
                if body is None or not body.explains or body.is_mostly_hidden:
                    continue
                if tells_more(body, pending.observation):
                    self._change(pending, body)

    def _doubt_contradicted(self) -> None:
        """Put in doubt what frames, or both ways through the fold, tell otherwise."""
        run = self._run
        before = [run.entered] if run.entered else []
        fold, otherwise = [*before, *run.frames, run.opened], dict[int, Observation]()
        for k, pending in enumerate(fold):
            said = [
                each[pending.frame] for each in (self._there, self._back) if pending.frame in each
            ]
            ways = [way for way in said if way.shows_pose]
            if len(ways) == 2:
                otherwise[k] = ways[0] if pending.observation is ways[1] else ways[1]
        told = in_doubt_where_contradicted(
            [pending.stamp_ns for pending in fold],
            [pending.observation for pending in fold],
            otherwise,
            self._agreement.contradictions,
        )
        for pending, observation in zip(run.frames, told[len(before) :], strict=False):
            if observation is not pending.observation:
                self._change(pending, observation)

    def _change(self, pending: PendingFrame, told: Observation) -> None:
        """Tell a frame; that may be taken back while the body that opened the run may be."""
        if self._keeps and told.seen is None:
            told = replace(told, kept=pending.observation.seen)
        pending.observation = told


def _is_followed(observation: Observation) -> bool:
    return observation.has_midline or observation.followed is not None


def _most_steps(run: Coils) -> int:
    """Return how many frames there are to go through, back and there again."""
    unfollowed = sum(not _is_followed(pending.observation) for pending in run.frames)
    return len(run.frames) + unfollowed


def _entered(
    run: Coils, there: Mapping[int, Observation]
) -> list[tuple[PendingFrame, list[PendingFrame]]]:
    """Return the frames that show the body, each with those behind it up to the next one.

    Where nothing was followed on the way there, so that it is worth to go there again.
    """
    found = list[tuple[PendingFrame, list[PendingFrame]]]()
    entered, frames = None, list[PendingFrame]()
    for pending in [*([run.entered] if run.entered else []), *run.frames, run.opened]:
        if pending is not run.opened and not pending.observation.shows_pose:
            frames.append(pending)
            continue
        if entered is not None and frames and not _is_followed(there[frames[0].frame]):
            found.append((entered, frames))
        entered, frames = pending, []
    return found
