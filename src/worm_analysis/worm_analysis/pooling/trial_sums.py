"""What one trial adds to a pool: sums that can be added up, and its events one by one."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from worm_analysis.pooling.wall_motion import WallMotion, wall_motion
from worm_analysis.results import Floats, Results

RADIUS_EDGES = np.linspace(0.0, 1.2, 121)
"""Of r/R."""
ANGLE_EDGES_DEG = np.linspace(-180.0, 180.0, 181)
DEPTH_EDGES_MM = np.arange(0.0, 35.0 + 1e-9, 0.1)
POINTS_A_TRIAL = 300
"""Frames of a trial that a scatter plot shows at most."""
CONTACT_FACTOR = 0.3


@dataclass(frozen=True, eq=False, slots=True)
class TrialSums:
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
        Sums over frames or events; those of several trials may be added up.
    events : mapping of str to ndarray
        Values of single events (episodes, visits, attempts, stretches of time).
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
    sums: Mapping[str, Floats]
    events: Mapping[str, Floats]


def trial_sums(results: Results, name: str = "", directory: str = "") -> TrialSums:
    """Reduce a trial.

    Parameters
    ----------
    results : Results
        A trial with a chamber.
    name, directory : str
        What to call it, and where it was read from.

    Returns
    -------
    TrialSums
        Lengths in mm, angles in degrees, times in s.
    """
    chamber = results.chambers[0]
    motion = wall_motion(results)
    sums: dict[str, Floats] = {}
    events: dict[str, Floats] = {}
    for part in (
        _frames(results, motion),
        _episodes(results, motion),
        _searches(results, motion),
        _attempts(results),
        _direction(results),
    ):
        sums |= part[0]
        events |= part[1]
    correlation = results.correlation
    return TrialSums(
        name=name,
        directory=directory,
        exit_width_mm=chamber.exit_width_m * 1e3,
        radius_mm=results.radius_mm,
        depth_mm=results.depth_mm,
        frames=len(results.t_s),
        seconds=float(results.t_s[-1]) if len(results.t_s) else 0.0,
        provenance=results.provenance,
        lag_s=np.empty(0) if correlation is None else correlation.lag_s,
        sums=sums,
        events=events,
    )


Parts = tuple[dict[str, Floats], dict[str, Floats]]


def _frames(results: Results, motion: WallMotion) -> Parts:
    """Return what the frames in a chamber add to Figs 1d, 1e and 4a."""
    tracks, R = results.tracks, results.radius_mm
    inside = np.isin(tracks["where"], [chamber.name for chamber in results.chambers])
    inside &= np.isfinite(tracks["r_h_mm"])
    sums = {f"r_{s}": _histogram(tracks[f"r_{s}_mm"][inside] / R, RADIUS_EDGES) for s in "hct"}
    psi = tracks["psi_b_deg"]
    sums["psi_b"] = _histogram(psi[inside], ANGLE_EDGES_DEG)
    contact = tracks["contact"][np.isfinite(tracks["contact"])]
    sums["contact_fraction"] = np.array([contact.sum(), len(contact)])
    v = tracks["v_b_mm_s"]
    moving = np.isfinite(v)
    sums["v_b"] = np.array([np.abs(v[moving]).sum(), moving.sum()])
    both = np.flatnonzero(moving & np.isfinite(psi))
    x, y = psi[both], np.degrees(tracks["theta_dot_rad_s"][both])
    sums["theta_dot_psi_b"] = np.array(
        [len(x), x.sum(), y.sum(), (x * x).sum(), (y * y).sum(), (x * y).sum()]
    )
    by_angle = np.histogram(x, ANGLE_EDGES_DEG[::5])[0].astype(float)
    sums["theta_dot_by_psi_b"] = np.concatenate(
        [np.histogram(x, ANGLE_EDGES_DEG[::5], weights=y)[0], by_angle]
    )
    shown = both[:: max(1, -(-len(both) // POINTS_A_TRIAL))]
    points = {
        "frame_psi_b": psi[shown],
        "frame_theta_dot": np.degrees(tracks["theta_dot_rad_s"][shown]),
    }
    windows = motion.windows
    s = np.sin(np.radians(windows.psi_b_deg))
    sums["v_w"] = np.array([(windows.v_b_mm_s * s).sum(), (s * s).sum(), len(s)])
    return sums, points | {
        "window_psi_b": windows.psi_b_deg,
        "window_v_b": windows.v_b_mm_s,
        "search_psi_b": motion.searches.psi_b_deg,
        "search_v_b": motion.searches.v_b_mm_s,
    }


def _episodes(results: Results, motion: WallMotion) -> Parts:
    """Return what contacts and excursions add to Figs 3 and 4b, and to the reversals.

    Episodes whose start was not seen are left out, those whose end was not seen are censored;
    those below the resolution limit are cut off, as in the trial's own summary.
    """
    contacts = results.contacts
    complete = contacts["complete"] == 1.0
    touching = contacts["kind"] == "contact"
    begun = complete | _follows_another(contacts)
    span_s = (contacts["end_ns"] - contacts["start_ns"]) * 1e-9
    distance = contacts["distance_mm"]
    intervals = float(np.rint(span_s[complete] / motion.interval_s).sum())
    step = float(distance[complete].sum()) / intervals if intervals else 0.0
    pixel = _pixel_mm(results)
    limit = 1.5 * max(step, pixel)
    sums = {"advance": np.array([distance[complete].sum(), intervals])}
    events = {}
    for name, lengths, chosen, cut in (
        ("d_c", distance, touching, limit),
        ("d_nc", distance, ~touching, limit),
        ("delta_r_h", contacts["delta_r_mm"], ~touching, max(pixel, _threshold_mm(results))),
    ):
        above = chosen & begun & (lengths >= cut)
        sums[name] = np.array([(above & complete).sum(), (lengths[above] - cut).sum()])
        events[name] = lengths[chosen & complete]
        events[f"{name}_limit"] = np.full(len(events[name]), cut)
    sums["reversal_per_cycle"] = np.array(motion.reversals, dtype=float)
    sums["whole_episodes"] = np.array(
        [
            part
            for chosen in (touching, ~touching)
            for part in ((chosen & complete).sum(), distance[chosen & begun].sum())
        ],
        dtype=float,
    )
    x, y = motion.collisions.T
    sums["theta_dot_incidence"] = np.array(
        [len(x), x.sum(), y.sum(), (x * x).sum(), (y * y).sum(), (x * y).sum()]
    )
    events["incidence"], events["theta_dot_after"] = x, y
    return sums, events


def _searches(results: Results, motion: WallMotion) -> Parts:
    """Return what visits add to Figs 5, 6 and 7b; a search that was cut short is censored."""
    passages = results.passages
    visits = passages["record"] == "visit"
    began = visits & np.isfinite(passages["first_contact_ns"].astype(float))
    searched_s = (passages["end_ns"] - passages["first_contact_ns"])[began] * 1e-9
    tau = passages["tau_h_s"][visits]
    tau = tau[np.isfinite(tau)]
    theta0 = np.degrees(passages["theta_h0_rad"][began])
    sums = {
        "tau_h": np.array([float(len(tau)), searched_s.sum()]),
        "n_s": np.array([float(results.quantity("n_s").n), motion.observed_s]),
    }
    return sums, {"tau_h": tau, "theta_h0": theta0[np.isfinite(theta0)]}


def _attempts(results: Results) -> Parts:
    """Return what attempts at the exit add to Figs 8 and 9; undecided ones count for nothing."""
    passages = results.passages
    decided = (passages["record"] == "attempt") & (passages["complete"] == 1.0)
    succeeded = decided & (passages["success"] == 1.0)
    failed = decided & (passages["success"] == 0.0)
    touched = passages["wall_contact"][failed]
    phase = passages["stroke_phase"][failed]
    depth = passages["penetration_mm"][failed]
    told, known = np.isfinite(touched), (phase == "elongation") | (phase == "contraction")
    sums = {
        "success": np.array([float(succeeded.sum()), float(decided.sum())]),
        "failures_without_contact": np.array([(touched == 0.0).sum(), told.sum()], dtype=float),
        "failures_in_elongation": np.array(
            [(phase == "elongation").sum(), known.sum()], dtype=float
        ),
        **_causes(touched, phase),
        "x_p": _histogram(depth, DEPTH_EDGES_MM),
    }
    return sums, {"x_p": depth}


def _causes(touched: Floats, phase: NDArray[Any]) -> dict[str, Floats]:
    """Return failures that touched the passage's walls, by phase, of those of a known cause."""
    told = float(((touched == 0.0) | ((touched == 1.0) & (phase != "unknown"))).sum())
    return {
        f"failures_touching_in_{name}": np.array(
            [float(((touched == 1.0) & (phase == name)).sum()), told]
        )
        for name in ("elongation", "contraction")
    }


