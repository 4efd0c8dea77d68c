"""Doubts the loops of a fold that are told otherwise from one frame to the next.

A way into a fold and a way back may each tell a loop its own way round, in frames that alternate
or meet. One of them is wrong, and in all of its frames.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations
from math import ceil, nan

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.status import Status
from worm_tracker.midline.body_model import is_nearer_reversed
from worm_tracker.midline.curve import length_of
from worm_tracker.midline.moved_aside import moved_aside_px
from worm_tracker.observation import Observation


@dataclass(frozen=True, slots=True)
class ContradictionSettings:
    """When two frames tell a body so that at most one of them is right."""

    most_aside_widths: float = 1.0
    step_s: float = 0.04
    """How far aside a body moves in so long, or less. Of 46 000 pairs of frames told right, in 55
    films, none was more than 0.84 widths aside; of worms that fold as fast as any, 0.93."""
    most_apart_s: float = 0.14
    """After longer times it may be anywhere."""
    most_along_widths: float = 3.0
    """How far along itself it slides meanwhile."""
    end_widths: float = 1.5
    """How much of either end is not asked: it goes where it wants."""
    beside_widths: float = 0.5
    least_part_widths: float = 4.0
    """From how far aside on a point is told otherwise, and of how long a part they must be. A bend
    that slides along the body lies more than a width aside in 11 of 2000 frames told right, over up
    to two widths; a loop is longer."""
    most_between_ways_widths: float = 1.0
    """How far apart two ways may tell any point of a body in one frame, both for certain. Three
    frames of 50 films were farther apart, and one of both was wrong in each."""
    most_gap_widths: float = 1.5
    most_slid_widths: float = 3.0
    """How near to each other the strands come between which a loop lies, and how far along the body
    from where they did: where they do not, it is open, and another one."""


def in_doubt_where_contradicted(
    stamps_ns: Sequence[int],
    told: Sequence[Observation],
    otherwise: Mapping[int, Observation],
    settings: ContradictionSettings,
) -> list[Observation]:
    """Return what is told of a fold, in doubt what its frames, or both ways, tell otherwise.

    In all frames to either side in which the loop is closed: which of both is wrong, and since
    when, is not known.

    Parameters
    ----------
    stamps_ns : sequence of int
        Of its frames, in their order.
    told : sequence of Observation
        What is told of them.
    otherwise : mapping of int to Observation
        What another way tells of some, by their place in that order.
    settings : ContradictionSettings
    """
    in_order = _in_one_order(told)
    doubts = dict[int, tuple[int, int]]()
    poses = [k for k in in_order if told[k].shows_pose]
    for one, other in [*((k, k) for k in poses if k in otherwise), *pairwise(poses)]:
        elapsed_s = 1e-9 * (stamps_ns[other] - stamps_ns[one])
        if other > one and not 0 < elapsed_s <= settings.most_apart_s:
            continue
        known = in_order[one]
        seen = in_order[other] if other > one else _with_ends_as(known, otherwise[one])
        part = contradicted(known, seen, elapsed_s, settings)
        if part is None or contradicted(known, seen.reversed(), elapsed_s, settings) is None:
            continue  # with its ends side by side a body may be in either order
        for k, loop in _loops_about(in_order, one, other, part, settings):
            doubts[k] = _both(doubts.get(k, loop), loop)
    given = [
        each if k not in doubts else _doubted(each, doubts[k], in_order[k] is not each)
        for k, each in enumerate(told)
    ]
    for k, seen in otherwise.items():
        if given[k].apart_px(seen) > settings.most_between_ways_widths * seen.width:
            given[k] = _untold(given[k])
    return given


def contradicted(
    one: Observation, other: Observation, elapsed_s: float, settings: ContradictionSettings
) -> tuple[int, int] | None:
    """Return which part of a body two midlines tell so that at most one of them is right.

    Parameters
    ----------
    one, other : Observation
        Of one frame or of two, in one order of the ends.
    elapsed_s : float
        Time between these.
    settings : ContradictionSettings

    Returns
    -------
    tuple of int, or None
        From which of the points to before which; None where both may be right.
    """
    most = settings.most_aside_widths * max(elapsed_s / settings.step_s, 1)
    told = one.told_points & other.told_points
    if np.hypot(*(one.points - other.points)[told].T).max(initial=0.0) <= most * one.width:
        return None
    aside_widths = _aside_widths(one, other, settings)
    if not (aside_widths > most).any():
        return None
    beside = np.flatnonzero(aside_widths > settings.beside_widths)
    part = int(beside[0]), 1 + int(beside[-1])
    least = _points_over(settings.least_part_widths, one)
    return part if part[1] - part[0] >= least else None


def _points_over(widths: float, body: Observation) -> int:
    """Return how many of a midline's points are on so many widths of it."""
    return ceil(widths * body.width * (len(body.points) - 1) / length_of(body.points))


