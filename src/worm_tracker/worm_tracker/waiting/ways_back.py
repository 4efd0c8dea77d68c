"""Ways back through folds that wait, from the frames after them that show the body.

And there again, where the body that was followed into a fold turned out not to be the worm's.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import PastDetection
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

    Parameters
    ----------
    opened : int
        Number of that frame; once the way is over, all up to it can be linked.
    propagate_back : callable
    runs : sequence of Coils
        Those to go through.
    agreement : AgreementSettings

    Attributes
    ----------
    left : int
        Most frames that are left to go through.
    """

    def __init__(
        self,
        opened: int,
        propagate_back: PropagateBack,
        runs: Sequence[Coils],
        agreement: AgreementSettings,
    ) -> None:
        self.opened, self.propagate_back = opened, propagate_back
        self._agreement = agreement
        self.left = sum(map(_most_steps, runs))
        told = [propagate_back(run.opened.observation, run.detections) for run in runs]
        self._steps = self._go(list(zip(runs, told, strict=True)))

    def step(self) -> bool:
        """Go on by one frame; False where the way is over."""
        return next(self._steps, False)

    def _go(self, runs: Sequence[tuple[Coils, Iterator[Observation]]]) -> Iterator[bool]:
        for run, told in runs:
            left = self.left - _most_steps(run)
            for _ in self._through(run, told):
                self.left -= 1
                yield True
            self.left = left

    def _through(self, run: Coils, told: Iterator[Observation]) -> Iterator[None]:
        """Go back through a run of coils; and there again where that was not followed."""
        there = {pending.frame: pending.observation for pending in run.frames}
        back = dict[int, Observation]()
        keeps = run.opened.observation.kept is not None
        for pending, observation in zip(reversed(run.frames), told, strict=False):
            back[pending.frame] = observation
            self._tell(pending, observation, keeps)
            yield
        for entered, frames in _entered(run, there):
            kept = [
                PastDetection(seen, pending.elapsed.steps)
                for pending in frames
                if (seen := there[pending.frame].unresolved) is not None
            ]
            again = self.propagate_back(entered.observation, kept)
            for pending, observation in zip(frames, again, strict=False):
                there[pending.frame] = observation
                if self._may_lie_so(pending.observation, observation):
                    self._tell(pending, observation, keeps)
                yield
        self._tell_known(run, there, back)

    def _may_lie_so(self, told: Observation, again: Observation) -> bool:
        """Tell whether what is seen once more of a frame tells of it: another body may be wrong."""
        before, now = body_of(told), body_of(again)
        if before is None or now is None or not before.explains:
            return True
        return supersedes(now, before, self._agreement)

    def _tell(self, pending: PendingFrame, observation: Observation, keeps: bool) -> None:
        """Tell a frame by what a way says of it; nothing where nothing tells which way was lost.

        It may be taken back while the body that opened the run may be (`keeps`).
        """
        followed = pending.observation.may_lie_as
        is_told = observation.status.has_pose and observation.loops_known
        if not is_told and followed is not None and followed.contradicts(observation):
            return
        told = told_of_fold(pending.observation, observation, self._agreement)
        _change(pending, told, keeps)

    def _tell_known(
        self, run: Coils, there: Mapping[int, Observation], back: Mapping[int, Observation]
    ) -> None:
        """Tell what was only followed, where that is known by the other way."""
        numbers = [pending.frame for pending in run.frames]
        keeps = run.opened.observation.kept is not None
        known = known_stretches(numbers, there, back, self._agreement)
        for pending in run.frames:
            for frames, said in zip(known, (there, back), strict=True):
                body = said[pending.frame].followed if pending.frame in frames else None
                if body is None or not body.explains or body.is_mostly_hidden:
                    continue
                if tells_more(body, pending.observation):
                    _change(pending, body, keeps)


def _change(pending: PendingFrame, told: Observation, keeps: bool) -> None:
    if keeps and told.seen is None:
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