def _direction(results: Results) -> Parts:
    """Return the products and pairs behind C_θ(t), which add up exactly."""
    correlation = results.correlation
    if correlation is None:
        return {}, {}
    pairs = correlation.pairs.astype(float)
    return {"c_theta": np.concatenate([np.nan_to_num(correlation.c) * pairs, pairs])}, {}


def _histogram(values: Floats, edges: Floats) -> Floats:
    return np.histogram(values[np.isfinite(values)], edges)[0].astype(np.float64)


def _follows_another(contacts: Mapping[str, Any]) -> Any:
    """Return whether the start of each episode was seen: another one ended there."""
    follows = contacts["start_ns"][1:] == contacts["end_ns"][:-1]
    same = contacts["chamber"][1:] == contacts["chamber"][:-1]
    return np.r_[False, follows & same] if len(contacts["start_ns"]) else np.zeros(0, bool)


def _pixel_mm(results: Results) -> float:
    px_per_mm = results.chambers[0].px_per_m / 1e3
    return 1 / px_per_mm if px_per_mm > 0 else 0.0


def _threshold_mm(results: Results) -> float:
    """Return the distance from the wall that counts as contact; 0 where it is not known."""
    settings = (results.provenance.get("parameters") or {}).get("analysis") or {}
    width_m = settings.get("body_width_m")
    width_mm = results.quantity("d_w").value if width_m is None else width_m * 1e3
    factor = settings.get("contact_factor", CONTACT_FACTOR)
    return 0.0 if width_mm is None or width_mm is nan else float(factor) * float(width_mm)
