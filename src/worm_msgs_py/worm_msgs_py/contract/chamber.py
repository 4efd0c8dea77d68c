"""The rig as the picture shows it: circles, exits, scale, and the way from pixels to metres."""

from dataclasses import dataclass
from math import cos, nan, sin
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.paper import DEPTH_MM, PASSAGE_LENGTH_MM
from worm_msgs_py.units import MM_PER_M

Real = TypeVar("Real", float, NDArray[np.float64])


@dataclass(frozen=True, slots=True)
class Chamber:
    """One circular chamber and its exit.

    Attributes
    ----------
    name : str
        Name of its frame, ``chamber_a`` or ``chamber_b``.
    centre_u_px, centre_v_px, radius_px : float
        The wall's circle in the picture: the inner edge, where bright water meets the dark wall.
    exit_rad : float
        Direction from the centre to the middle of the exit, counter-clockwise as seen in the
        picture from the picture's right (so `exit_rad = π/2` points to smaller v).
    radius_m : float
        The known radius R; gives the scale.
    exit_width_m : float
        Width W of the exit; NaN where no exit is in view.
    residual_px : float
        RMS distance of the wall's edge points from the circle.
    centre_sd_px, radius_sd_px, exit_sd_rad, exit_width_sd_m : float
        One standard deviation of the fit; NaN where given by the user.
    """

    name: str
    centre_u_px: float
    centre_v_px: float
    radius_px: float
    exit_rad: float
    radius_m: float
    exit_width_m: float = nan
    residual_px: float = nan
    centre_sd_px: float = nan
    radius_sd_px: float = nan
    exit_sd_rad: float = nan
    exit_width_sd_m: float = nan

    @property
    def px_per_m(self) -> float:
        """Scale of the picture."""
        return self.radius_px / self.radius_m

    def to_metres(self, u_px: Real, v_px: Real) -> tuple[Real, Real]:
        """Map picture coordinates into the chamber's frame.

        Parameters
        ----------
        u_px, v_px : float or ndarray
            Picture coordinates, v down.

        Returns
        -------
        x_m, y_m : same type as the input
            Metres; x towards the exit, y counter-clockwise from it as seen in the picture.
        """
        right = (u_px - self.centre_u_px) / self.px_per_m
        up = (self.centre_v_px - v_px) / self.px_per_m
        c, s = cos(self.exit_rad), sin(self.exit_rad)
        return c * right + s * up, c * up - s * right

    def to_pixels(self, x_m: Real, y_m: Real) -> tuple[Real, Real]:
        """Map the chamber's frame into the picture: the inverse of `to_metres`."""
        c, s = cos(self.exit_rad), sin(self.exit_rad)
        right, up = c * x_m - s * y_m, s * x_m + c * y_m
        return self.centre_u_px + right * self.px_per_m, self.centre_v_px - up * self.px_per_m

    def yaw(self, picture_yaw_rad: float) -> float:
        """Turn a direction as seen in the picture (counter-clockwise from right) into this frame.

        Returns
        -------
        float
            Radians in (−π, π].
        """
        turned = picture_yaw_rad - self.exit_rad
        return float(np.arctan2(np.sin(turned), np.cos(turned)))


@dataclass(frozen=True, slots=True)
class Geometry:
    """All of the rig that is in view.

    Attributes
    ----------
    version : int
        1 for the first calibration of a trial, one more each time it is corrected.
    stamp_ns : int
        Stamp of the first frame for which it holds.
    picture_width_px, picture_height_px : int
        Size of the picture.
    chambers : tuple of Chamber
        ``chamber_a`` first; empty with ``--no-chamber``.
    depth_m : float
        Thickness h of the sheet.
    passage_length_m : float
        Length L of the passage.
    """

    version: int
    stamp_ns: int
    picture_width_px: int
    picture_height_px: int
    chambers: tuple[Chamber, ...] = ()
    depth_m: float = DEPTH_MM / MM_PER_M
    passage_length_m: float = PASSAGE_LENGTH_MM / MM_PER_M

    def chamber(self, name: str) -> Chamber:
        """Return the chamber of this name; KeyError where it is not in view."""
        for chamber in self.chambers:
            if chamber.name == name:
                return chamber
        raise KeyError(f"no {name} in this geometry")
