"""What one trial adds to a pool: the sums that it saved, and points for the figures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from worm_analysis.results import Results
from worm_analysis.summary.settings import DEFAULTS
from worm_analysis.summary.sums import TrialSums
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import MM_PER_M

MOST_FRAMES_SHOWN = 300
"""Frames of a trial that a scatter plot shows at most."""
SHOWN_ANGLES_DEG = np.linspace(-180.0, 180.0, 37)
"""Bins of ψ_b in which the mean angular speed is shown."""
LONGEST_SEARCH_S, SHORTEST_SEARCH_S = 60.0, 5.0
"""A search is cut into pieces of the first; what is shorter than the second is not shown."""


@dataclass(frozen=True, eq=False, slots=True)
class PooledTrial:
    """One trial, reduced to what pooling needs.

    Attributes
    ----------
    name : str
        What the trial is called: its bag, table or camera.
    directory : str
        Its results directory, as it was given.
    exit_width_mm, radius_mm, depth_mm : float
        W (NaN where it is not known), R and h (NaN where it is not told).
    frames : int
        Frames read.
    seconds : float
        From the first frame to the last one.
    provenance : mapping
        As in its summary.
    lag_s : ndarray, shape (k,)
        Lags of C_θ; empty where there is none.
    sums : mapping of str to ndarray
        As the trial saved them.
    points : mapping of str to ndarray
        Values of single episodes, visits, attempts and frames, in the units of the tables.
    source_events : tuple of str
        What happened to its pictures or rows, a line each.
    """

    name: str
    directory: str
    exit_width_mm: float
    radius_mm: float
    depth_mm: float
    frames: int
    seconds: float
    provenance: Mapping[str, Any]
    lag_s: Floats
    sums: TrialSums
    points: Mapping[str, Floats]
    source_events: tuple[str, ...] = ()

    @property
    def minimum_n(self) -> int:
        """Items that are enough data, as the trial was analysed."""
        settings = (self.provenance.get("parameters") or {}).get("analysis") or {}
        return int(settings.get("minimum_n", DEFAULTS.minimum_n))


def pooled_trial(results: Results, name: str = "", directory: str = "") -> PooledTrial:
    """Reduce a trial.

    Parameters
    ----------
    results : Results
        A trial with a chamber.
    name, directory : str
        What to call it, and where it was read from.
    """
    correlation = results.correlation
    return PooledTrial(
        name=name,
        directory=directory,
        exit_width_mm=results.chambers[0].exit_width_m * MM_PER_M,
        radius_mm=results.radius_mm,
        depth_mm=results.depth_mm,
        frames=len(results.t_s),
        seconds=float(results.t_s[-1]) if len(results.t_s) else 0.0,
        provenance=results.provenance,
        lag_s=np.empty(0) if correlation is None else correlation.lag_s,
        sums=results.sums,
        points=_event_points(results) | _motion(results) | _searches(results),
        source_events=tuple(results.remarks),
    )


def _event_points(results: Results) -> dict[str, Floats]:
    """Return lengths of complete episodes, τ_h, θ_h⁰ and x_p of the failed attempts."""
    contacts, passages = results.contacts, results.passages
    complete, touching = contacts["complete"] == 1.0, contacts["kind"] == "contact"
    failed = (passages["complete"] == 1.0) & (passages["success"] == 0.0)
    found = {
        "d_c": contacts["distance_mm"][complete & touching],
        "d_nc": contacts["distance_mm"][complete & ~touching],
        "delta_r_h": contacts["delta_r_mm"][complete & ~touching],
        "tau_h": passages["tau_h_s"],
        "theta_h0": np.degrees(passages["theta_h0_rad"]),
        "x_p": passages["penetration_mm"][failed],
    }
    return {name: values[np.isfinite(values)] for name, values in found.items()}


def _motion(results: Results) -> dict[str, Floats]:
    """Return θ̇_h against ψ_b: some frames, and sums and counts in bins of ψ_b."""
    psi, theta_dot = results.tracks["psi_b_deg"], np.degrees(results.tracks["theta_dot_rad_s"])
    both = np.flatnonzero(np.isfinite(psi) & np.isfinite(theta_dot))
    shown = both[:: max(1, -(-len(both) // MOST_FRAMES_SHOWN))]
    return {
        "frame_psi_b": psi[shown],
        "frame_theta_dot": theta_dot[shown],
        "binned_theta_dot": np.histogram(psi[both], SHOWN_ANGLES_DEG, weights=theta_dot[both])[0],
        "binned_frames": np.histogram(psi[both], SHOWN_ANGLES_DEG)[0].astype(np.float64),
    }


def _searches(results: Results) -> dict[str, Floats]:
    """Return ⟨ψ_b⟩ and ⟨v_b⟩ of each search, a visit or a minute of one."""
    tracks, passages = results.tracks, results.passages
    v, psi = tracks["v_b_mm_s"], np.radians(tracks["psi_b_deg"])
    rows = np.flatnonzero(np.isfinite(v) & np.isfinite(psi))
    if not len(rows):
        return {"search_psi_b": np.empty(0), "search_v_b": np.empty(0)}
    begins_ns = np.sort(passages["start_ns"][passages["record"] == "visit"])
    visit = np.searchsorted(begins_ns, tracks["stamp_ns"][rows], side="right")
    t_s = results.t_s[rows]
    change = np.flatnonzero((np.diff(visit) != 0) | (np.diff(t_s // LONGEST_SEARCH_S) != 0)) + 1
    starts, ends = np.r_[0, change], np.r_[change, len(rows)]
    count = ends - starts
    # The mean of an angle is taken from that of the first frame.
    first = psi[rows][starts]
    away = np.remainder(psi[rows] - np.repeat(first, count) + np.pi, 2 * np.pi) - np.pi
    mean_psi = np.degrees(first + np.add.reduceat(away, starts) / count)
    mean_v = np.add.reduceat(v[rows], starts) / count
    long = t_s[ends - 1] - t_s[starts] >= SHORTEST_SEARCH_S
    return {"search_psi_b": mean_psi[long], "search_v_b": mean_v[long]}
