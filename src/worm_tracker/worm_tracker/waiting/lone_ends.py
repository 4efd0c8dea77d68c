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
    if not _tells_ends(seen):
        return seen
    beside = [each.observation for each in _others_about(frames, at, settings.beside_s)]
    lone = [beside and _part_telling(beside, end) <= settings.most_part for end in (0, 1)]
    if not any(lone) or not _is_folded(seen):
        return seen
    count = 1 + ceil(2 * seen.width * (len(seen.points) - 1) / length_of(seen.points))
    first, last = (count if each else 0 for each in lone)
    return replace(seen, status=Status.END_HIDDEN, occluded=(first, last))


def may_be_lone(frames: Sequence[PendingFrame], at: int, settings: LoneEndSettings) -> bool:
    """Tell whether frames to come may still say that an end of a frame is hidden.

    They cannot where enough of those before it tell both.
    """
    seen = frames[at].observation
    if not _tells_ends(seen):
        return False
    before = [each.observation for each in _others_about(frames[: at + 1], at, settings.beside_s)]
    # As many may follow that tell neither.
    enough = before and min(_part_telling(before, end) for end in (0, 1)) > 2 * settings.most_part
    return not enough and _is_folded(seen)


def _tells_ends(seen: Observation) -> bool:
    """Tell whether both ends of a body are told."""
    return seen.has_midline and seen.status.has_pose and not any(seen.occluded)


def _is_folded(seen: Observation) -> bool:
    """Tell whether a body lies near itself."""
    step = length_of(seen.points) / (len(seen.points) - 1)
    return lies_near_itself(as_complex(seen.points), seen.width, step)


def _others_about(frames: Sequence[PendingFrame], at: int, beside_s: float) -> list[PendingFrame]:
    """Return the frames next to one that are no farther away than that, itself left out."""
    found = list[PendingFrame]()
    for side in (reversed(frames[:at]), iter(frames[at + 1 :])):
        for each in side:
            if abs(each.stamp_ns - frames[at].stamp_ns) > beside_s * 1e9:
                break
            found.append(each)
    return found


def _part_telling(seen: Sequence[Observation], end: int) -> float:
    """Return in which part of some observations an end is told, the first (0) or the last (1)."""
    return sum(each.has_midline and not each.occluded[end] for each in seen) / len(seen)
