"""The walls of a rig, as they are seen: a circle each, found again once the camera is bumped."""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.chamber import Chamber
from worm_msgs_py.errors import NoChamberFound
from worm_tracker.calibration.calibrate import CalibrationSettings, calibrate
from worm_tracker.calibration.circle_fit import FittedCircle, fit_circle, refit_circle
from worm_tracker.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class WallSettings:
    """What is the same wall, and the same place."""

    least_move_px: float = 0.15
    """Changes that are within what a calibration is good to are no changes."""
    most_radius_ratio_off: float = 0.02
    """How much a wall that has moved may differ in radius from what it was, relatively; and one
    that is seen from the circle that was given for it."""
    most_beside_px: float = 1.5
    """How far the wall may be from a circle that is given for it without a word: contacts are told
    by a few pixels, and fits by hand are no better."""


def seen_walls(
    picture: Picture,
    chambers: tuple[Chamber, ...],
    parameters: TrackerParameters,
    settings: WallSettings,
    calibration: CalibrationSettings,
) -> tuple[FittedCircle, ...]:
    """Return the circle that each chamber's wall is seen on; none where one is not to be seen.

    That is the chamber's own where it was found. A circle that was given may lie beside the wall.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
    chambers : tuple of Chamber
    parameters : TrackerParameters
    settings : WallSettings
    calibration : CalibrationSettings
    """
    told = tuple(circle_of(chamber) for chamber in chambers)
    if not parameters.chamber_given:
        return told
    seen = tuple(_near(picture, circle, settings, calibration) for circle in told)
    return tuple(wall for wall in seen if wall is not None) if None not in seen else ()


def why_beside(
    chambers: tuple[Chamber, ...], walls: tuple[FittedCircle, ...], settings: WallSettings
) -> str:
    """Say what to try where a wall is seen beside the circle that was given for it; else empty."""
    options = ("--circle-px", "--circle-b-px")
    for chamber, wall, option in zip(chambers, walls, options, strict=False):
        off_px = hypot(wall.u - chamber.centre_u_px, wall.v - chamber.centre_v_px)
        off_px += abs(wall.radius - chamber.radius_px)
        if off_px > settings.most_beside_px:
            return (
                f"{option} is off: the wall is seen up to {off_px:.1f} px from that circle, by "
                "which contacts are told; leave it out, calibrate again, or try "
                f"{option} {wall.u:.2f} {wall.v:.2f} {wall.radius:.2f}"
            )
    return ""


def walls_again(
    picture: Picture,
    walls: tuple[FittedCircle, ...],
    parameters: TrackerParameters,
    stamp_ns: int,
    settings: WallSettings,
    calibration: CalibrationSettings,
) -> tuple[FittedCircle, ...]:
    """Return the walls where they are now; none where one is not to be seen.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
    walls : tuple of FittedCircle
        Where they were.
    parameters : TrackerParameters
    stamp_ns : int
    settings : WallSettings
    calibration : CalibrationSettings
    """
    still = _still_there(picture, walls, settings, calibration)
    if still:
        return still
    moved = tuple(_near(picture, wall, settings, calibration) for wall in walls)
    if None not in moved:
        return tuple(wall for wall in moved if wall is not None)
    if parameters.chamber_given:  # only the circles given would be looked at
        return ()
    try:
        fresh = calibrate(picture, parameters, stamp_ns, calibration)
    except NoChamberFound:
        return ()
    found = tuple(circle_of(chamber) for chamber in fresh.chambers)
    return found if len(found) == len(walls) else ()


def _near(
    picture: Picture,
    circle: FittedCircle,
    settings: WallSettings,
    calibration: CalibrationSettings,
) -> FittedCircle | None:
    """Return the wall of the size of a circle that its centre lies in."""
    wall = fit_circle(picture, (circle.u, circle.v), calibration.circle)
    if wall is None or abs(wall.radius / circle.radius - 1) >= settings.most_radius_ratio_off:
        return None
    return wall


def _still_there(
    picture: Picture,
    walls: tuple[FittedCircle, ...],
    settings: WallSettings,
    calibration: CalibrationSettings,
) -> tuple[FittedCircle, ...]:
    """Return the walls by another look at where they were; none where one has moved.

    Most alarms are false, of a worm that dims the water before a wall; and looking for walls that
    may be anywhere takes several frames' time.
    """
    found = []
    for wall in walls:
        circle = refit_circle(picture, wall, calibration.circle)
        if circle is None or _change_px(wall, circle) >= settings.least_move_px:
            return ()
        found.append(circle)
    return tuple(found)


def _change_px(one: FittedCircle, other: FittedCircle) -> float:
    """Return by how much a circle's centre or radius is not another's."""
    return max(hypot(one.u - other.u, one.v - other.v), abs(one.radius - other.radius))


def circle_of(chamber: Chamber) -> FittedCircle:
    """Return the circle that a chamber was found on, or that was given for it."""
    return FittedCircle(
        chamber.centre_u_px,
        chamber.centre_v_px,
        chamber.radius_px,
        chamber.residual_px,
        chamber.centre_sd_px,
        chamber.radius_sd_px,
    )


def on_circle(chamber: Chamber, circle: FittedCircle) -> Chamber:
    """Return a chamber on another circle."""
    return replace(
        chamber,
        centre_u_px=circle.u,
        centre_v_px=circle.v,
        radius_px=circle.radius,
        residual_px=circle.residual,
        centre_sd_px=circle.centre_sd,
        radius_sd_px=circle.radius_sd,
    )


def moved_with(chamber: Chamber, before: FittedCircle, after: FittedCircle) -> Chamber:
    """Return a chamber whose circle was given and whose wall has moved: by as much."""
    return replace(
        chamber,
        centre_u_px=chamber.centre_u_px + after.u - before.u,
        centre_v_px=chamber.centre_v_px + after.v - before.v,
    )


def affine_map(old: Chamber, new: Chamber, turn: float) -> Floats:
    """Return the affine map of pixels (2, 3) from one chamber to another, turned so many radians.

    Counter-clockwise as seen.
    """
    scale = new.radius_px / old.radius_px
    if abs(scale - 1) < 1e-3:
        scale = 1.0  # within what a radius is good to: a bump does not change the distance
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[c, s], [-s, c]])  # v points down
    start = np.array([old.centre_u_px, old.centre_v_px])
    end = np.array([new.centre_u_px, new.centre_v_px])
    return np.concatenate([matrix, (end - matrix @ start)[:, None]], axis=1)
