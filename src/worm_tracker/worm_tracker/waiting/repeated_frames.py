"""Frames whose pictures repeat the one before: they wait for it, and are given without a pose."""

from collections import deque
from collections.abc import Sequence

from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.chamber import Geometry
from worm_msgs_py.contract.status import Status
from worm_tracker.observation import Observation
from worm_tracker.waiting.frame_state import PendingFrame, tracked_frame


class RepeatedFrames:
    """Holds frames that repeat a picture until those before them are given.

    Such a picture says nothing of its own time: the worm has moved on since it was taken.
    """

    def __init__(self) -> None:
        self._waiting: deque[PendingFrame] = deque()
        self._next = 0
        self._home = ""

    def __len__(self) -> int:
        return len(self._waiting)

    def hold(self, frame: int, stamp_ns: int, geometry: Geometry | None) -> None:
        """Take a frame that repeats the picture before."""
        seen = Observation(Status.BAD_IMAGE)
        self._waiting.append(PendingFrame(frame, stamp_ns, seen, geometry))

    def among(self, frames: Sequence[TrackedFrame]) -> list[TrackedFrame]:
        """Return the next frames that are given, in their order, and those held between them."""
        given = list[TrackedFrame]()
        for frame in frames:
            given += self._due()
            given.append(frame)
            self._next, self._home = frame.state.frame + 1, frame.state.frame_id
        return given + self._due()

    def _due(self) -> list[TrackedFrame]:
        due = []
        while self._waiting and self._waiting[0].frame == self._next:
            repeated = self._waiting.popleft()
            due.append(tracked_frame(repeated, True, 0.5, home=self._home))
            self._next += 1
        return due
