"""A trial of the filament in the rig: its midline at every frame, all at once or one by one."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from math import pi

import numpy as np
from numpy.typing import NDArray

from worm_model.filament.motion import Course, FilamentMotion
from worm_model.filament.parameters import FILAMENT, FilamentParameters, FilamentSettings
from worm_model.filament.rig import FilamentRig
from worm_model.filament.strokes import (
    BEND_NOISE,
    HEAD_AIM,
    HEAD_BEND,
    LENGTH_NOISE,
    NOISE_SIZE,
    ONSET_NOISE,
    PERISTALSIS_RAD,
    STATE_SIZE,
    TURN_NOISE,
    UNDULATION_RAD,
)
from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, eq=False, slots=True)
class FilamentTrial:
    """A trial with all of its truth.

    Attributes
    ----------
    t_s : ndarray, shape (n,)
        Time of each frame; the first one is at 0.
    midline_mm : ndarray, shape (n, segments + 1, 2)
        x, y, head tip first, in the frame of chamber A: origin at its centre, x towards the middle
        of its exit, y up; the centre of chamber B is at x = 2R + L.
    withdrawing : ndarray of bool, shape (n,)
        Whether the front of the body is drawn back.
    rig : FilamentRig
        The rig.
    parameters : FilamentParameters
        The worm.
    seed : int
        Of its noise and its start.
    """

    t_s: Floats
    midline_mm: Floats
    withdrawing: NDArray[np.bool_]
    rig: FilamentRig
    parameters: FilamentParameters
    seed: int


def simulate(
    parameters: FilamentParameters,
    rig: FilamentRig,
    *,
    seed: int,
    duration_s: float,
    frames_per_s: float,
    settings: FilamentSettings = FILAMENT,
) -> FilamentTrial:
    """Return a trial.

    Parameters
    ----------
    parameters : FilamentParameters
        The worm.
    rig : FilamentRig
        The rig; the worm starts in chamber A.
    seed : int
        The same seed gives the same bytes. The worm's life does not depend on the frames: another
        rate sees the same life at other times.
    duration_s, frames_per_s : float
        Length of the trial, and how often it is seen.
    settings : FilamentSettings
    """
    n = round(duration_s * frames_per_s)
    midline_mm = np.empty((n, parameters.segments + 1, 2))
    withdrawing = np.empty(n, dtype=np.bool_)
    found = _midlines_without_end(parameters, rig, seed, frames_per_s, settings)
    for frame, (points_mm, withdraws) in zip(range(n), found, strict=False):
        midline_mm[frame], withdrawing[frame] = points_mm, withdraws
    t_s = np.arange(n) / frames_per_s
    return FilamentTrial(t_s, midline_mm, withdrawing, rig, parameters, seed)


def frames(
    parameters: FilamentParameters,
    rig: FilamentRig,
    *,
    seed: int,
    duration_s: float,
    frames_per_s: float,
    settings: FilamentSettings = FILAMENT,
) -> Iterator[Floats]:
    """Yield the midlines of `simulate` one by one, mm, shape (segments + 1, 2).

    A second of the worm's life is worked out at a time. `duration_s` may be infinite.
    """
    for frame, (points_mm, _) in enumerate(
        _midlines_without_end(parameters, rig, seed, frames_per_s, settings)
    ):
        if frame + 0.5 > duration_s * frames_per_s:
            return
        yield points_mm


def _midlines_without_end(
    parameters: FilamentParameters,
    rig: FilamentRig,
    seed: int,
    frames_per_s: float,
    settings: FilamentSettings,
) -> Iterator[tuple[Floats, bool]]:
    """Yield midlines without end, between two steps on the straight line, and if it withdraws."""
    life, steps_per_s = _seconds(parameters, rig, seed, settings), settings.steps_per_s
    begins_s = -1
    course = next(life)
    for frame in count():
        time_s = frame / frames_per_s
        while time_s >= begins_s + 1:
            last, course = course, next(life)
            course = Course(
                np.concatenate((last.points_mm[-1:], course.points_mm)),
                np.concatenate((last.withdrawing[-1:], course.withdrawing)),
            )
            begins_s += 1
        steps = (time_s - begins_s) * steps_per_s
        before = min(int(steps), steps_per_s - 1)
        a, b = course.points_mm[before], course.points_mm[before + 1]
        yield a + (steps - before) * (b - a), bool(course.withdrawing[before + 1])


def _seconds(
    parameters: FilamentParameters, rig: FilamentRig, seed: int, settings: FilamentSettings
) -> Iterator[Course]:
    """Yield the life of a worm by the second, from the second before time 0 on."""
    begin, bend, turn, onset, length = (
        np.random.default_rng(stream) for stream in np.random.SeedSequence(seed).spawn(5)
    )
    points_mm, activity = _start_at_rest(parameters, rig, begin, settings)
    steps = settings.steps_per_s
    motion = FilamentMotion(parameters, rig, points_mm, activity, 1.0 / steps, settings)
    for second in count(-settings.settle_s):
        noise = np.empty((steps, NOISE_SIZE))
        noise[:, BEND_NOISE] = bend.standard_normal(steps)
        noise[:, TURN_NOISE] = turn.random(steps)
        noise[:, ONSET_NOISE] = onset.random(steps)
        noise[:, LENGTH_NOISE] = length.standard_exponential(steps)
        course = motion.advance(noise)
        if not np.isfinite(course.points_mm).all():
            raise FloatingPointError("the filament cannot be solved for: give other parameters")
        if second >= -1:
            yield course


def _start_at_rest(
    parameters: FilamentParameters,
    rig: FilamentRig,
    draw: np.random.Generator,
    settings: FilamentSettings,
) -> tuple[Floats, Floats]:
    activity = np.zeros(STATE_SIZE)
    activity[[PERISTALSIS_RAD, UNDULATION_RAD]] = draw.uniform(0.0, 2.0 * pi, 2)
    activity[[HEAD_BEND, HEAD_AIM]] = parameters.head_bend_per_mm * draw.standard_normal()
    s_mm = np.linspace(0.0, parameters.length_mm, parameters.segments + 1)
    radius_mm = settings.start_radius_radii * rig.radius_mm
    r_mm = radius_mm - settings.start_pitch * s_mm
    way = draw.choice([-1.0, 1.0])
    theta = draw.uniform(0.0, 2.0 * pi) - way * s_mm / radius_mm
    return np.stack([r_mm * np.cos(theta), r_mm * np.sin(theta)], axis=1), activity
