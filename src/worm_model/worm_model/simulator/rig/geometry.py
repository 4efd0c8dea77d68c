"""The rig as an object: chambers, passage, and where they lie in the picture."""

from dataclasses import dataclass, field
from math import cos, hypot, inf, sin

import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.rig.optics import Optics
from worm_msgs_py import paper
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B, Where


@dataclass(frozen=True, slots=True)
class Rig:
    """The paper's rig (docs/science.md) under a camera.

    Attributes
    ----------
    width_px, height_px : int
        Size of the picture.
    px_per_mm : float
        Scale.
    centre_px : tuple of float
        Centre (u, v) of chamber a; need not lie on a pixel.
    exit_rad : float
        Direction from that centre to its exit, counter-clockwise as seen in the picture from the
        picture's right.
    radius_mm, exit_width_mm, passage_length_mm, depth_mm : float
        R, W, L and h. The wall's inner edge is the circle of radius R. The passage is straight,
        from circle to circle. W = 0 closes the chamber.
    chamber_b : bool
        Whether there is a chamber at the passage's far end. Without one the passage ends blind;
        it is usually out of the picture.
    optics : Optics
        Light and camera.
    """

    width_px: int = 1024
    height_px: int = 1024
    px_per_mm: float = 40.0
    centre_px: tuple[float, float] = (511.5, 511.5)
    exit_rad: float = 0.0
    radius_mm: float = paper.RADIUS_MM
    exit_width_mm: float = 2.0
    passage_length_mm: float = paper.PASSAGE_LENGTH_MM
    depth_mm: float = paper.DEPTH_MM
    chamber_b: bool = False
    optics: Optics = field(default_factory=Optics)

    @property
    def radius_px(self) -> float:
        """R in pixels."""
        return self.radius_mm * self.px_per_mm

    @property
    def chambers(self) -> tuple[Chamber, ...]:
        """The true chambers, `chamber_a` first, each with its x axis towards its own exit."""
        a = self._chamber(CHAMBER_A, self.centre_px, self.exit_rad)
        if not self.chamber_b:
            return (a,)
        far_m = (2.0 * self.radius_mm + self.passage_length_mm) * 1e-3
        b_centre = a.to_pixels(far_m, 0.0)
        return (a, self._chamber(CHAMBER_B, b_centre, self.exit_rad + np.pi))

    def _chamber(self, name: str, centre_px: tuple[float, float], exit_rad: float) -> Chamber:
        return Chamber(
            name=name,
            centre_u_px=centre_px[0],
            centre_v_px=centre_px[1],
            radius_px=self.radius_px,
            exit_rad=exit_rad,
            radius_m=self.radius_mm * 1e-3,
            exit_width_m=self.exit_width_mm * 1e-3,
            residual_px=0.0,
            centre_sd_px=0.0,
            radius_sd_px=0.0,
            exit_sd_rad=0.0,
        )

    def geometry(self, stamp_ns: int = 0) -> Geometry:
        """Return the true calibration, as the tracker would announce it."""
        return Geometry(
            version=1,
            stamp_ns=stamp_ns,
            picture_width_px=self.width_px,
            picture_height_px=self.height_px,
            chambers=self.chambers,
            depth_m=self.depth_mm * 1e-3,
            passage_length_m=self.passage_length_mm * 1e-3,
        )

    def chamber_of(self, u_px: float, v_px: float) -> Chamber:
        """Return the chamber in whose frame this point is expressed: the nearest one."""
        return min(self.chambers, key=lambda c: hypot(u_px - c.centre_u_px, v_px - c.centre_v_px))

    def where(self, u_px: float, v_px: float) -> Where:
        """Return the part of the rig that holds this point: a chamber's disc, else the passage."""
        chamber = self.chamber_of(u_px, v_px)
        if hypot(u_px - chamber.centre_u_px, v_px - chamber.centre_v_px) <= chamber.radius_px:
            return Where.CHAMBER_A if chamber.name == CHAMBER_A else Where.CHAMBER_B
        return Where.PASSAGE

    def wall_distance_px(
        self, u_px: NDArray[np.float64], v_px: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the distance into the wall: negative in the water, exact at and beyond the edge.

        Parameters
        ----------
        u_px, v_px : ndarray
            Picture coordinates that broadcast against each other.

        Returns
        -------
        ndarray, of the broadcast shape
            Signed distance, pixels.
        """
        distance = np.full(np.broadcast_shapes(np.shape(u_px), np.shape(v_px)), inf)
        for chamber in self.chambers:
            from_centre = np.hypot(u_px - chamber.centre_u_px, v_px - chamber.centre_v_px)
            np.minimum(distance, from_centre - chamber.radius_px, out=distance)
        if self.exit_width_mm > 0.0:
            np.minimum(distance, self._passage_distance_px(u_px, v_px), out=distance)
        return distance

    def _passage_distance_px(
        self, u_px: NDArray[np.float64], v_px: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        # A rectangle that starts inside chamber a, so that no sliver of wall is left at the exit.
        right, up = u_px - self.centre_px[0], self.centre_px[1] - v_px
        along = cos(self.exit_rad) * right + sin(self.exit_rad) * up
        across = cos(self.exit_rad) * up - sin(self.exit_rad) * right
        start = 0.5 * self.radius_px
        end = self.radius_px + self.passage_length_mm * self.px_per_mm
        if self.chamber_b:
            end += 0.5 * self.radius_px
        outside_x = np.abs(along - 0.5 * (start + end)) - 0.5 * (end - start)
        outside_y = np.abs(across) - 0.5 * self.exit_width_mm * self.px_per_mm
        beyond = np.hypot(np.maximum(outside_x, 0.0), np.maximum(outside_y, 0.0))
        inside = np.minimum(np.maximum(outside_x, outside_y), 0.0)
        return np.asarray(beyond + inside, dtype=np.float64)
