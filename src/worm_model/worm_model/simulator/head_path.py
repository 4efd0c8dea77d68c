"""The head of a simulated worm: it slides along the wall, hops off it, and now and then turns."""

from dataclasses import dataclass
from math import cos, inf, pi, radians, sin

import numpy as np

from worm_msgs_py import paper

SLOWEST_HOP_S = 0.15
"""No excursion is shorter: a head is not a bullet."""
RADIAL_SPEED_MM_S = 5.0
"""Mean speed of the head on its way off the wall and back."""
TURN_S = 1.8
TURN_EXCURSION_MM = 1.0
LARGEST_EXCURSION_MM = 4.0
LEAN_RAD = radians(38.0)
"""Angle ψ_h between the wall's normal and the head, while it moves along the wall."""
LEAN_SD_RAD, LEAN_S = radians(5.0), 2.0
SMALLEST_LEAN_RAD, LARGEST_LEAN_RAD = radians(28.0), radians(55.0)


@dataclass(frozen=True, slots=True)
class Walker:
    """A simulated worm; the defaults are the paper's numbers (docs/science.md).

    Attributes
    ----------
    length_mm, width_mm : float
        l_w and d_w.
    speed_mm_s : float
        Tangential speed of the head.
    mean_slide_mm, mean_hop_mm, mean_excursion_mm : float
        Means of the exponential laws of d_c, d_nc and Δr_h. Excursions beyond 4 mm are drawn again.
    reversal_per_cycle : float
        Probability that the worm turns around after a slide and a hop; 0.03 gives t_per = 27 s.
    peristalsis, peristalsis_s : float
        Relative amplitude and period of the length.
    undulation_mm, undulation_s : float
        Amplitude and period of the body's transverse wave.
    seed : int
        The same seed gives the same worm.

    Raises
    ------
    ValueError
        Where a number makes no sense.
    """

    length_mm: float = paper.LENGTH_MM
    width_mm: float = 0.4
    speed_mm_s: float = paper.SPEED_MM_S
    mean_slide_mm: float = paper.SLIDE_MM
    mean_hop_mm: float = paper.HOP_MM
    mean_excursion_mm: float = paper.EXCURSION_MM
    reversal_per_cycle: float = 0.03
    peristalsis: float = 0.02
    peristalsis_s: float = paper.PERISTALSIS_S
    undulation_mm: float = 0.25
    undulation_s: float = paper.UNDULATION_S
    seed: int = 0

    def __post_init__(self) -> None:
        positive = (
            "length_mm",
            "width_mm",
            "speed_mm_s",
            "mean_slide_mm",
            "mean_hop_mm",
            "mean_excursion_mm",
            "peristalsis_s",
            "undulation_s",
        )
        for name in positive:
            if not 0.0 < getattr(self, name) < inf:
                raise ValueError(f"{name} is {getattr(self, name)}; it must be above 0")
        if not 0.0 <= self.reversal_per_cycle <= 1.0:
            raise ValueError(f"reversal_per_cycle is {self.reversal_per_cycle}; it is 0 to 1")


@dataclass(frozen=True, slots=True)
class _Phase:
    """A slide, a hop or a turn: how long it lasts, how fast the head goes, how far off the wall."""

    duration_s: float
    speed_mm_s: float
    excursion_mm: float = 0.0
    hopping: bool = False
    turning: bool = False


class HeadPath:
    """Moves the head on, a step at a time.

    Attributes
    ----------
    theta_rad : float
        Polar angle of the head tip, not wrapped.
    off_wall_mm : float
        How far it is off the wall, beyond the gap that its rounded end needs.
    lean_rad : float
        Signed angle from the wall's normal to the head's direction; positive while it moves
        counter-clockwise.
    """

    def __init__(self, walker: Walker, radius_mm: float) -> None:
        self._walker = walker
        self._radius_mm = radius_mm
        self._random = np.random.default_rng([walker.seed, 1])
        self.theta_rad = float(self._random.uniform(-pi, pi))
        self.off_wall_mm = 0.0
        self._direction = 1.0 if self._random.random() < 0.5 else -1.0
        self._lean = LEAN_RAD
        self.lean_rad = self._direction * LEAN_RAD
        self._phase = self._slide()
        self._elapsed_s = 0.0

    def advance(self, step_s: float) -> None:
        """Move the head on by a step of time."""
        self._vary_lean(step_s)
        while step_s > 0.0:
            used = min(step_s, self._phase.duration_s - self._elapsed_s)
            self._elapsed_s += used
            step_s -= used
            self.theta_rad += self._direction * self._phase.speed_mm_s * used / self._radius_mm
            if self._elapsed_s >= self._phase.duration_s:
                self._phase, self._elapsed_s = self._next_phase(), 0.0
        part = self._elapsed_s / self._phase.duration_s
        self.off_wall_mm = self._phase.excursion_mm * sin(pi * part) ** 2
        swing = cos(pi * part) if self._phase.turning else 1.0
        self.lean_rad = self._direction * self._lean * swing

    def _next_phase(self) -> _Phase:
        if self._phase.turning:
            self._direction = -self._direction
            return self._slide()
        if not self._phase.hopping:
            return self._hop()
        if self._random.random() < self._walker.reversal_per_cycle:
            return _Phase(TURN_S, 0.0, TURN_EXCURSION_MM, turning=True)
        return self._slide()

    def _slide(self) -> _Phase:
        distance = float(self._random.exponential(self._walker.mean_slide_mm))
        speed = self._walker.speed_mm_s
        return _Phase(max(distance / speed, 1e-6), speed)

    def _hop(self) -> _Phase:
        distance = float(self._random.exponential(self._walker.mean_hop_mm))
        excursion = np.inf
        while excursion > LARGEST_EXCURSION_MM:
            excursion = float(self._random.exponential(self._walker.mean_excursion_mm))
        at_speed = distance / self._walker.speed_mm_s
        duration = max(at_speed, 2.0 * excursion / RADIAL_SPEED_MM_S, SLOWEST_HOP_S)
        return _Phase(duration, distance / duration, excursion, hopping=True)

    def _vary_lean(self, step_s: float) -> None:
        kept = np.exp(-step_s / LEAN_S)
        noise = LEAN_SD_RAD * np.sqrt(1.0 - kept**2) * self._random.standard_normal()
        lean = LEAN_RAD + kept * (self._lean - LEAN_RAD) + noise
        self._lean = float(np.clip(lean, SMALLEST_LEAN_RAD, LARGEST_LEAN_RAD))
