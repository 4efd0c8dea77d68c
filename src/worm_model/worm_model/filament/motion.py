"""Moves the filament through the rig, step by step, from noise that it is given."""

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from worm_model.filament.mechanics import Elasticity, step_body
from worm_model.filament.parameters import (
    FILAMENT,
    LEAST_EXIT_WIDTHS,
    FilamentParameters,
    FilamentSettings,
)
from worm_model.filament.rig import FilamentRig
from worm_model.filament.sources_number import sources_number
from worm_model.filament.strokes import DRAWN_UNTIL_S, TIME_S, Activity, act
from worm_model.filament.walls import Walls, nearest_walls, push_out
from worm_msgs_py import paper
from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.compiled import compiled_and_kept


class Course(NamedTuple):
    """What one or more steps gave.

    Attributes
    ----------
    points_mm : ndarray, shape (steps, n, 2)
        The midline after each step.
    withdrawing : ndarray of bool, shape (steps,)
        Whether the front of the body was drawn back in it.
    """

    points_mm: Floats
    withdrawing: Mask


class FilamentMotion:
    """A filament that moves.

    Parameters
    ----------
    parameters : FilamentParameters
        The worm.
    rig : FilamentRig
        The rig.
    points_mm : ndarray, shape (segments + 1, 2)
        Where it lies, head tip first.
    activity : ndarray, shape (strokes.STATE_SIZE,)
        Phases of its strokes and so on: the places are named in `strokes`.
    step_s : float
        Time step.
    """

    def __init__(
        self,
        parameters: FilamentParameters,
        rig: FilamentRig,
        points_mm: Floats,
        activity: Floats,
        step_s: float,
        settings: FilamentSettings = FILAMENT,
    ):
        self.points_mm, self.activity = points_mm.copy(), activity.copy()
        self._held = np.zeros((len(points_mm), 2), dtype=np.bool_)
        self._s_mm = np.linspace(0.0, parameters.length_mm, len(points_mm))
        self._clearance_mm = clearance_mm(parameters, rig, settings)
        self._walls = Walls.of(rig)
        self._body = _elasticity(parameters, step_s, settings)
        self._strokes = _strokes(parameters, step_s, settings)

    def advance(self, noise: Floats) -> Course:
        """Move on by as many steps as there is noise for.

        Parameters
        ----------
        noise : ndarray, shape (steps, strokes.NOISE_SIZE)
            The columns are named in `strokes`.
        """
        course = Course(
            np.empty((len(noise), *self.points_mm.shape)), np.empty(len(noise), dtype=np.bool_)
        )
        _advance(
            self.points_mm,
            self.activity,
            self._held,
            noise,
            self._s_mm,
            self._clearance_mm,
            self._walls,
            self._body,
            self._strokes,
            course,
        )
        return course


def clearance_mm(
    parameters: FilamentParameters, rig: FilamentRig, settings: FilamentSettings = FILAMENT
) -> Floats:
    """Return how near each point of the midline may come to a wall: half of the body's width.

    Raises
    ------
    ValueError
        Where the exit is too narrow for the body.
    """
    s = np.linspace(0.0, parameters.length_mm, parameters.segments + 1)
    width = parameters.width_mm
    near_head = 1.0 - s / (settings.head_end_widths * width)
    near_tail = 1.0 - (parameters.length_mm - s) / (settings.tail_end_widths * width)
    taper = np.clip(np.maximum(near_head, near_tail), 0.0, 1.0)
    if 0.0 < rig.exit_width_mm < LEAST_EXIT_WIDTHS * width:
        raise ValueError(
            f"exit_width_mm is {rig.exit_width_mm:g}; a body of {width:g} mm needs "
            f"{LEAST_EXIT_WIDTHS * width:g} or more"
        )
    half = np.maximum(0.5 * width * np.sqrt(1.0 - taper**2), settings.tip_clearance_mm)
    if rig.exit_width_mm > 0.0:
        half = np.minimum(half, 0.5 * settings.squeezed_width * rig.exit_width_mm)
    return np.asarray(half, dtype=np.float64)


def _elasticity(
    parameters: FilamentParameters, step_s: float, settings: FilamentSettings
) -> Elasticity:
    return Elasticity(
        step_s=step_s,
        rest_mm=parameters.length_mm / parameters.segments,
        drag_ratio=parameters.drag_ratio,
        bending=parameters.bending_mm4_s,
        stretching=parameters.stretching_mm2_s,
        wall=settings.wall_per_s,
        width_mm=parameters.width_mm if parameters.self_contact else 0.0,
        apart_mm=settings.apart_widths * parameters.width_mm,
        overlap_part=settings.overlap_part,
    )


def _strokes(parameters: FilamentParameters, step_s: float, settings: FilamentSettings) -> Activity:
    wave_number = 2.0 * pi / parameters.undulation_length_mm
    front_mm = settings.withdrawing_part * parameters.length_mm
    return Activity(
        step_s=step_s,
        speed=parameters.crawl_speed_mm_s,
        stretch=0.5 * parameters.peristalsis_mm / parameters.length_mm,
        stretch_s=parameters.peristalsis_s,
        wave=parameters.undulation_mm * wave_number**2,
        wave_s=parameters.undulation_s,
        wave_mm=parameters.undulation_length_mm,
        head_mm=parameters.head_mm,
        head_bend=parameters.head_bend_per_mm,
        head_turns_per_s=parameters.head_turns_per_s,
        lost_turns_per_s=parameters.lost_turns_per_s,
        head_turn_s=parameters.head_turn_s,
        onset_per_s=parameters.withdrawal_per_s,
        withdrawal_s=parameters.withdrawal_s,
        withdrawal_mm=parameters.withdrawal_mm,
        front_mm=front_mm,
        most_drawn_mm=settings.most_of_front * front_mm,
        touch_mm=paper.CONTACT_DISTANCE_WIDTHS * parameters.width_mm,
    )


def _make_loop(sources: int) -> Callable[..., None]:
    def loop(
        points: Floats,
        activity: Floats,
        held: Mask,
        noise: Floats,
        s_mm: Floats,
        clearance: Floats,
        walls: Walls,
        body: Elasticity,
        strokes: Activity,
        course: Course,
    ) -> None:
        if sources < 0:  # never: it ties the machine code that is kept to all of its sources
            return
        gap, normal = np.empty(2), np.empty((2, 2))
        curvature, rest = np.zeros(len(points)), np.empty(len(points) - 1)
        for step in range(len(noise)):
            nearest_walls(points[0, 0], points[0, 1], walls, gap, normal)
            head_gap = min(gap[0], gap[1])
            act(activity, noise[step], head_gap, s_mm, strokes, curvature, rest)
            step_body(points, strokes.speed, rest, curvature, clearance, held, walls, body)
            push_out(points, clearance, walls)
            course.points_mm[step] = points
            course.withdrawing[step] = activity[TIME_S] < activity[DRAWN_UNTIL_S]

    return compiled_and_kept(loop)


_advance = _make_loop(sources_number())
