"""Holds poses back whose end leapt, and takes those back from which it leaps away again.

What a picture shows of a fold may be explained by a body that ends elsewhere. A worm's end does not
go two widths off and come back: it was never there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import nan

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Mask
from worm_msgs_py.contract.body import BodyState, TrackedFrame
from worm_tracker.waiting.judged_poses import JudgedPoses


@dataclass(frozen=True, slots=True)
class LeapingEndsSettings:
    """What is a leap of an end, and how long poses between two of them may be."""

    leap_widths: float = 0.9
    """How far an end is from where its velocity would take it, before and after, for that to be a
    leap: of 60 000 steps of 25 a second 90 were more, 26 of them to or from a wrong pose."""
    most_frames: int = 8
    """What lies between two leaps, and is no longer, is not the worm's way: of 19 such poses 14
    were wrong."""
    lone_leap_widths: float = 1.5
    most_lone_frames: int = 4
    """The same for a larger leap, where there is no pose to the other side: 6 of 11."""
    step_s: float = 0.04
    """Between frames that are farther apart a leap is larger, by the square of the time."""


class LeapingEnds(JudgedPoses):
    """Takes back the poses between two leaps of an end.

    A frame waits only behind a leap, or where the body was not told before it.

    Parameters
    ----------
    settings : LeapingEndsSettings
    """

    def __init__(self, settings: LeapingEndsSettings) -> None:
        super().__init__()
        self._settings = settings

    def _in_doubt(self, frames: Sequence[TrackedFrame], *, is_end: bool) -> list[bool | None]:
        return poses_in_doubt(frames, self._settings, is_end=is_end)

    def _telling(self, given: list[TrackedFrame]) -> list[TrackedFrame]:
        return given[-self._settings.most_frames - 3 :]


def poses_in_doubt(
    frames: Sequence[TrackedFrame], settings: LeapingEndsSettings, *, is_end: bool
) -> list[bool | None]:
    """Tell of each frame whether its pose lies between leaps; None where later ones have to tell.

    Parameters
    ----------
    frames : sequence of TrackedFrame
        In their order.
    settings : LeapingEndsSettings
    is_end : bool
        Whether no frame comes after them.
    """
    leaps = leaps_of(frames, settings.step_s)
    told = [frame.state.status.has_pose for frame in frames]
    both = _between(told, leaps > settings.leap_widths, settings.most_frames, 2, is_end)
    lone = _between(told, leaps > settings.lone_leap_widths, settings.most_lone_frames, 1, is_end)
    return [
        True if True in verdicts else None if None in verdicts else False
        for verdicts in zip(both, lone, strict=True)
    ]


def leaps_of(frames: Sequence[TrackedFrame], step_s: float) -> Floats:
    """Return how far an end leapt from each frame to the next, in widths of the body.

    That is how far it is from where its velocity before would have taken it, or that after would
    have brought it from, whichever is less. What both ends do alike is a jolt of the rig.

    Parameters
    ----------
    frames : sequence of TrackedFrame
        In their order.
    step_s : float
        Time over which that is a leap; where frames are farther apart, so many times less is told.

    Returns
    -------
    ndarray, shape (n - 1,)
        NaN where one of both frames has no pose.
    """
    states = [frame.state for frame in frames]
    velocities = [_velocity(one, other) for one, other in pairwise(states)]
    leaps = np.full(len(velocities), nan)
    for k, velocity in enumerate(velocities):
        if velocity is None:
            continue
        beside = [velocities[j] for j in (k - 1, k + 1) if 0 <= j < len(velocities)]
        changes = [velocity - other for other in beside if other is not None] or [velocity]
        elapsed_s = _elapsed_s(states[k], states[k + 1])
        leap_px = min(abs(change[0] - change[1]) for change in changes) * elapsed_s
        leaps[k] = leap_px / states[k].width_px / max(elapsed_s / step_s, 1.0) ** 2
    return leaps


def _velocity(one: BodyState, other: BodyState) -> Complex | None:
    """Return how fast both ends went from a frame to the next, pixels a second; None: not known."""
    elapsed_s = _elapsed_s(one, other)
    if not (one.status.has_pose and other.status.has_pose) or elapsed_s <= 0:
        return None
    if one.geometry != other.geometry:
        return None
    was, are = (_ends(state) for state in (one, other))
    ways = are - was, are[::-1] - was  # head and tail may have been exchanged in between
    way = min(ways, key=lambda each: float(np.abs(each).max()))
    return np.asarray(way / elapsed_s, np.complex128)


def _ends(state: BodyState) -> Complex:
    return np.array([complex(end.u_px, end.v_px) for end in (state.head, state.tail)])


def _elapsed_s(one: BodyState, other: BodyState) -> float:
    return (other.stamp_ns - one.stamp_ns) * 1e-9


def _between(
    told: Sequence[bool], leapt: Mask, most_frames: int, leaps_needed: int, is_end: bool
) -> list[bool | None]:
    """Tell of each frame whether it is one of few between leaps; None: the next ones will tell.

    Parameters
    ----------
    told : sequence of bool
        Whether a frame has a pose.
    leapt : ndarray of bool, shape (n - 1,)
        Whether an end leapt to the next frame.
    most_frames : int
        What is longer is the worm's way.
    leaps_needed : int
        2: there and back. 1: one of them will do where there is no pose to the other side.
    is_end : bool
        Whether no frame comes after these.
    """
    verdicts: list[bool | None] = [False] * len(told)
    first = 0
    while first < len(told):
        last = first
        while last + 1 < len(told) and told[first] and told[last + 1] and not leapt[last]:
            last += 1
        leapt_to = first > 0 and told[first - 1]
        may_be = first > 0 and leapt_to + 1 >= leaps_needed and last - first < most_frames
        if told[first] and may_be:
            # A leap to the last frame may be none: the next one tells how the end goes on.
            is_over = is_end or last + 2 < len(told) or (last + 2 == len(told) and not told[-1])
            leaps = leapt_to + (last + 1 < len(told) and told[last + 1])
            verdict = leaps >= leaps_needed if is_over else None
            verdicts[first : last + 1] = [verdict] * (last + 1 - first)
        first = last + 1
    return verdicts
