"""Tells what of a folded body was not known for a moment, from the frames to either side.

An end goes under the body and comes out again within some frames. Where it went meanwhile is known
from where it was before and after, and how it moved there: surely enough, or if what was supposed
of it in between lies near there, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import ceil, floor

import numpy as np
from scipy.spatial.distance import cdist

from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.contract.status import Status
from worm_tracker.midline.curve import as_complex, complex_arc_length, length_of, resample
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import body_of
from worm_tracker.waiting.ends_off_way import (
    EndsOffWaySettings,
    may_be_off_their_way,
    without_ends_off_their_way,
)
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.lone_ends import (
    LoneEndSettings,
    lies_folded,
    may_be_lone,
    without_lone_ends,
)
from worm_tracker.waiting.ways_between import WaysBetween, WaysBetweenSettings, ways_between


@dataclass(frozen=True, slots=True)
class BriefGapSettings:
    """When a part of the body that was not told in a frame is known from those to either side."""

    most_sd_widths: float = 0.35
    """How unsure the way that it moved may leave it, where that alone tells it."""
    most_misfit_sds: float = 1.5
    """How far from that way it may lie in a frame that tells it, in standard deviations: else one
    of these may be wrong. In one of six films that were drawn when this was not asked yet three
    frames more were wrong, which begin and end with an end told 0.8 widths off."""
    most_stretch: float = 1.25
    joined_widths: float = 4.0
    most_beside_widths: float = 0.5
    """By what the points of a midline, which lie evenly, may lie farther apart where it joins: else
    it lay short, or elsewhere. So far from there it has to lie where the frames about it have it,
    to half a width: of 129 ends in 88 films of which it does so none was wrong, of 29 others 4."""
    most_apart_widths: float = 0.7
    """How far it may be supposed from a straight way where it is less sure. Of 856 ends hidden in
    folded frames of 88 films that are told one way or the other 7 were wrong; of 740 by a straight
    way alone 6."""
    ways: WaysBetweenSettings = field(default_factory=WaysBetweenSettings)
    lone_ends: LoneEndSettings = field(default_factory=LoneEndSettings)
    ends_off_way: EndsOffWaySettings = field(default_factory=EndsOffWaySettings)


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
            seen, rest = frames[k].observation, frames[k + 1 :]
            told: PendingFrame | None = frames[k]
            is_off = may_be_off_their_way(seen, settings.ends_off_way)
            reach_s = settings.ends_off_way.ways.reach_s if is_off else settings.ways.reach_s
            if is_off or _may_be_told(seen):
                told = next((each for each in rest if each.observation.status.has_pose), None)
            elif not may_be_lone(known, before + k, settings.lone_ends):
                continue
            is_known = told is not None and last_ns - told.stamp_ns >= settings.ways.beside_s * 1e9
            if not is_known and newest_ns - frames[k].stamp_ns < reach_s * 1e9:
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
        if any(map(self._needs_others, told)):  # hardly ever of an open worm
            shown = [self._shown(known, at) for at in range(len(known))]
            told = [self._told(shown, at) for at in asked]
        if count:
            self._given = self._last_of(known[before : before + count])
        return told

    def _near(self, frames: Sequence[PendingFrame], count: int) -> Sequence[PendingFrame]:
        """Return the first frames, and those after them that may tell more of them."""
        until_ns = frames[count - 1].stamp_ns + self._kept_s * 1e9 if count else 0
        return [each for k, each in enumerate(frames) if k < count or each.stamp_ns <= until_ns]

    def _shown(self, known: Sequence[PendingFrame], at: int) -> PendingFrame:
        """Return one of some frames with what it alone tells of an end hidden."""
        seen = without_lone_ends(known, at, self._settings.lone_ends)
        return known[at] if seen is known[at].observation else replace(known[at], observation=seen)

    def _needs_others(self, seen: Observation) -> bool:
        """Tell whether other frames may say more of one, or otherwise."""
        return _may_be_told(seen) or may_be_off_their_way(seen, self._settings.ends_off_way)

    def _told(self, shown: Sequence[PendingFrame], at: int) -> Observation:
        """Return what is told of one of some frames once those about it are known."""
        settings = self._settings
        if may_be_off_their_way(shown[at].observation, settings.ends_off_way):
            return without_ends_off_their_way(shown, at, settings.ends_off_way)
        return told_over_gap(shown, at, settings)

    @property
    def _kept_s(self) -> float:
        """How far from a frame those are that tell more of it, or of those that do."""
        return self._settings.ways.reach_s + self._settings.lone_ends.beside_s

    def _last_of(self, given: Sequence[PendingFrame]) -> list[PendingFrame]:
        """Return those given last that tell something of one to come, without pictures."""
        kept_ns, last_ns = self._kept_s * 1e9, given[-1].stamp_ns
        late = [each for each in given if last_ns - each.stamp_ns < kept_ns]
        bare = [replace(each.observation, unresolved=None, kept=None) for each in late]
        return [
            *(each for each in self._given if last_ns - each.stamp_ns < kept_ns),
            *(replace(each, observation=seen) for each, seen in zip(late, bare, strict=True)),
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
    seen = frames[at].observation
    body = body_of(seen)
    if body is None or any(body.broad_ends) or not _may_be_told(seen):
        return seen
    wanted = np.ones(len(body.points), bool)
    if seen.has_midline:
        wanted = ~body.shown_points
    ways = ways_between(frames, at, wanted, settings.ways)
    told = _moved_there(frames, at, ways, settings) if seen.has_midline else None
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
        in_doubt=(0, 0) if loops_known else told.in_doubt,
    )


def _moved_there(
    frames: Sequence[PendingFrame], at: int, ways: WaysBetween, settings: BriefGapSettings
) -> Observation | None:
    """Return a body with its hidden ends where they moved; None where that is not known surely."""
    body = frames[at].observation
    between, sd_px = ways.smooth, ways.sd_px
    wanted, every = ~body.shown_points, np.arange(len(body.points))
    # What is not known, as too few frames tell it, is moved along with what is next to it.
    is_sure = sd_px < settings.most_sd_widths * body.width
    known = ~wanted | (is_sure & (ways.misfit_sds < settings.most_misfit_sds))
    if not known[[0, -1]].all():
        return None
    away = np.where(wanted[:, np.newaxis], between - body.points, 0.0)[known].T
    moved = np.stack([np.interp(every, every[known], each) for each in away], axis=1)
    first, last = (
        float(sd_px[tip]) if wanted[tip] else sd
        for tip, sd in zip((0, -1), body.end_sd_px, strict=True)
    )
    told = replace(body, points=body.points + moved, end_sd_px=(first, last))
    steps = np.hypot(*np.diff(told.points, axis=0).T)
    if steps.max() <= settings.most_stretch * np.median(steps):
        return told
    way = ways_between(frames, at, np.ones(len(every), bool), settings.ways).smooth
    return _laid_evenly(told) if _joins_on_its_way(body, way, settings) else None


def _joins_on_its_way(body: Observation, way: Floats, settings: BriefGapSettings) -> bool:
    """Tell whether what is shown next to a hidden end lies where the frames about it have it."""
    count = len(body.points)
    first, last = body.occluded
    near = ceil(settings.joined_widths * body.width * (count - 1) / length_of(body.points))

    def beside(far: int) -> Mask:
        at = np.arange(count)
        return (at < first + far) & (first > 0) | (at >= count - last - far) & (last > 0)

    # As far again: it may have been followed short.
    way = way[beside(2 * near) & np.isfinite(way[:, 0])]
    if len(way) < 2:
        return False
    shown = body.points[beside(near) & body.shown_points]
    away_px = cdist(shown, resample(way, 8 * count)).min(axis=1)
    return bool(np.all(away_px < settings.most_beside_widths * body.width))


def _laid_evenly(body: Observation) -> Observation:
    """Return a body whose midline's points lie evenly along it, loops in doubt where they were."""
    count = len(body.points)
    s = complex_arc_length(as_complex(body.points))
    in_doubt = body.in_doubt
    if not body.loops_known:
        first, last = (s[[in_doubt[0], in_doubt[1] - 1]] * (count - 1) / s[-1]).tolist()
        in_doubt = floor(first), ceil(last) + 1
    return replace(body, points=resample(body.points, count), in_doubt=in_doubt)


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


def _may_be_told(seen: Observation) -> bool:
    """Tell whether a body has no pose because it lies folded."""
    body = body_of(seen)
    return body is not None and not seen.status.has_pose and lies_folded(body)


def _in_order_of(between: Floats, body: Observation) -> Observation:
    """Return a body with its ends in the order of other points of it; NaN tells nothing."""
    known = np.isfinite(between[:, 0])
    ways = (body, body.reversed())
    return min(ways, key=lambda way: float(np.hypot(*(way.points - between)[known].T).sum()))
