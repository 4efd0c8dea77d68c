"""Frames wait here until it is known whether their poses can be believed, or lose them."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from worm_msgs_py.contract.body import TrackedFrame
from worm_tracker.waiting.frame_state import taken_back


class JudgedPoses(ABC):
    """Takes frames in their order, and gives them in it once it is known what of them holds."""

    def __init__(self) -> None:
        # The last ones, as they were before any was taken back.
        self._given: list[TrackedFrame] = []
        self._held: list[TrackedFrame] = []

    def __len__(self) -> int:
        return len(self._held)

    def push(
        self, frames: Sequence[TrackedFrame], most_held: int, *, is_end: bool = False
    ) -> list[TrackedFrame]:
        """Take the next frames; return those of which it is known by now.

        Parameters
        ----------
        frames : sequence of TrackedFrame
        most_held : int
            Most frames that may wait: what is more is returned as it is.
        is_end : bool
            Whether none comes after them: then all that wait are returned.
        """
        self._held += frames
        if not self._held:
            return []
        verdicts = self._in_doubt([*self._given, *self._held], is_end=is_end)
        told = list[TrackedFrame]()
        for frame, in_doubt in zip(self._held, verdicts[len(self._given) :], strict=True):
            if in_doubt is None and len(self._held) - len(told) <= most_held:
                break
            told.append(taken_back(frame) if in_doubt else frame)
        self._given = self._telling([*self._given, *self._held[: len(told)]])
        del self._held[: len(told)]
        return told

    @abstractmethod
    def _in_doubt(self, frames: Sequence[TrackedFrame], *, is_end: bool) -> Sequence[bool | None]:
        """Tell of each frame whether its pose is not to be believed; None: later ones will tell."""

    @abstractmethod
    def _telling(self, given: list[TrackedFrame]) -> list[TrackedFrame]:
        """Return those of the frames given that tell something of later ones."""
