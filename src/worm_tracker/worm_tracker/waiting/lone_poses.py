"""Takes poses back that lie alone amid coils: a wrong body may explain one picture of many.

Most of the pictures about it are not understood, so that the body had been lost before it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.status import Status
from worm_tracker.waiting.frame_state import taken_back


@dataclass(frozen=True, slots=True)
class LonePoseSettings:
    """When a body is told by too few of the frames about it to be believed in one."""

    about_s: float = 0.2
    """How far from a frame those are that are asked."""
    least_part_coiled: float = 0.6
    """Part of them that are coiled: of 78 739 frames of 80 films with a certain head 15 have so
    many about them, 6 of them wrong, of 39 wrong ones in all; of the 84 with half, 8."""


class LonePoses:
    """Takes frames in their order, and gives them in it once it is known which lie amid coils.

    A frame waits only where one before it was coiled: an open worm is told at once.

    Parameters
    ----------
    settings : LonePoseSettings
    """

    def __init__(self, settings: LonePoseSettings) -> None:
        self._settings = settings
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
        told = list[TrackedFrame]()
        while self._held:
            is_lone = self._is_lone(is_end)
            if is_lone is None and len(self._held) <= most_held:
                break
            frame = self._held.pop(0)
            told.append(taken_back(frame) if is_lone else frame)
            self._given = [*self._near(self._given, frame), frame]
        return told

    def _is_lone(self, is_end: bool) -> bool | None:
        """Tell whether the first frame that waits lies amid coils; None where later ones tell."""
        frame, *later = self._held
        before, behind = self._near(self._given, frame), self._near(later, frame)
        if _is_coiled(frame) or not any(map(_is_coiled, before)):
            return False
        if not (is_end or len(behind) < len(later)):
            return None
        about = [_is_coiled(each) for each in (*before, *behind)]
        is_amid = any(map(_is_coiled, behind))
        return is_amid and sum(about) >= self._settings.least_part_coiled * len(about)

    def _near(self, frames: Sequence[TrackedFrame], frame: TrackedFrame) -> list[TrackedFrame]:
        """Return those of some frames that are as near in time to one as those that are asked."""
        most_ns, now_ns = 1e9 * self._settings.about_s, frame.state.stamp_ns
        return [each for each in frames if abs(each.state.stamp_ns - now_ns) <= most_ns]


def _is_coiled(frame: TrackedFrame) -> bool:
    return frame.state.status is Status.COILED