def _aside_widths(one: Observation, other: Observation, settings: ContradictionSettings) -> Floats:
    """Return how far aside the points of two midlines are, both ways; NaN: not told, or an end."""
    lines = [np.where(each.told_points[:, np.newaxis], each.points, nan) for each in (one, other)]
    most_px = settings.most_along_widths * one.width
    aside_px = np.fmax(*(moved_aside_px(a, b, most_px) for a, b in permutations(lines)))
    end = _points_over(settings.end_widths, one)
    aside_px[:end] = aside_px[len(aside_px) - end :] = nan
    return aside_px / one.width


def _in_one_order(told: Sequence[Observation]) -> dict[int, Observation]:
    """Return the bodies that some frames tell, by their places, all in the order of the first."""
    in_order = dict[int, Observation]()
    last: int | None = None
    for k, seen in enumerate(told):
        if not seen.has_midline:
            continue
        if last is None:
            in_order[k] = seen
        elif seen.path_number and seen.path_number == told[last].path_number:
            in_order[k] = seen if in_order[last] is told[last] else seen.reversed()
        else:
            in_order[k] = _with_ends_as(in_order[last], seen)
        last = k
    return in_order


def _with_ends_as(before: Observation, seen: Observation) -> Observation:
    """Return a body with its ends in the order of another one, by where they are, told or not."""
    ends, were = seen.points[[0, -1]], before.points[[0, -1]]
    return seen.reversed() if is_nearer_reversed(ends, were) else seen


def _loops_about(
    told: Mapping[int, Observation],
    one: int,
    other: int,
    part: tuple[int, int],
    settings: ContradictionSettings,
) -> Iterator[tuple[int, tuple[int, int]]]:
    """Return the frames about two of them in which a part of the body is a loop, and that loop."""
    before = [k for k in told if k <= one][::-1]
    behind = [k for k in told if k >= other]
    for way in (before, behind):
        for k in way:
            loop = _loop(told[k], part, settings)
            if loop is None:
                break
            yield k, loop


def _loop(
    body: Observation, part: tuple[int, int], settings: ContradictionSettings
) -> tuple[int, int] | None:
    """Return a part of a body up to where the strands at its ends meet; None where they do not.

    Nor where its contour shows all of it.
    """
    if body.status is Status.TRACKED:
        return None
    slid = min(_points_over(settings.most_slid_widths, body), (part[1] - part[0]) // 4)
    from_, last = max(part[0] - slid, 0), max(part[1] - 1 - slid, 0)
    strands = body.points[from_ : part[0] + slid + 1], body.points[last : part[1] + slid]
    apart_px = np.linalg.norm(strands[0][:, np.newaxis] - strands[1], axis=2)
    if apart_px.min() > settings.most_gap_widths * body.width:
        return None
    at_first, at_last = np.unravel_index(apart_px.argmin(), apart_px.shape)
    return _both(part, (from_ + int(at_first), 1 + last + int(at_last)))


def _both(one: tuple[int, int], other: tuple[int, int]) -> tuple[int, int]:
    """Return the part that holds two parts."""
    return min(one[0], other[0]), max(one[1], other[1])


def _doubted(seen: Observation, part: tuple[int, int], is_reversed: bool) -> Observation:
    """Return a body with one more part in doubt, given in its order or the other one.

    Not told where little else is.
    """
    if is_reversed:
        part = len(seen.points) - part[1], len(seen.points) - part[0]
    part = part if seen.loops_known else _both(part, seen.in_doubt)
    status = Status.END_HIDDEN if any(seen.occluded) else Status.LOOP_IN_DOUBT
    doubted = replace(seen, status=status, in_doubt=part)
    return _untold(doubted) if doubted.is_mostly_hidden else doubted


def _untold(seen: Observation) -> Observation:
    """Return a body as one that is followed only."""
    coil = Observation(Status.COILED, seen.u, seen.v, followed=seen)
    return replace(coil, unresolved=seen.unresolved, kept=seen.kept)
