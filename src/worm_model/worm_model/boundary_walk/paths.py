"""Paths of single boundary walks, to be drawn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from worm_model.boundary_walk.monte_carlo import start_walkers, step
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import WalkState


@dataclass(frozen=True, eq=False, slots=True)
class WalkPath:
    """One walk, from corner to corner; it goes evenly in between.

    Attributes
    ----------
    t_s : ndarray, shape (n,)
        Times at which a phase ends, a reversal happens, or the exit is found.
    theta_rad : ndarray, shape (n,)
        θ_h, unwrapped: from the middle of the exit, counter-clockwise positive.
    hopping : ndarray of bool, shape (n − 1,)
        Whether the head hops from a corner to the next.
    found : bool
        Whether the last corner is the exit; else the walk was given up there.
    """

    t_s: NDArray[np.float64]
    theta_rad: NDArray[np.float64]
    hopping: NDArray[np.bool_]
    found: bool


def walk_paths(
    parameters: WalkParameters,
    walks: int,
    seed: int,
    *,
    horizon_s: float = 1e5,
    start: WalkState | None = None,
) -> list[WalkPath]:
    """Return the paths of the walks that `monte_carlo.simulate_walks` runs with the same arguments.

    Raises
    ------
    ValueError
        Where there is less than one walk.
    """
    if walks < 1:
        raise ValueError(f"walks is {walks}; at least 1 is needed")
    random = np.random.default_rng(seed)
    alive = start_walkers(parameters, walks, random, start)
    first_mm = alive.place - parameters.exit_arc_mm / 2.0
    corners: list[list[tuple[float, float]]] = [[(0.0, float(x))] for x in first_mm]
    hops: list[list[bool]] = [[] for _ in range(walks)]
    ended = np.zeros(walks, dtype=np.bool_)
    while len(alive.index):
        before, forwards, hopping = alive.time, alive.forwards, alive.hopping
        found, _ = step(parameters, alive, random)
        gone_mm = np.where(forwards, 1.0, -1.0) * (alive.time - before) * parameters.speed_mm_s
        for row, index in enumerate(alive.index):
            place_mm = corners[index][-1][1] + float(gone_mm[row])
            corners[index].append((float(alive.time[row]), place_mm))
            hops[index].append(bool(hopping[row]))
        over = alive.time > horizon_s
        ended[alive.index[found & ~over]] = True
        alive.keep(~(found | over))
    return [
        WalkPath(
            np.array([t for t, _ in path]),
            np.array([x for _, x in path]) / parameters.radius_mm,
            np.array(hopped, dtype=np.bool_),
            bool(end),
        )
        for path, hopped, end in zip(corners, hops, ended, strict=True)
    ]
