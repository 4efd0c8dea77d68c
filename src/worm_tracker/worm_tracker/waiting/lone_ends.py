"""Hides an end of a folded body that one frame tells while those about it do not.

An end goes under the body, and for a frame amid many that hide it seems to be seen: mostly where
something else ends, or by noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

from worm_msgs_py.contract.status import Status
from worm_tracker.midline.curve import as_complex, length_of
from worm_tracker.midline.self_cover import lies_near_itself
from worm_tracker.observation import Observation
from worm_tracker.waiting.frame_state import PendingFrame


@dataclass(frozen=True, slots=True)
class LoneEndSettings:
    """When an end that a frame tells is held to be hidden, as it is in the frames about it."""

    beside_s: float = 0.14
    """How far from a frame those are that are asked."""
    most_part: float = 0.25
    """Part of them that may tell the end, too. Of 43 frames of 44 films of which that is
    so 10 were wrong; of those of which up to a third do 13 of 115."""


def without_lone_ends(
    frames: Sequence[PendingFrame], at: int, settings: LoneEndSettings
) -> Observation:
    """Return what a frame says, with an end hidden that hardly any frame about it tells.

    Parameters
    ----------
    frames : sequence of PendingFrame
        In their order, and their midlines all head first or all tail first.
    at : int
        Which of them is asked for.
    settings : LoneEndSettings
    """
    seen = frames[at].observation
    if not tells_ends(seen):
        return seen
    beside = [*_before(frames, at, settings), *_behind(frames, at, settings)]
    lone = [bool(beside) and _part_telling(beside, end) <= settings.most_part for end in (0, 1)]
    if not any(lone) or not lies_folded(seen):
        return seen
    return with_ends_hidden(seen, lone)


def may_be_lone(frames: Sequence[PendingFrame], at: int, settings: LoneEndSettings) -> bool:
    """Tell whether frames to come may still say that an end of a frame is hidden.

    They cannot where enough of those before it tell both.
    """
    seen = frames[at].observation
    if not tells_ends(seen):
        return False
    before = _before(frames, at, settings)
    # As many may follow that tell neither.
    enough = before and min(_part_telling(before, end) for end in (0, 1)) > 2 * settings.most_part
    return not enough and lies_folded(seen)


def with_ends_hidden(seen: Observation, hidden: Sequence[bool]) -> Observation:
    """Return what is seen with two widths of the first or the last end hidden."""
    count = 1 + ceil(2 * seen.width * (len(seen.points) - 1) / length_of(seen.points))
    first, last = (count if each else 0 for each in hidden)
    return replace(seen, status=Status.END_HIDDEN, occluded=(first, last))


def tells_ends(seen: Observation) -> bool:
    """Tell whether both ends of a body are told."""
    return seen.has_midline and seen.status.has_pose and not any(seen.occluded)


def lies_folded(body: Observation) -> bool:
    """Tell whether a body lies near itself."""
    step = length_of(body.points) / (len(body.points) - 1)
    return lies_near_itself(as_complex(body.points), body.width, step)


def _before(
    frames: Sequence[PendingFrame], at: int, settings: LoneEndSettings
) -> list[Observation]:
    """Return what is seen of the worm in the frames soon before one."""
    return _seen_near(frames, at, range(at - 1, -1, -1), settings)


def _behind(
    frames: Sequence[PendingFrame], at: int, settings: LoneEndSettings
) -> list[Observation]:
    """Return what is seen of the worm in the frames soon after one."""
    return _seen_near(frames, at, range(at + 1, len(frames)), settings)


def _seen_near(
    frames: Sequence[PendingFrame], at: int, others: range, settings: LoneEndSettings
) -> list[Observation]:
    """Return what is seen of the worm in others of the frames, up to the first too far away.

    A picture that shows no worm, or none that was good, hides no end.
    """
    found = list[Observation]()
    for k in others:
        if abs(frames[k].stamp_ns - frames[at].stamp_ns) > settings.beside_s * 1e9:
            break
        seen = frames[k].observation
        if seen.has_midline or seen.status is Status.COILED:
            found.append(seen)
    return found


def _part_telling(seen: Sequence[Observation], end: int) -> float:
    """Return in which part of some observations an end is told, the first (0) or the last (1)."""
    return sum(each.has_midline and not each.occluded[end] for each in seen) / len(seen)
