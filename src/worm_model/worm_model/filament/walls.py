"""Distances of points from the walls of the rig, and the directions that lead away from them."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from worm_model.filament.rig import FilamentRig
from worm_msgs_py.arrays import Floats
from worm_msgs_py.compiled import compiled

FAR_MM = 1e9
"""Gap of a wall that is not there."""


class Walls(NamedTuple):
    """The rig as the compiled loops take it, mm."""

    radius: float
    half_width: float
    mouth_x: float
    far_centre: float

    @classmethod
    def of(cls, rig: FilamentRig) -> "Walls":
        """Return the walls of a rig."""
        half = 0.5 * rig.exit_width_mm
        return cls(rig.radius_mm, half, sqrt(rig.radius_mm**2 - half**2), rig.far_centre_mm)


@compiled
def nearest_walls(x: float, y: float, walls: Walls, gap: Floats, normal: Floats) -> None:
    """Find the two pieces of wall that a point is nearest to; both matter in a narrow passage.

    Parameters
    ----------
    x, y : float
        The point, mm.
    walls : Walls
        The rig.
    gap : ndarray, shape (2,)
        Filled with the distances from either wall, mm: negative inside it; `FAR_MM` for none.
    normal : ndarray, shape (2, 2)
        Filled with the unit vectors that lead straight away from either.
    """
    side = 1.0
    if x > 0.5 * walls.far_centre:
        x, side = walls.far_centre - x, -1.0
    gap[1] = FAR_MM
    half = walls.half_width
    r = sqrt(x * x + y * y)
    if half > 0.0 and x >= walls.mouth_x and (abs(y) <= half or half - abs(y) > walls.radius - r):
        gap[0], gap[1] = half - y, half + y
        normal[0, 0], normal[0, 1], normal[1, 0], normal[1, 1] = 0.0, -1.0, 0.0, 1.0
    elif half > 0.0 and x > 0.0 and abs(y) * walls.mouth_x < half * x:
        for k in range(2):
            dx, dy = x - walls.mouth_x, y + (half if k else -half)
            gap[k] = sqrt(dx * dx + dy * dy)
            normal[k, 0] = side * dx / gap[k] if gap[k] > 0.0 else -side
            normal[k, 1] = dy / gap[k] if gap[k] > 0.0 else 0.0
    else:
        gap[0] = walls.radius - r
        normal[0, 0] = -side * x / r if r > 0.0 else 1.0
        normal[0, 1] = -y / r if r > 0.0 else 0.0


@compiled
def push_out(points: Floats, clearance: Floats, walls: Walls) -> None:
    """Move points that are nearer to a wall than they may be straight away from it, in place.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x, y, mm.
    clearance : ndarray, shape (n,)
        How near each may come, mm.
    walls : Walls
        The rig.
    """
    gap, normal = np.empty(2), np.empty((2, 2))
    for i in range(len(points)):
        for _ in range(2):
            nearest_walls(points[i, 0], points[i, 1], walls, gap, normal)
            for k in range(2):
                if gap[k] < clearance[i]:
                    points[i, 0] += (clearance[i] - gap[k]) * normal[k, 0]
                    points[i, 1] += (clearance[i] - gap[k]) * normal[k, 1]
                    break
