"""Ways back through folds that wait, from the frames after them that show the body."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import PastDetection
from worm_tracker.propagation.opening import AgreementSettings, told_of_fold
from worm_tracker.waiting.frame_state import PendingFrame

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
class WayBack:
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
                lost = followed is not None and followed.contradicts(observation)
                if is_told or not lost:  # else nothing tells which of the two was
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
