"""Keeps the rig's geometry true: an exit hidden or disturbed at first, a camera that is bumped."""

from collections import deque
from dataclasses import dataclass, field, replace
from math import isfinite, nan, radians, remainder, tau

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.units import NS_PER_S
from worm_tracker.calibration.calibrate import (
    CalibrationSettings,
    calibrate,
    passage_length,
    with_shared_passage,
)
from worm_tracker.calibration.calibrate_pictures import with_agreed_exit
from worm_tracker.calibration.circle_fit import FittedCircle
from worm_tracker.calibration.exit_fit import FittedExit, find_exit
from worm_tracker.calibration.motion_detector import MotionDetector, MotionDetectorSettings
from worm_tracker.calibration.vibration import Vibration, VibrationSettings
from worm_tracker.calibration.walls import (
    WallSettings,
    affine_map,
    circle_of,
    moved_with,
    on_circle,
    seen_walls,
    walls_again,
    why_beside,
)
from worm_tracker.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class RigMonitorSettings:
    """When the rig is looked for again, and what counts as a change of it."""

    clear_of_exit_px: float = 10.0
    """How far the worm's contour must be from an exit for the exit to be measured."""
    first_retry_ns: int = NS_PER_S
    most_retry_ns: int = 60_000_000_000
    """Stamps between two looks at the exits: at first, and at most, as they double each time."""
    least_looks: int = 3
    kept_looks: int = 5
    """Looks at an exit from which on they may correct it, with the doubling after 3 s of one that
    is never hidden; and how many are kept, the last ones."""
    most_exit_width_off_px: float = 0.5
    """Looks that differ by more show that something lay before the exit; fits of one exit agree to
    0.1 px."""
    search_again_ns: int = 250_000_000
    """Stamps between two attempts to find a rig that has moved and is not seen any more."""
    least_turn_rad: float = radians(0.15)
    """A turn that is within what a calibration is good to is none."""
    most_exit_width_ratio_off: float = 0.05
    """The same of the width of the exit by which a turn is told."""
    calibration: CalibrationSettings = field(default_factory=CalibrationSettings)
    walls: WallSettings = field(default_factory=WallSettings)
    motion: MotionDetectorSettings = field(default_factory=MotionDetectorSettings)
    vibration: VibrationSettings = field(default_factory=VibrationSettings)


@dataclass(frozen=True, eq=False, slots=True)
class GeometryChange:
    """A new version of the geometry, and why.

    Attributes
    ----------
    geometry : Geometry
        From this frame on.
    motion : ndarray, shape (2, 3), or None
        Affine map of the old picture's coordinates (u, v) to the new one's; None where nothing
        has moved.
    why : str
        One line for people.
    """

    geometry: Geometry
    motion: Floats | None
    why: str


