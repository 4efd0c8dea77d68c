"""The boundary walk: how long a head that slides and hops along the wall takes to find the exit.

The walk of Biswas & Kudrolli (arXiv 2303.00647, section "Boundary search model") by Monte Carlo,
which checks the exact solution in `first_passage`.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState
from worm_msgs_py.intervals import NORMAL_95


@dataclass(frozen=True, slots=True)
class MonteCarloMean:
    """A Monte Carlo mean with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, slots=True)
class WalkResult:
    """What many walks did.

    Attributes
    ----------
    tau_h_s : ndarray, shape (walks,)
        Time until the head finds the exit; `horizon_s` where it had not by then.
    skips : ndarray of int64, shape (walks,)
        Times that the head flew over the exit.
    found : ndarray of bool, shape (walks,)
        Whether it found the exit before the horizon.
    """

    tau_h_s: NDArray[np.float64]
    skips: NDArray[np.int64]
    found: NDArray[np.bool_]

    def mean_tau_h_s(self) -> MonteCarloMean:
        """⟨τ_h⟩; a lower bound where some walks did not find the exit."""
        return _mean_with_interval(self.tau_h_s)

    def mean_skips(self) -> MonteCarloMean:
        """Skips per passage."""
        return _mean_with_interval(self.skips.astype(np.float64))


def simulate_walks(
    parameters: WalkParameters,
    walks: int,
    seed: int,
    *,
    horizon_s: float = 1e5,
    start: WalkState | None = None,
) -> WalkResult:
    """Run many walks at once.

    A walk starts uniformly on the wall, sliding, in either direction, or in a given state. A slide
    that meets the exit finds it. A hop that ends above the exit finds it at its end
    (`hop_may_land`); a hop that leaves the exit's arc again, by either edge, is a skip. Distances
    are exponential, so a phase that a reversal
    interrupts (rule `rate`) goes on with a fresh distance.

    Parameters
    ----------
    parameters : WalkParameters
        The walk.
    walks : int
        How many, at least 2.
    seed : int
        The same seed gives the same walks.
    horizon_s : float
        Time after which a walk is given up.
    start : WalkState, optional
        The state in which all walks start.

    Returns
    -------
    WalkResult
        In the order in which the walks were started.
    """
    random = np.random.default_rng(seed)
    result = WalkResult(
        np.full(walks, horizon_s), np.zeros(walks, dtype=np.int64), np.zeros(walks, dtype=np.bool_)
    )
    alive = start_walkers(parameters, walks, random, start)
    while len(alive.index):
        found, skips = step(parameters, alive, random)
        over = alive.time > horizon_s
        result.skips[alive.index] += skips
        done = alive.index[found & ~over]
        result.tau_h_s[done] = alive.time[found & ~over]
        result.found[done] = True
        alive.keep(~(found | over))
    return result


@dataclass(slots=True)
class Walkers:
    """The walks that still search: a row each.

    The exit is the arc from 0 to `exit_arc_mm`; the wall goes on, counter-clockwise, to the ring's
    length, which is 0 again.
    """

    index: NDArray[np.int64]
    place: NDArray[np.float64]
    forwards: NDArray[np.bool_]
    hopping: NDArray[np.bool_]
    time: NDArray[np.float64]

    def keep(self, rows: NDArray[np.bool_]) -> None:
        """Keep some of the walks."""
        self.index, self.place = self.index[rows], self.place[rows]
        self.forwards, self.hopping = self.forwards[rows], self.hopping[rows]
        self.time = self.time[rows]


def start_walkers(
    parameters: WalkParameters, walks: int, random: np.random.Generator, start: WalkState | None
) -> Walkers:
    """Return walks about to start: anywhere, or all in one state."""
    arc, ring = parameters.exit_arc_mm, parameters.circumference_mm
    if start is None:
        place = arc + (ring - arc) * random.random(walks)
        forwards = random.random(walks) < 0.5
    else:
        place = np.full(walks, (parameters.radius_mm * start.theta_rad + arc / 2.0) % ring)
        forwards = np.full(walks, start.direction is Direction.COUNTER_CLOCKWISE)
    hopping = np.full(walks, start is not None and start.phase is Phase.HOP)
    return Walkers(np.arange(walks), place, forwards, hopping, np.zeros(walks))


def step(
    parameters: WalkParameters, alive: Walkers, random: np.random.Generator
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Let each walk go on to its next end of a phase or reversal.

    Returns
    -------
    found : ndarray of bool
        Which walks found the exit.
    skips : ndarray of int64
        How often each flew over it.
    """
    distance, ends = _draw_distances(parameters, alive, random)
    found, skips = _move(parameters, alive, distance, ends)
    _turn(parameters, alive, ends, random)
    return found, skips


def _draw_distances(
    parameters: WalkParameters, alive: Walkers, random: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return how far each walk goes, and whether its phase ends there (else it turns around)."""
    mean = np.where(alive.hopping, parameters.mean_hop_mm, parameters.mean_slide_mm)
    distance = mean * random.standard_exponential(len(mean))
    if parameters.flip_rate_s <= 0.0:
        return distance, np.ones(len(mean), dtype=np.bool_)
    scale = parameters.speed_mm_s / parameters.flip_rate_s
    until_turn = scale * random.standard_exponential(len(mean))
    return np.minimum(distance, until_turn), distance <= until_turn


def _move(
    parameters: WalkParameters,
    alive: Walkers,
    distance: NDArray[np.float64],
    ends: NDArray[np.bool_],
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Move the walks on; return which of them found the exit, and the skips of each."""
    arc, ring = parameters.exit_arc_mm, parameters.circumference_mm
    # Mirror the walks that go backwards, so that all go forwards from `place`.
    place = np.where(alive.forwards, alive.place, arc - alive.place) % ring
    # A hop that turned around above the exit (rule `rate`) starts there; all others on the wall.
    goal = place + distance
    above = goal % ring
    lands = above < arc
    slides = ~alive.hopping
    meets = slides & (goal >= ring)
    ends_above = alive.hopping & ends & lands
    if parameters.hop_may_land:
        found = meets | ends_above
    else:
        found = meets
        # A hair beyond the edge: on it, rounding would decide whether the exit was passed.
        beyond = arc * (1.0 + 1e-9) - above
        distance = np.where(ends_above, distance + beyond, distance)
    distance = np.where(meets, ring - place, distance)
    goal = place + distance
    # Far edges of the exit at arc, arc + ring, …: those in (place, goal] were flown over.
    passed = np.floor((goal - arc) / ring) - np.floor((place - arc) / ring)
    skips = np.where(slides, 0.0, passed).astype(np.int64)
    alive.time = alive.time + distance / parameters.speed_mm_s
    alive.place = np.where(alive.forwards, goal, arc - goal) % ring
    alive.hopping = np.where(ends, slides, alive.hopping)
    return found, skips


def _turn(
    parameters: WalkParameters,
    alive: Walkers,
    ends: NDArray[np.bool_],
    random: np.random.Generator,
) -> None:
    """Turn walks around: `hopping` is already that of the phase to come."""
    chance = np.where(alive.hopping, parameters.flip_after_slide, parameters.flip_after_hop)
    turns = np.where(ends, random.random(len(chance)) < chance, True)
    alive.forwards = alive.forwards ^ turns


def _mean_with_interval(values: NDArray[np.float64]) -> MonteCarloMean:
    mean = float(values.mean())
    half = NORMAL_95 * float(values.std(ddof=1)) / sqrt(len(values))
    return MonteCarloMean(mean, mean - half, mean + half)
