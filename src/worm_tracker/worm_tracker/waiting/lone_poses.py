"""Takes poses back that lie alone amid coils: a wrong body may explain one picture of many.

Most of the pictures about it are not understood, so that the body had been lost before it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.status import Status
from worm_tracker.waiting.judged_poses import JudgedPoses


@dataclass(frozen=True, slots=True)
class LonePoseSettings:
    """When a body is told by too few of the frames about it to be believed in one."""

    about_s: float = 0.2
    """How far from a frame those are that are asked."""
    least_part_coiled: float = 0.6
    """Part of them that are coiled: of 78 739 frames of 80 films with a certain head 15 have so
    many about them, 6 of them wrong, of 39 wrong ones in all; of the 84 with half, 8."""


class LonePoses(JudgedPoses):
    """Takes back the poses amid coils.

    A frame waits only where one before it was coiled: an open worm is told at once.

    Parameters
    ----------
    settings : LonePoseSettings
    """

    def __init__(self, settings: LonePoseSettings) -> None:
        super().__init__()
        self._settings = settings

    def _in_doubt(self, frames: Sequence[TrackedFrame], *, is_end: bool) -> list[bool | None]:
        return [is_lone(frames, at, self._settings, is_end=is_end) for at in range(len(frames))]

    def _telling(self, given: list[TrackedFrame]) -> list[TrackedFrame]:
        return _about(given, given[-1], self._settings.about_s) if given else given


def is_lone(
    frames: Sequence[TrackedFrame], at: int, settings: LonePoseSettings, *, is_end: bool
) -> bool | None:
    """Tell whether a frame tells a body amid coils; None where later ones have to tell.

    Parameters
    ----------
    frames : sequence of TrackedFrame
        In their order.
    at : int
        Which of them is asked for.
    settings : LonePoseSettings
    is_end : bool
        Whether no frame comes after them.
    """
    frame, later = frames[at], frames[at + 1 :]
    before = _about(frames[:at], frame, settings.about_s)
    if _is_coiled(frame) or not any(map(_is_coiled, before)):
        return False
    behind = _about(later, frame, settings.about_s)
    if not (is_end or len(behind) < len(later)):
        return None
    about = [_is_coiled(each) for each in (*before, *behind)]
    is_amid = any(map(_is_coiled, behind))
    return is_amid and sum(about) >= settings.least_part_coiled * len(about)


def _about(
    frames: Sequence[TrackedFrame], frame: TrackedFrame, most_s: float
) -> list[TrackedFrame]:
    """Return those of some frames that are no farther in time from one than that."""
    now_ns = frame.state.stamp_ns
    return [each for each in frames if abs(each.state.stamp_ns - now_ns) <= 1e9 * most_s]


def _is_coiled(frame: TrackedFrame) -> bool:
    return frame.state.status is Status.COILED
