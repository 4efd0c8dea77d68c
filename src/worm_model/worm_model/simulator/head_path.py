"""The head of a simulated worm: it slides along the wall, hops off it, turns, finds the exit."""

from dataclasses import dataclass
from math import copysign, cos, exp, inf, pi, sin, tau

import numpy as np

from worm_model.simulator.gait import GAIT, GaitSettings
from worm_msgs_py import paper

STEEPEST_HOP = 5.0
"""Most that hops may be deep for their length: a head is not a bullet."""


@dataclass(frozen=True, slots=True)
class Walker:
    """A simulated worm; the defaults are the paper's numbers (docs/science.md).

    Attributes
    ----------
    length_mm, width_mm : float
        l_w and d_w.
    speed_mm_s : float
        v_w: along the wall the head goes at v_w sin⟨ψ_b⟩.
    mean_slide_mm, mean_hop_mm, mean_excursion_mm : float
        Means of the exponential laws of d_c, d_nc and Δr_h. A hop is as deep as it is long, in
        proportion; 0.8 R at most.
    reversal_per_cycle : float
        Probability that the worm turns around after a slide and a hop; 0.057 gives t_per = 27 s.
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
    reversal_per_cycle: float = 0.057
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
        steep = self.mean_excursion_mm / self.mean_hop_mm
        if steep > STEEPEST_HOP:
            raise ValueError(
                f"mean_excursion_mm is {self.mean_excursion_mm:g}: {steep:.1f} times mean_hop_mm, "
                f"{self.mean_hop_mm:g}; it must be {STEEPEST_HOP:g} times or less"
            )


class HeadPath:
    """Moves the head on, a step at a time, until it is before the exit and turned into it.

    Attributes
    ----------
    theta_rad : float
        Polar angle of the head tip, not wrapped.
    lean_rad : float
        Signed angle from the wall's normal to the head's direction; positive while it moves
        counter-clockwise.
    exit_half_rad : float
        Half of the arc around θ = 0 in which a head that slides, or lands, finds the exit; 0: none.
    turning : float
        Which way the body swings round its head at the wall, to go the other way from then on: 1
        counter-clockwise, −1 clockwise; 0 while it does not turn.
    """

    def __init__(self, walker: Walker, radius_mm: float, gait: GaitSettings = GAIT) -> None:
        self._walker = walker
        self._gait = gait
        self._radius_mm = radius_mm
        self.exit_half_rad = 0.0
        self._random = np.random.default_rng([walker.seed, 1])
        self.theta_rad = float(self._random.uniform(-pi, pi))
        self._direction = 1.0 if self._random.random() < 0.5 else -1.0
        self._lean = gait.lean_rad
        self.lean_rad = self._direction * gait.lean_rad
        self.turning = self._direction  # from wherever the body lies
        self._psi_b_rad = gait.psi_b_rad
        self._hop_mm = 0.0
        self._left_mm = self._draw_mm(walker.mean_slide_mm)

    @property
    def depth_mm(self) -> float:
        """R − r_h of a hop: from where contact ends, by the excursion's bow; 0 in contact."""
        if not self._hop_mm:
            return 0.0
        walker = self._walker
        touching_mm = paper.CONTACT_DISTANCE_WIDTHS * walker.width_mm
        excursion_mm = self._hop_mm * walker.mean_excursion_mm / walker.mean_hop_mm
        bow = sin(pi * self._left_mm / self._hop_mm)
        return touching_mm + min(excursion_mm, self._gait.deepest_hop_radii * self._radius_mm) * bow

    @property
    def in_exit(self) -> bool:
        """Whether it stands before the exit and points into it: from then on it does not move."""
        return (
            self._way_to_exit_mm() == 0.0 and abs(_wrapped(self.theta_rad + self.lean_rad)) < 1e-9
        )

    def advance(self, step_s: float, psi_b_rad: float) -> None:
        """Move the head on by a step of time, as fast as its body's angle ψ_b lets it."""
        self._vary_lean(step_s)
        if psi_b_rad * self.turning > self._gait.psi_b_rad:
            self.turning = 0.0
        at_exit = self._way_to_exit_mm() == 0.0
        towards = -_wrapped(self.theta_rad) if at_exit else self._direction * self._lean
        swing = towards - self.lean_rad
        self.lean_rad += copysign(min(abs(swing), self._gait.turn_rad_s * step_s), swing)
        if at_exit:
            return
        if self.turning:
            self._move(self._walker.speed_mm_s * sin(psi_b_rad) * self.turning * step_s)
        else:
            self._go(self._pace_mm_s(psi_b_rad * self._direction, step_s) * step_s)

    def _pace_mm_s(self, psi_b_rad: float, step_s: float) -> float:
        """Return the pace whose mean is v_w sin⟨ψ_b⟩: linear in ψ_b about its mean of late."""
        kept = exp(-step_s / self._gait.mean_psi_b_s)
        mean = self._psi_b_rad = kept * self._psi_b_rad + (1.0 - kept) * psi_b_rad
        sine = sin(mean) + cos(mean) * (psi_b_rad - mean)
        return self._walker.speed_mm_s * max(sine, sin(self._gait.slowest_psi_b_rad))

    def _go(self, way_mm: float) -> None:
        """Go on along the wall; stop before the exit, and where the worm turns."""
        while way_mm > 0.0 and not self.turning:
            to_exit_mm = self._way_to_exit_mm()
            used_mm = min(way_mm, self._left_mm, to_exit_mm)
            self._move(used_mm)
            way_mm -= used_mm
            if used_mm == to_exit_mm:
                return
            if self._left_mm <= 0.0:
                self._end_phase()

    def _move(self, way_mm: float) -> None:
        self.theta_rad += self._direction * way_mm / self._radius_mm
        self._left_mm -= way_mm

    def _end_phase(self) -> None:
        """Hop after a slide; slide after a hop, as often as told the other way."""
        walker = self._walker
        if self._hop_mm:
            self._hop_mm = 0.0
            self._left_mm = self._draw_mm(walker.mean_slide_mm)
            if self._random.random() < walker.reversal_per_cycle:
                self._direction = self.turning = -self._direction
        else:
            self._hop_mm = self._left_mm = self._draw_mm(walker.mean_hop_mm)

    def _draw_mm(self, mean_mm: float) -> float:
        return max(float(self._random.exponential(mean_mm)), 1e-6)

    def _way_to_exit_mm(self) -> float:
        """Return how far ahead the head could enter the exit: 0 where it can, not while it hops."""
        if self.exit_half_rad <= 0.0 or self._hop_mm:
            return inf
        theta = _wrapped(self.theta_rad)
        if abs(theta) <= self.exit_half_rad + 1e-9:
            return 0.0
        return self._radius_mm * ((-self.exit_half_rad - self._direction * theta) % tau)

    def _vary_lean(self, step_s: float) -> None:
        gait = self._gait
        kept = exp(-step_s / gait.lean_s)
        noise = gait.lean_sd_rad * np.sqrt(1.0 - kept**2) * self._random.standard_normal()
        lean = gait.lean_rad + kept * (self._lean - gait.lean_rad) + noise
        self._lean = float(np.clip(lean, *gait.lean_within_rad))


def _wrapped(angle_rad: float) -> float:
    return (angle_rad + pi) % tau - pi
