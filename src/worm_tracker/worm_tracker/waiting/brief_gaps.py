"""Tells what of a folded body was not known for a moment, from the frames to either side.

An end goes under the body and comes out again within some frames. Where it went meanwhile is known
from where it was before and after, and how it moved there: surely enough, or if what was supposed
of it in between lies near there, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.contract.status import Status
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import body_of
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.lone_ends import (
    LoneEndSettings,
    lies_folded,
    may_be_lone,
    without_lone_ends,
)
from worm_tracker.waiting.smooth_motion import (
    SmoothMotionSettings,
    bridged,
    unsteadiness_of,
)


@dataclass(frozen=True, slots=True)
class BriefGapSettings:
    """When a part of the body that was not told in a frame is known from those to either side."""

    most_gap_s: float = 1.05
    """Between the frames that tell it, before and after: over longer gaps, up to 1.6 s, 61 more
    frames were told, 13 of them wrong."""
    beside_s: float = 0.14
    least_frames_beside: int = 2
    least_part_beside: float = 0.5
    """Of the frames that come so soon before the gap, and after it, so many must tell it: one
    alone, where it is hidden all around, may be wrong."""
    moment_s: float = 0.09
    least_frames_about_moment: int = 3
    """Over a gap as short as this so many must on both sides together, one on either at least."""
    most_step_widths: float = 1.2
    step_s: float = 0.04
    """How far it goes in so long in those frames: a leap may be to or from where it never was."""
    most_sd_widths: float = 0.35
    """How unsure the way that it moved may leave it, where that alone tells it."""
    most_misfit_sds: float = 1.5
    """How far from that way it may lie in a frame that tells it, in standard deviations: else one
    of these may be wrong. In one of six films that were drawn when this was not asked yet three
    frames more were wrong, which begin and end with an end told 0.8 widths off."""
    most_stretch: float = 1.25
    """By what the points of a midline, which lie evenly, may lie farther apart where it joins: of
    141 ends more that were told in skins 38 did, and 6 of the 9 wrong ones."""
    most_apart_widths: float = 0.7
    """How far it may be supposed from a straight way where it is less sure. Of 856 ends hidden in
    folded frames of 88 films that are told one way or the other 7 were wrong; of 740 by a straight
    way alone 6."""
    motion: SmoothMotionSettings = field(default_factory=SmoothMotionSettings)
    lone_ends: LoneEndSettings = field(default_factory=LoneEndSettings)

    @property
    def reach_s(self) -> float:
        """How far from a frame those are that tell more of it, at most."""
        return self.most_gap_s + self.beside_s


@dataclass(frozen=True, eq=False, slots=True)
class _Ways:
    """Where points of a body may be that is not told, NaN where too few frames tell it.

    Attributes
    ----------
    straight : ndarray, shape (n, 2)
        On a straight way from the last frame that tells them to the next.
    smooth : ndarray, shape (n, 2)
        As they moved in the frames before and after; NaN, too, where these contradict each other.
    sd_px : ndarray, shape (n,)
        How unsure that is: standard deviation along one axis.
    """

    straight: Floats
    smooth: Floats
    sd_px: Floats

    @classmethod
    def unknown(cls, count: int) -> "_Ways":
        """Return those of so many points of which nothing is known."""
        return cls(np.full((count, 2), np.nan), np.full((count, 2), np.nan), np.full(count, np.nan))


class BriefGaps:
    """Takes frames in their order, and tells what those to either side tell of each.

    Parameters
    ----------
    settings : BriefGapSettings
    """

    def __init__(self, settings: BriefGapSettings) -> None:
        self._settings = settings
        # Those given last, as they were before others told more of them.
        self._given: list[PendingFrame] = []

    def ready(self, frames: Sequence[PendingFrame], count: int, newest_ns: int) -> int:
        """Return how many of the first frames need not wait for what those after them tell.

        Parameters
        ----------
        frames : sequence of PendingFrame
            Those that come next, in their order.
        count : int
            How many of them could be given now.
        newest_ns : int
            Stamp of the last frame taken, which may be behind these.
        """
        settings, last_ns = self._settings, frames[-1].stamp_ns
        known, before = [*self._given, *frames], len(self._given)
        for k in range(count):
            if may_be_lone(known, before + k, settings.lone_ends):
                told: PendingFrame | None = frames[k]
            elif _may_be_told(frames[k].observation):
                rest = frames[k + 1 :]
                told = next((each for each in rest if each.observation.status.has_pose), None)
            else:
                continue
            is_known = told is not None and last_ns - told.stamp_ns >= settings.beside_s * 1e9
            if not is_known and newest_ns - frames[k].stamp_ns < settings.reach_s * 1e9:
                return k
        return count

    def tell(self, frames: Sequence[PendingFrame], count: int) -> list[Observation]:
        """Return what is told of the first frames; they are not asked for again.

        Parameters
        ----------
        frames : sequence of PendingFrame
            Those that come next, in their order, and their midlines in one order of the ends.
        count : int
            How many of them are given now.
        """
        before = len(self._given)
        known = [*self._given, *self._near(frames, count)]
        asked = range(before, before + count)
        told = [self._shown(known, at).observation for at in asked]
        if any(map(_may_be_told, told)):  # hardly ever of an open worm
            shown = [self._shown(known, at) for at in range(len(known))]
            told = [told_over_gap(shown, at, self._settings) for at in asked]
        if count:
            self._given = self._last_of(known[: before + count])
        return told

    def _near(self, frames: Sequence[PendingFrame], count: int) -> Sequence[PendingFrame]:
        """Return the first frames, and those after them that may tell more of them."""
        until_ns = frames[count - 1].stamp_ns + self._kept_s * 1e9 if count else 0
        return [each for k, each in enumerate(frames) if k < count or each.stamp_ns <= until_ns]

    def _shown(self, known: Sequence[PendingFrame], at: int) -> PendingFrame:
        """Return one of some frames with what it alone tells of an end hidden."""
        seen = without_lone_ends(known, at, self._settings.lone_ends)
        return known[at] if seen is known[at].observation else replace(known[at], observation=seen)

    @property
    def _kept_s(self) -> float:
        """How far from a frame those are that tell more of it, or of those that do."""
        return self._settings.reach_s + self._settings.lone_ends.beside_s

    def _last_of(self, given: Sequence[PendingFrame]) -> list[PendingFrame]:
        """Return those of the last frames that tell something of one to come, without pictures."""
        kept_ns = self._kept_s * 1e9
        return [
            replace(each, observation=replace(each.observation, unresolved=None, kept=None))
            for each in given
            if given[-1].stamp_ns - each.stamp_ns < kept_ns
        ]


def told_over_gap(
    frames: Sequence[PendingFrame], at: int, settings: BriefGapSettings
) -> Observation:
    """Return what is told of a frame once those to either side of it are known.

    An end is told where it was by how it moved before and after, where that is known surely; else
    midway between where it was supposed, by how the body was followed, and a straight way from the
    last frame that shows it to the next, if that is near. So is all of a body that was followed
    only.

    Parameters
    ----------
    frames : sequence of PendingFrame
        In their order, and their midlines all head first or all tail first. Those farther off than
        a gap may be long tell nothing.
    at : int
        Which of them is told.
    settings : BriefGapSettings

    Returns
    -------
    Observation
        As it was where that does not tell all that is hidden of a folded body.
    """
    seen, stamp_ns = frames[at].observation, frames[at].stamp_ns
    body = body_of(seen)
    if body is None or any(body.broad_ends) or not _may_be_told(seen):
        return seen
    wanted = np.ones(len(body.points), bool)
    if seen.has_midline:
        wanted = ~body.shown_points
    ways = _by_motion(_beside(frames, at, settings.reach_s), stamp_ns, wanted, settings)
    told = _moved_there(body, ways, settings) if seen.has_midline else None
    if not seen.has_midline:
        body = _in_order_of(ways.straight, body)
    told = told or _supposed_there(body, ways.straight, wanted, settings)
    if told is None:
        return seen
    loops_known = not seen.has_midline or seen.loops_known
    return replace(
        told,
        status=Status.FOLDED if loops_known else Status.LOOP_IN_DOUBT,
        occluded=(0, 0),
        in_doubt=(0, 0) if loops_known else body.in_doubt,
    )


def _moved_there(body: Observation, ways: _Ways, settings: BriefGapSettings) -> Observation | None:
    """Return a body with its hidden ends where they moved; None where that is not known surely."""
    between, sd_px = ways.smooth, ways.sd_px
    wanted, every = ~body.shown_points, np.arange(len(body.points))
    # What is not known, as too few frames tell it, is moved along with what is next to it.
    known = ~wanted | (sd_px < settings.most_sd_widths * body.width)
    if not known[[0, -1]].all():
        return None
    away = np.where(wanted[:, np.newaxis], between - body.points, 0.0)[known].T
    moved = np.stack([np.interp(every, every[known], each) for each in away], axis=1)
    points = body.points + moved
    steps = np.hypot(*np.diff(points, axis=0).T)
    if steps.max() > settings.most_stretch * np.median(steps):
        return None
    first, last = (
        float(sd_px[tip]) if wanted[tip] else sd
        for tip, sd in zip((0, -1), body.end_sd_px, strict=True)
    )
    return replace(body, points=points, end_sd_px=(first, last))


def _supposed_there(
    body: Observation, between: Floats, wanted: Mask, settings: BriefGapSettings
) -> Observation | None:
    """Return a body midway to a straight way, if it was supposed near there; else None."""
    away = np.hypot(*(body.points - between)[wanted].T)
    if not np.all(away < settings.most_apart_widths * body.width):  # nor where one is NaN
        return None
    points = body.points.copy()
    points[wanted] = (points + between)[wanted] / 2
    return replace(body, points=points)


def _beside(frames: Sequence[PendingFrame], at: int, reach_s: float) -> Sequence[PendingFrame]:
    """Return a frame and those next to it that are no farther away than that."""

    def is_near(k: int) -> bool:
        return abs(frames[k].stamp_ns - frames[at].stamp_ns) < reach_s * 1e9

    first, behind = at, at + 1
    while first > 0 and is_near(first - 1):
        first -= 1
    while behind < len(frames) and is_near(behind):
        behind += 1
    return frames[first:behind]


def _may_be_told(seen: Observation) -> bool:
    """Tell whether a body has no pose because it lies folded."""
    body = body_of(seen)
    return body is not None and not seen.status.has_pose and lies_folded(body)


def _by_motion(
    frames: Sequence[PendingFrame], now_ns: int, wanted: Mask, settings: BriefGapSettings
) -> _Ways:
    """Return where points of a body are by where they were told before and after.

    Parameters
    ----------
    frames : sequence of PendingFrame
        Those before and after.
    now_ns : int
        Stamp for which it is asked.
    wanted : ndarray of bool, shape (n,)
        Which points are asked for.
    settings : BriefGapSettings
    """
    ways = _Ways.unknown(len(wanted))
    after_s = np.array([each.stamp_ns - now_ns for each in frames]) * 1e-9
    has_body = np.array([each.observation.has_midline for each in frames])
    bodies = [each.observation for each in frames if each.observation.has_midline]
    if not bodies:
        return ways
    lines, width = np.array([body.points for body in bodies]), bodies[0].width
    told = np.array([body.told_points for body in bodies])
    seen_sd_px = np.array([body.seen_end_sd_px for body in bodies])
    for telling in np.unique(told[:, wanted], axis=1).T:
        alike = wanted & (told == telling[:, np.newaxis]).all(axis=0)
        told_s, points = after_s[has_body][telling], lines[telling][:, alike]
        if not _is_brief(after_s, told_s, settings) or _leaps(told_s, points, width, settings):
            continue
        k = int(np.searchsorted(told_s, 0.0))
        part = told_s[k - 1] / (told_s[k - 1] - told_s[k])
        ways.straight[alike] = (1 - part) * points[k - 1] + part * points[k]
        nearer_end = (np.flatnonzero(alike) >= len(wanted) / 2).astype(int)
        sd = seen_sd_px[telling][:, nearer_end] / width
        smooth, now_sd, misfit = _moved_on(told_s, points / width, sd, settings)
        if misfit < settings.most_misfit_sds:
            ways.smooth[alike], ways.sd_px[alike] = width * smooth, width * now_sd
    return ways


def _moved_on(
    told_s: Floats, points: Floats, sd: Floats, settings: BriefGapSettings
) -> tuple[Floats, Floats, float]:
    """Return where points are now by how they moved before and after, see `bridged`.

    Parameters
    ----------
    told_s : ndarray, shape (n,)
        When they are told, seconds from now.
    points : ndarray, shape (n, m, 2)
        Widths.
    sd : ndarray, shape (n, m)
        How unsure they are, widths.
    settings : BriefGapSettings
    """
    k = int(np.searchsorted(told_s, 0.0))
    known = told_s < told_s[k] + settings.beside_s  # `BriefGaps.ready` waits for no more
    unsteadiness = unsteadiness_of(told_s[known], points[known], settings.motion)
    beside = known & (told_s > told_s[k - 1] - settings.beside_s)
    sd = np.maximum(sd[beside], settings.motion.least_sd_widths)
    return bridged(told_s[beside], points[beside], sd, 0.0, unsteadiness)


def _is_brief(frames_s: Floats, told_s: Floats, settings: BriefGapSettings) -> bool:
    """Tell whether a point is told soon before and after now, and by enough frames to either side.

    Parameters
    ----------
    frames_s, told_s : ndarray
        When all frames were, and those that tell the point; seconds from now.
    settings : BriefGapSettings
    """
    if (np.diff(told_s) <= 0).any():  # stamps that do not increase tell no time
        return False
    before, behind = told_s[told_s < 0], told_s[told_s > 0]
    if not (len(before) and len(behind)) or behind[0] - before[-1] > settings.most_gap_s:
        return False
    about = np.count_nonzero(before[-1] - before < settings.beside_s)
    about += np.count_nonzero(behind - behind[0] < settings.beside_s)
    is_moment = behind[0] - before[-1] < settings.moment_s
    if is_moment and about >= settings.least_frames_about_moment:
        return True
    for told_ago_s, ago_s in (
        (before[-1] - before, before[-1] - frames_s),
        (behind - behind[0], frames_s - behind[0]),
    ):
        telling = np.count_nonzero(told_ago_s < settings.beside_s)
        count = np.count_nonzero((ago_s >= 0) & (ago_s < settings.beside_s))
        if telling < max(settings.least_frames_beside, settings.least_part_beside * count):
            return False
    return True


def _leaps(told_s: Floats, points: Floats, width: float, settings: BriefGapSettings) -> bool:
    """Tell whether points, shape (frames, n, 2), leap in one of the frames beside a gap."""
    steps_px = np.hypot(*np.moveaxis(np.diff(points, axis=0), 2, 0)).max(axis=1)
    steps = np.maximum(np.diff(told_s) / settings.step_s, 1.0)
    k = int(np.searchsorted(told_s, 0.0))
    first, behind = told_s[k - 1] - settings.beside_s, told_s[k] + settings.beside_s
    beside = (told_s[:-1] > first) & (told_s[1:] < behind)
    return bool((steps_px > settings.most_step_widths * width * steps)[beside].any())


def _in_order_of(between: Floats, body: Observation) -> Observation:
    """Return a body with its ends in the order of other points of it; NaN tells nothing."""
    known = np.isfinite(between[:, 0])
    ways = (body, body.reversed())
    return min(ways, key=lambda way: float(np.hypot(*(way.points - between)[known].T).sum()))