class RigMonitor:
    """Holds the geometry of one trial, from frame to frame.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first good picture.
    parameters : TrackerParameters
    stamp_ns : int
    settings : RigMonitorSettings

    Attributes
    ----------
    geometry : Geometry
        What is known of the rig; the width of an exit that the worm hides is NaN.
    assumed : Geometry
        The same with the width that a half hidden exit seems to have: where to look for the worm.
    advice : str
        What to try where a wall is seen beside the circle that was given for it; else empty.

    Raises
    ------
    NoChamberFound
        Where no circular wall stands out.
    """

    def __init__(
        self,
        picture: Picture,
        parameters: TrackerParameters,
        stamp_ns: int,
        settings: RigMonitorSettings,
    ) -> None:
        self._parameters = parameters
        self._settings = settings
        self.assumed = calibrate(picture, parameters, stamp_ns, settings.calibration)
        self.geometry = self.assumed
        how = settings.walls, settings.calibration
        self._walls = seen_walls(picture, self.assumed.chambers, parameters, *how)
        self.advice = why_beside(self.assumed.chambers, self._walls, settings.walls)
        self._motion = self._watch(picture)
        self._vibration = Vibration(settings.vibration)
        self._looks: dict[str, deque[Chamber]] = {
            chamber.name: deque(maxlen=settings.kept_looks) for chamber in self.assumed.chambers
        }
        self._retry_ns = settings.first_retry_ns
        self._due_ns = stamp_ns + self._retry_ns
        self._search_ns = stamp_ns

    def mark_hidden_exits(self, contour: Floats | None) -> None:
        """Take an exit for unknown that the worm, by its first contour, may hide in part."""
        chambers = tuple(
            chamber
            if self._is_clear(chamber, contour) or self._parameters.exit_given
            else replace(chamber, exit_width_m=nan, exit_sd_rad=nan, exit_width_sd_m=nan)
            for chamber in self.assumed.chambers
        )
        for chamber in chambers:
            if isfinite(chamber.exit_width_m):
                self._looks[chamber.name].append(chamber)
        self.geometry = replace(self.assumed, chambers=self._with_shared_passage(chambers))

    def stabilised(self, picture: Picture, stamp_ns: int) -> Picture:
        """Return a picture with the rig where it was, while it vibrates."""
        walls = self._motion
        return self._vibration.stabilised(picture, stamp_ns, walls) if walls else picture

    def check(
        self, picture: Picture, stamp_ns: int, contour: Floats | None
    ) -> GeometryChange | None:
        """Return what has changed with this picture, if anything has.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        stamp_ns : int
        contour : ndarray, shape (n, 2), or None
            The worm's in the frame before; None where it was not seen.
        """
        motion = self._motion
        if motion is not None and stamp_ns >= self._search_ns and motion.moved(picture):
            self._search_ns = stamp_ns + self._settings.search_again_ns
            return self._follow(picture, stamp_ns, contour)
        if stamp_ns >= self._due_ns and not self._parameters.exit_given:
            return self._look_at_exits(picture, stamp_ns, contour)
        return None

    def _look_at_exits(
        self, picture: Picture, stamp_ns: int, contour: Floats | None
    ) -> GeometryChange | None:
        """Look for the exits that have not been seen yet, and once more at those that have."""
        old = self.geometry.chambers
        if contour is None and any(not isfinite(chamber.exit_width_m) for chamber in old):
            return None  # a worm that is not seen may be what hides it
        self._due_ns = stamp_ns + self._retry_ns
        self._retry_ns = min(2 * self._retry_ns, self._settings.most_retry_ns)
        chambers = tuple(self._looked_at(picture, chamber, contour) for chamber in old)
        if chambers == old:
            return None
        if any(
            isfinite(new.exit_width_m) > isfinite(chamber.exit_width_m)
            for new, chamber in zip(chambers, old, strict=True)
        ):
            self._retry_ns = self._settings.first_retry_ns
            return self._adopt(picture, stamp_ns, chambers, None, "the exit was found")
        looks = max(len(self._looks[chamber.name]) for chamber in old)
        why = f"the exit was disturbed: {looks} pictures agree on its width"
        return self._adopt(picture, stamp_ns, chambers, None, why)

    def _looked_at(self, picture: Picture, chamber: Chamber, contour: Floats | None) -> Chamber:
        """Return a chamber with its exit as this picture, or this and those before, show it."""
        looks, settings = self._looks[chamber.name], self._settings
        seen = self._with_exit(picture, chamber, contour)
        if seen is chamber:
            return chamber
        looks.append(seen)
        if not isfinite(chamber.exit_width_m):
            return seen
        if len(looks) < settings.least_looks:
            return chamber
        agreed = with_agreed_exit(chamber, looks, settings.calibration)
        off_m = max(abs(agreed.exit_width_m - chamber.exit_width_m), agreed.exit_width_sd_m)
        believed = off_m * chamber.px_per_m < settings.most_exit_width_off_px
        return chamber if believed else agreed

    def _with_exit(self, picture: Picture, chamber: Chamber, contour: Floats | None) -> Chamber:
        """Return a chamber with its exit, if it is in view and clear of the worm."""
        found = find_exit(picture, circle_of(chamber), self._settings.calibration.exit)
        if found is None:
            return chamber
        seen = self._seen(chamber, found)
        return seen if self._is_clear(seen, contour) else chamber

    def _seen(self, chamber: Chamber, found: FittedExit) -> Chamber:
        width_m = found.width_px / chamber.px_per_m
        width_sd_m = found.width_sd_px / chamber.px_per_m
        if isfinite(self._parameters.exit_width_m):
            width_m, width_sd_m = self._parameters.exit_width_m, nan
        seen = replace(chamber, exit_width_m=width_m, exit_width_sd_m=width_sd_m)
        if isfinite(self._parameters.exit_deg):
            return seen
        return replace(seen, exit_rad=found.direction_rad, exit_sd_rad=found.direction_sd_rad)

    def _follow(
        self, picture: Picture, stamp_ns: int, contour: Floats | None
    ) -> GeometryChange | None:
        """Find the rig where it is now; None where it has not moved or is not to be seen."""
        old, settings = self.assumed.chambers, self._settings
        how = settings.walls, settings.calibration
        walls = walls_again(picture, self._walls, self._parameters, stamp_ns, *how)
        if not walls:
            return None
        moved = self._moved_to(walls)
        turn = self._turn(picture, moved, contour)
        motion = affine_map(old[0], moved[0], turn)
        chambers = tuple(
            replace(
                chamber,
                exit_rad=remainder(before.exit_rad + turn, tau),
                exit_width_m=before.exit_width_m,
                exit_sd_rad=before.exit_sd_rad,
                exit_width_sd_m=before.exit_width_sd_m,
            )
            for chamber, before in zip(moved, old, strict=True)
        )
        moves = [
            np.array([new.centre_u_px - c.centre_u_px, new.centre_v_px - c.centre_v_px])
            for new, c in zip(chambers, old, strict=True)
        ]
        shifts = [float(np.hypot(*move)) for move in moves]
        if max(shifts) < settings.walls.least_move_px and abs(turn) < settings.least_turn_rad:
            self._motion = self._watch(picture)
            return None
        self._walls = walls
        known = tuple(
            chamber if isfinite(c.exit_width_m) else replace(chamber, exit_width_m=nan)
            for chamber, c in zip(chambers, self.geometry.chambers, strict=True)
        )
        self._vibration.note_move(stamp_ns, moves[0])
        why = f"the rig moved by {max(shifts):.1f} px and turned by {np.degrees(turn):.1f} degrees"
        if self._vibration.is_on:
            why += ", to and fro: until it rests its pictures are shifted back to here"
        return self._adopt(picture, stamp_ns, known, motion, why, chambers)

    def _moved_to(self, walls: tuple[FittedCircle, ...]) -> list[Chamber]:
        """Return the chambers once their walls are there."""
        old = self.assumed.chambers
        if not self._parameters.chamber_given:
            return [on_circle(*each) for each in zip(old, walls, strict=True)]
        return [moved_with(*each) for each in zip(old, self._walls, walls, strict=True)]

    def _watch(self, picture: Picture) -> MotionDetector | None:
        """Watch the walls from this picture on, if they are seen."""
        if not self._walls:
            return None
        on_walls = map(on_circle, self.assumed.chambers, self._walls)
        rig = replace(self.assumed, chambers=tuple(on_walls))
        return MotionDetector(picture, rig, self._settings.motion)

    def _turn(self, picture: Picture, moved: list[Chamber], contour: Floats | None) -> float:
        """Return by how much the rig has turned, counter-clockwise as seen."""
        old = self.assumed.chambers
        if len(moved) == 2:
            before, after = (_towards(*pair) for pair in (old, moved))
            return remainder(after - before, tau)
        if isfinite(self._parameters.exit_deg) or not isfinite(old[0].exit_width_m):
            return 0.0
        found = self._with_exit(picture, moved[0], np.empty((0, 2)))
        shifted = replace(moved[0], exit_rad=found.exit_rad, exit_width_m=old[0].exit_width_m)
        off = abs(found.exit_width_m / old[0].exit_width_m - 1)
        same_width = off < self._settings.most_exit_width_ratio_off
        if not same_width or not self._is_clear(shifted, contour):
            return 0.0
        turn = remainder(found.exit_rad - old[0].exit_rad, tau)
        return turn if abs(turn) > self._settings.least_turn_rad / 3 else 0.0

    def _with_shared_passage(self, chambers: tuple[Chamber, ...]) -> tuple[Chamber, ...]:
        return with_shared_passage(chambers, self._settings.calibration)

    def _is_clear(self, chamber: Chamber, contour: Floats | None) -> bool:
        """Tell whether the worm's contour keeps off all that an exit is measured by."""
        if contour is None or not len(contour) or not isfinite(chamber.exit_width_m):
            return True
        x, y = chamber.to_metres(contour[:, 0].astype(np.float64), contour[:, 1].astype(np.float64))
        margin = self._settings.clear_of_exit_px / chamber.px_per_m
        r, aside = np.hypot(x, y), np.abs(y) - chamber.exit_width_m / 2
        beside = (r > chamber.radius_m - margin) & (aside < 4 * margin)
        exits = self._settings.calibration.exit
        water_m = exits.water_radius_px(chamber.radius_px) / chamber.px_per_m - margin
        before = (r > water_m) & (aside < 0)
        farthest_m = exits.passage_radii_px(chamber.radius_px)[-1] / chamber.px_per_m + margin
        near = (x > 0) & (r < farthest_m)  # the other chamber lies in line with the passage
        return not bool((near & (beside | before)).any())

    def _adopt(
        self,
        picture: Picture,
        stamp_ns: int,
        chambers: tuple[Chamber, ...],
        motion: Floats | None,
        why: str,
        assumed: tuple[Chamber, ...] | None = None,
    ) -> GeometryChange:
        """Take a new version of the geometry."""
        chambers = self._with_shared_passage(chambers)
        if motion is not None:
            for looks in self._looks.values():
                looks.clear()  # they show the rig where it was
        self.geometry = replace(
            self.geometry,
            version=self.geometry.version + 1,
            stamp_ns=stamp_ns,
            chambers=chambers,
            passage_length_m=passage_length(chambers, self._parameters),
        )
        self.assumed = replace(self.geometry, chambers=assumed or chambers)
        self._motion = self._watch(picture)
        return GeometryChange(self.geometry, motion, why)


def _towards(a: Chamber, b: Chamber) -> float:
    """Return the direction from one centre to the other, counter-clockwise as seen."""
    return float(np.arctan2(a.centre_v_px - b.centre_v_px, b.centre_u_px - a.centre_u_px))
