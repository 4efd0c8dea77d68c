"""Keeps the rig's geometry true: an exit that the worm hid at first, a camera that is bumped."""

from dataclasses import dataclass, replace
from math import hypot, isfinite, radians, remainder, tau

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.chamber import Chamber, Geometry
from worm_msgs_py.errors import NoChamberFound
from worm_tracker.calibration.calibrate import calibrate, joined, passage_length
from worm_tracker.calibration.circle_fit import Circle, Picture, fit_circle
from worm_tracker.calibration.exit_fit import Exit, find_exit
from worm_tracker.calibration.motion_detector import WallWatch
from worm_tracker.parameters import TrackerParameters

Floats = NDArray[np.float64]

NAN = float("nan")
CLEAR_PX = 10.0
"""How far the worm's outline must be from an exit for the exit to be measured."""
RETRY_NS = 1_000_000_000
"""Stamps between two attempts to find what is hidden, at first; twice as long each time."""
MAX_RETRY_NS = 60_000_000_000
AGAIN_NS = 250_000_000
"""Stamps between two attempts to find a rig that has moved and is not seen any more."""
MIN_MOVE_PX = 0.15
MIN_TURN_RAD = radians(0.15)
"""Changes that are within what a calibration is good to are no changes."""


@dataclass(frozen=True, eq=False, slots=True)
class Change:
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


class RigKeeper:
    """Holds the geometry of one trial, from frame to frame.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first good picture.
    parameters : TrackerParameters
    stamp_ns : int

    Attributes
    ----------
    geometry : Geometry
        What is known of the rig; the width of an exit that the worm hides is NaN.
    supposed : Geometry
        The same with the width that a half hidden exit seems to have: where to look for the worm.

    Raises
    ------
    NoChamberFound
        Where no circular wall stands out.
    """

    def __init__(self, picture: Picture, parameters: TrackerParameters, stamp_ns: int) -> None:
        self._parameters = parameters
        self.supposed = calibrate(picture, parameters, stamp_ns)
        self.geometry = self.supposed
        watched = bool(self.geometry.chambers) and not parameters.chamber_given
        self._watch = WallWatch(picture, self.geometry) if watched else None
        self._retry_ns = RETRY_NS
        self._due_ns = stamp_ns + RETRY_NS
        self._search_ns = stamp_ns

    def doubt(self, outline: Floats | None) -> None:
        """Take an exit for unknown that the worm, by its first outline, may hide in part."""
        chambers = tuple(
            chamber
            if is_clear(chamber, outline) or self._parameters.exit_given
            else replace(chamber, exit_width_m=NAN, exit_sd_rad=NAN, exit_width_sd_m=NAN)
            for chamber in self.supposed.chambers
        )
        self.geometry = replace(self.supposed, chambers=joined(chambers))

    def check(self, picture: Picture, stamp_ns: int, outline: Floats | None) -> Change | None:
        """Return what has changed with this picture, if anything has.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        stamp_ns : int
        outline : ndarray, shape (n, 2), or None
            The worm's in the frame before; None where it was not seen.
        """
        watch = self._watch
        if watch is not None and stamp_ns >= self._search_ns and watch.moved(picture):
            self._search_ns = stamp_ns + AGAIN_NS
            return self._follow(picture, stamp_ns, outline)
        hidden = any(not isfinite(c.exit_width_m) for c in self.geometry.chambers)
        if hidden and outline is not None and stamp_ns >= self._due_ns:
            self._due_ns = stamp_ns + self._retry_ns
            return self._complete(picture, stamp_ns, outline)
        return None

    def _complete(self, picture: Picture, stamp_ns: int, outline: Floats) -> Change | None:
        """Look for the exits that have not been seen yet."""
        self._retry_ns = min(2 * self._retry_ns, MAX_RETRY_NS)
        chambers = tuple(
            chamber
            if isfinite(chamber.exit_width_m)
            else self._with_exit(picture, chamber, outline)
            for chamber in self.geometry.chambers
        )
        if chambers == self.geometry.chambers:
            return None
        return self._adopt(picture, stamp_ns, chambers, None, "the exit was found")

    def _with_exit(self, picture: Picture, chamber: Chamber, outline: Floats) -> Chamber:
        """Return a chamber with its exit, if it is in view and clear of the worm."""
        circle = Circle(
            chamber.centre_u_px,
            chamber.centre_v_px,
            chamber.radius_px,
            chamber.residual_px,
            chamber.centre_sd_px,
            chamber.radius_sd_px,
        )
        found = find_exit(picture, circle)
        if found is None:
            return chamber
        seen = self._seen(chamber, found)
        return seen if is_clear(seen, outline) else chamber

    def _seen(self, chamber: Chamber, found: Exit) -> Chamber:
        width_m = found.width_px / chamber.px_per_m
        width_sd_m = found.width_sd_px / chamber.px_per_m
        if isfinite(self._parameters.exit_width_m):
            width_m, width_sd_m = self._parameters.exit_width_m, NAN
        seen = replace(chamber, exit_width_m=width_m, exit_width_sd_m=width_sd_m)
        if isfinite(self._parameters.exit_deg):
            return seen
        return replace(seen, exit_rad=found.direction_rad, exit_sd_rad=found.direction_sd_rad)

    def _follow(self, picture: Picture, stamp_ns: int, outline: Floats | None) -> Change | None:
        """Find the rig where it is now; None where it has not moved or is not to be seen."""
        old = self.supposed.chambers
        circles = [fit_circle(picture, (c.centre_u_px, c.centre_v_px)) for c in old]
        moved = [
            _placed(chamber, circle)
            for chamber, circle in zip(old, circles, strict=True)
            if circle is not None and abs(circle.radius / chamber.radius_px - 1) < 0.02
        ]
        if len(moved) < len(old):
            try:
                fresh = calibrate(picture, self._parameters, stamp_ns)
            except NoChamberFound:
                return None
            if len(fresh.chambers) != len(old):
                return None
            moved = list(fresh.chambers)
        turn = self._turn(picture, moved, outline)
        motion = _motion(old[0], moved[0], turn)
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
        shifts = [
            hypot(new.centre_u_px - c.centre_u_px, new.centre_v_px - c.centre_v_px)
            for new, c in zip(chambers, old, strict=True)
        ]
        if max(shifts) < MIN_MOVE_PX and abs(turn) < MIN_TURN_RAD:
            self._watch = WallWatch(picture, self.supposed)
            return None
        known = tuple(
            chamber if isfinite(c.exit_width_m) else replace(chamber, exit_width_m=NAN)
            for chamber, c in zip(chambers, self.geometry.chambers, strict=True)
        )
        why = f"the rig moved by {max(shifts):.1f} px and turned by {np.degrees(turn):.1f} degrees"
        return self._adopt(picture, stamp_ns, known, motion, why, chambers)

    def _turn(self, picture: Picture, moved: list[Chamber], outline: Floats | None) -> float:
        """Return by how much the rig has turned, counter-clockwise as seen."""
        old = self.supposed.chambers
        if len(moved) == 2:
            before, after = (_direction(*pair) for pair in (old, moved))
            return remainder(after - before, tau)
        if isfinite(self._parameters.exit_deg) or not isfinite(old[0].exit_width_m):
            return 0.0
        found = self._with_exit(picture, moved[0], np.empty((0, 2)))
        shifted = replace(moved[0], exit_rad=found.exit_rad, exit_width_m=old[0].exit_width_m)
        same_width = abs(found.exit_width_m / old[0].exit_width_m - 1) < 0.05
        if not same_width or not is_clear(shifted, outline):
            return 0.0
        turn = remainder(found.exit_rad - old[0].exit_rad, tau)
        return turn if abs(turn) > MIN_TURN_RAD / 3 else 0.0

    def _adopt(
        self,
        picture: Picture,
        stamp_ns: int,
        chambers: tuple[Chamber, ...],
        motion: Floats | None,
        why: str,
        supposed: tuple[Chamber, ...] | None = None,
    ) -> Change:
        """Take a new version of the geometry."""
        chambers = joined(chambers)
        self.geometry = replace(
            self.geometry,
            version=self.geometry.version + 1,
            stamp_ns=stamp_ns,
            chambers=chambers,
            passage_length_m=passage_length(chambers, self._parameters),
        )
        self.supposed = replace(self.geometry, chambers=supposed or chambers)
        if self._watch is not None:
            self._watch = WallWatch(picture, self.supposed)
        return Change(self.geometry, motion, why)


