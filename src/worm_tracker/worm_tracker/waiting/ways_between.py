"""Where points of a body are in a frame, by where those to either side tell them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from worm_msgs_py.arrays import Floats, Mask
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.smooth_motion import (
    SmoothMotionSettings,
    bridged,
    unsteadiness_of,
)


@dataclass(frozen=True, slots=True)
class WaysBetweenSettings:
    """When the frames to either side of one tell where a point of the body is in it."""

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
    motion: SmoothMotionSettings = field(default_factory=SmoothMotionSettings)

    @property
    def reach_s(self) -> float:
        """How far from a frame those are that tell more of it, at most."""
        return self.most_gap_s + self.beside_s


@dataclass(frozen=True, eq=False, slots=True)
class WaysBetween:
    """Where points of a body may be that is not told, NaN where too few frames tell it.

    Attributes
    ----------
    straight : ndarray, shape (n, 2)
        On a straight way from the last frame that tells them to the next.
    smooth : ndarray, shape (n, 2)
        As they moved in the frames before and after.
    sd_px : ndarray, shape (n,)
        How unsure that is: standard deviation along one axis.
    misfit_sds : ndarray, shape (n,)
        How far from that way these frames tell them at most, in standard deviations.
    """

    straight: Floats
    smooth: Floats
    sd_px: Floats
    misfit_sds: Floats

    @classmethod
    def unknown(cls, count: int) -> "WaysBetween":
        """Return those of so many points of which nothing is known."""
        places, others = np.full((2, count, 2), np.nan), np.full((2, count), np.nan)
        return cls(*places, *others)


def ways_between(
    frames: Sequence[PendingFrame], at: int, wanted: Mask, settings: WaysBetweenSettings
) -> WaysBetween:
    """Return where points of a body are in a frame by where those before and after tell them.

    Parameters
    ----------
    frames : sequence of PendingFrame
        In their order, and their midlines all head first or all tail first. Those farther off than
        a gap may be long tell nothing.
    at : int
        Which of them is asked for; what it tells itself is not asked.
    wanted : ndarray of bool, shape (n,)
        Which points are asked for.
    settings : WaysBetweenSettings
    """
    ways = WaysBetween.unknown(len(wanted))
    others = _others_near(frames, at, settings.reach_s)
    after_s = np.array([each.stamp_ns - frames[at].stamp_ns for each in others]) * 1e-9
    has_body = np.array([each.observation.has_midline for each in others], bool)
    bodies = [each.observation for each in others if each.observation.has_midline]
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
        ways.smooth[alike], ways.sd_px[alike] = width * smooth, width * now_sd
        ways.misfit_sds[alike] = misfit
    return ways


def _moved_on(
    told_s: Floats, points: Floats, sd: Floats, settings: WaysBetweenSettings
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
    settings : WaysBetweenSettings
    """
    k = int(np.searchsorted(told_s, 0.0))
    known = told_s < told_s[k] + settings.beside_s  # `BriefGaps.ready` waits for no more
    unsteadiness = unsteadiness_of(told_s[known], points[known], settings.motion)
    beside = known & (told_s > told_s[k - 1] - settings.beside_s)
    sd = np.maximum(sd[beside], settings.motion.least_sd_widths)
    return bridged(told_s[beside], points[beside], sd, 0.0, unsteadiness)


def _is_brief(frames_s: Floats, told_s: Floats, settings: WaysBetweenSettings) -> bool:
    """Tell whether a point is told soon before and after now, and by enough frames to either side.

    Parameters
    ----------
    frames_s, told_s : ndarray
        When all frames were, and those that tell the point; seconds from now.
    settings : WaysBetweenSettings
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


def _leaps(told_s: Floats, points: Floats, width: float, settings: WaysBetweenSettings) -> bool:
    """Tell whether points, shape (frames, n, 2), leap in one of the frames beside a gap."""
    steps_px = np.hypot(*np.moveaxis(np.diff(points, axis=0), 2, 0)).max(axis=1)
    steps = np.maximum(np.diff(told_s) / settings.step_s, 1.0)
    k = int(np.searchsorted(told_s, 0.0))
    first, behind = told_s[k - 1] - settings.beside_s, told_s[k] + settings.beside_s
    beside = (told_s[:-1] > first) & (told_s[1:] < behind)
    return bool((steps_px > settings.most_step_widths * width * steps)[beside].any())


def _others_near(frames: Sequence[PendingFrame], at: int, reach_s: float) -> Sequence[PendingFrame]:
    """Return the frames before and after one that are no farther away than that."""

    def is_near(k: int) -> bool:
        return abs(frames[k].stamp_ns - frames[at].stamp_ns) < reach_s * 1e9

    first, behind = at, at + 1
    while first > 0 and is_near(first - 1):
        first -= 1
    while behind < len(frames) and is_near(behind):
        behind += 1
    return [*frames[first:at], *frames[at + 1 : behind]]
