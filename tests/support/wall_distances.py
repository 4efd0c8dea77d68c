"""How far points are from the walls of the filament's rig."""

import numpy as np

from worm_model.filament.walls import Walls, nearest_walls


def wall_distance_mm(points_mm, rig):
    """Return how far points are from the nearest wall: negative inside it."""
    walls, gap, normal = Walls.of(rig), np.empty(2), np.empty((2, 2))
    found = np.empty(len(points_mm))
    for i, (x, y) in enumerate(np.asarray(points_mm, dtype=np.float64).tolist()):
        nearest_walls(x, y, walls, gap, normal)
        found[i] = gap.min()
    return found
