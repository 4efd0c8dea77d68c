"""What every visit of a chamber and every attempt at its exit adds to."""

from math import pi

import numpy as np

from worm_analysis.kinematics.angular_speed import NS
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_msgs_py import Attempt, Distribution, StrokePhase, Visit

DEPTH_BIN_M, DEPTH_BINS = 1e-5, 6001
TAU_BIN_S, TAU_BINS = 0.1, 18_001
"""Up to the 30 min of a trial; what is longer is in the last bin."""
ENTRY_EDGES = np.linspace(-pi, pi, 25)


class PassageSums:
    """Sufficient statistics of visits and of attempts at the exit.

    Attributes
    ----------
    tau_h : ExcessSums
        Times in s from a first contact to the finding of the exit; visits that were cut short
        before it are censored.
    tau_by_time : ExcessBlocks
        The same by blocks of time.
    attempts, successes, failures : int
        Decided attempts.
    free_failures, told_failures : int
        Failures without contact with the passage's walls, of those in which it can be told.
    elongations, phases : int
        Failures whose withdrawal began during elongation, of those in which it can be told.
    touching_elongations, touching_contractions, causes : int
        Failures in contact whose withdrawal began during elongation, or contraction, of those
        whose cause can be told: without contact, or in contact with a known phase.
    depths : ExcessSums
        x_p of the failures.
    """

    def __init__(self) -> None:
        self.tau_h = ExcessSums(TAU_BIN_S, TAU_BINS)
        self.tau_by_time = ExcessBlocks(TAU_BIN_S, 1)
        self.attempts = self.successes = self.failures = 0
        self.free_failures = self.told_failures = 0
        self.elongations = self.phases = 0
        self.touching_elongations = self.touching_contractions = self.causes = 0
        self.depths = ExcessSums(DEPTH_BIN_M, DEPTH_BINS)
        self._entries = np.zeros(len(ENTRY_EDGES) - 1, dtype=np.int64)

    def push_visit(self, visit: Visit) -> None:
        """Add a visit that has closed."""
        if visit.first_contact_ns is None:
            return
        found = visit.tau_h_s == visit.tau_h_s
        searched_s = (visit.end_ns - visit.first_contact_ns) / NS
        self.tau_h.push(searched_s, complete=found)
        self.tau_by_time.push(visit.start_ns, searched_s, complete=found)
        bin_ = int(np.searchsorted(ENTRY_EDGES, visit.theta_h0_rad, side="right")) - 1
        self._entries[min(max(bin_, 0), len(self._entries) - 1)] += 1

    def push_attempt(self, attempt: Attempt) -> None:
        """Add an attempt; one that was not decided counts for nothing."""
        if not attempt.complete:
            return
        self.attempts += 1
        self.successes += attempt.success
        if attempt.success:
            return
        self.failures += 1
        self.depths.push(attempt.penetration_m, complete=True)
        touched, phase = attempt.wall_contact, attempt.stroke_phase
        phase_known = phase is not StrokePhase.UNKNOWN
        if touched is not None:
            self.told_failures += 1
            self.free_failures += not touched
        if phase_known:
            self.phases += 1
            self.elongations += phase is StrokePhase.ELONGATION
        if touched is False or (touched and phase_known):
            self.causes += 1
            self.touching_elongations += touched and phase is StrokePhase.ELONGATION
            self.touching_contractions += touched and phase is StrokePhase.CONTRACTION

    def distributions(self) -> list[Distribution]:
        """Return x_p of the failed attempts, τ_h and θ_h⁰ in bins for people."""
        return [
            self.depths.distribution("x_p", 2.5e-4, 3.5e-2),
            self.tau_h.distribution("tau_h", 10.0, 600.0, "s"),
            Distribution("theta_h0", "rad", ENTRY_EDGES, self._entries.copy()),
        ]