def is_clear(chamber: Chamber, outline: Floats | None) -> bool:
    """Tell whether the worm's outline keeps off a chamber's exit."""
    if outline is None or not len(outline) or not isfinite(chamber.exit_width_m):
        return True
    x, y = chamber.to_metres(outline[:, 0].astype(np.float64), outline[:, 1].astype(np.float64))
    margin = CLEAR_PX / chamber.px_per_m
    at_exit = (x > 0) & (np.hypot(x, y) > chamber.radius_m - margin)
    return not bool((at_exit & (np.abs(y) < chamber.exit_width_m / 2 + 4 * margin)).any())


def _placed(chamber: Chamber, circle: Circle) -> Chamber:
    """Return a chamber on the circle that it is found on now."""
    return replace(
        chamber,
        centre_u_px=circle.u,
        centre_v_px=circle.v,
        radius_px=circle.radius,
        residual_px=circle.residual,
        centre_sd_px=circle.centre_sd,
        radius_sd_px=circle.radius_sd,
    )


def _direction(a: Chamber, b: Chamber) -> float:
    """Return the direction from one centre to the other, counter-clockwise as seen."""
    return float(np.arctan2(a.centre_v_px - b.centre_v_px, b.centre_u_px - a.centre_u_px))


def _motion(old: Chamber, new: Chamber, turn: float) -> Floats:
    """Return the affine map that takes one chamber to another, turned counter-clockwise."""
    scale = new.radius_px / old.radius_px
    if abs(scale - 1) < 1e-3:
        scale = 1.0  # within what a radius is good to: a bump does not change the distance
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[c, s], [-s, c]])  # v points down
    start = np.array([old.centre_u_px, old.centre_v_px])
    end = np.array([new.centre_u_px, new.centre_v_px])
    return np.concatenate([matrix, (end - matrix @ start)[:, None]], axis=1)
