"""What every visit of a chamber and every attempt at its exit adds to."""

import numpy as np

from worm_analysis.accumulators.bins import (
    ENTRY_EDGES,
    FINE_BINS_IN_DEPTH_BIN,
    LENGTH_BIN_M,
    LENGTH_BINS,
    TAU_BIN_S,
    TAU_BINS,
)
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_msgs_py import Attempt, Distribution, StrokePhase, Visit
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import NS_PER_S

SHARES = (
    "success",
    "failures_without_contact",
    "failures_in_elongation",
    "failures_touching_in_elongation",
    "failures_touching_in_contraction",
    "failures_of_unknown_phase",
)


class PassageSums:
    """Sufficient statistics of visits and of attempts at the exit.

    Attributes
    ----------
    tau_h : ExcessSums
        Times in s from a first contact to the finding of the exit; visits that were cut short
        before it are censored.
    tau_by_time : ExcessBlocks
        The same by blocks of time.
    shares : dict of str to list of int
        Attempts of which something can be said, and those of which it is true. Success is of all
        decided attempts. Of the failures: whether the head touched the passage's walls; whether
        its withdrawal began during elongation; whether it touched in elongation or in contraction,
        of those without contact or in contact with a known phase; whether the phase is not known.
    depths : ExcessSums
        x_p of the failures.
    """

    def __init__(self) -> None:
        self.tau_h = ExcessSums(TAU_BIN_S, TAU_BINS)
        self.tau_by_time = ExcessBlocks(TAU_BIN_S, 1)
        self.shares = {name: [0, 0] for name in SHARES}
        self.depths = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self._entries = np.zeros(len(ENTRY_EDGES) - 1, dtype=np.int64)

    def push_visit(self, visit: Visit) -> None:
        """Add a visit that has closed."""
        if visit.first_contact_ns is None:
            return
        found = visit.tau_h_s == visit.tau_h_s
        searched_s = (visit.end_ns - visit.first_contact_ns) / NS_PER_S
        self.tau_h.push(searched_s, complete=found)
        self.tau_by_time.push(visit.start_ns, searched_s, complete=found)
        if visit.theta_h0_rad != visit.theta_h0_rad:
            return
        bin_ = int(np.searchsorted(ENTRY_EDGES, visit.theta_h0_rad, side="right")) - 1
        self._entries[min(max(bin_, 0), len(self._entries) - 1)] += 1

    def push_attempt(self, attempt: Attempt) -> None:
        """Add an attempt; one that was not decided is not counted."""
        if not attempt.complete:
            return
        self._count("success", attempt.success)
        if attempt.success:
            return
        self.depths.push(attempt.penetration_m, complete=True)
        touched, phase = attempt.wall_contact, attempt.stroke_phase
        elongating, contracting = (
            phase is kind for kind in (StrokePhase.ELONGATION, StrokePhase.CONTRACTION)
        )
        phase_known = elongating or contracting
        self._count("failures_of_unknown_phase", not phase_known)
        if touched is not None:
            self._count("failures_without_contact", not touched)
        if phase_known:
            self._count("failures_in_elongation", elongating)
        if touched is False or (touched and phase_known):
            self._count("failures_touching_in_elongation", bool(touched) and elongating)
            self._count("failures_touching_in_contraction", bool(touched) and contracting)

    def _count(self, name: str, is_so: bool) -> None:
        self.shares[name][0] += 1
        self.shares[name][1] += is_so

    def sums(self, least_depth_m: float) -> dict[str, Floats]:
        """Return the sums of the attempts, the number of attempts before those of a kind.

        Parameters
        ----------
        least_depth_m : float
            Failures that got less far are not all seen, and are not in the histogram of x_p.
        """
        fine = self.depths.excess_histogram(least_depth_m)[:, : LENGTH_BINS - 1]
        return {
            "x_p": fine.reshape(1, -1, FINE_BINS_IN_DEPTH_BIN).sum(axis=2),
            "x_p_least": np.array([[1.0, least_depth_m]]),
            **{name: np.array([pair], dtype=np.float64) for name, pair in self.shares.items()},
        }

    def search_sums(self) -> dict[str, Floats]:
        """Return the sums of the times to find the exit, s."""
        by_time = self.tau_by_time.rows(0.0)
        assert by_time is not None
        return {"tau_h": by_time, "tau_h_excess": self.tau_h.excess_histogram(0.0)}

    def distributions(self) -> list[Distribution]:
        """Return x_p of the failed attempts, τ_h and θ_h⁰ in bins for people."""
        return [
            self.depths.distribution("x_p", 2.5e-4, 3.5e-2),
            self.tau_h.distribution("tau_h", 10.0, 600.0, "s"),
            Distribution("theta_h0", "rad", ENTRY_EDGES, self._entries.copy()),
        ]
