"""A trial's motion along the wall from its tables: means over time, turns, and collisions."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from worm_analysis.accumulators.swimming_speed import FULL
from worm_analysis.results import Floats, Results

MAX_GAP_S, MEAN_WINDOW_S, THETA_DOT_WINDOW_S = 0.5, 12.0, 1.0
LONGEST_SEARCH_S = 60.0
SHORTEST_SEARCH_S = 5.0


@dataclass(frozen=True, eq=False, slots=True)
class Means:
    """Means over stretches of time: ⟨ψ_b⟩ and ⟨v_b⟩."""

    psi_b_deg: Floats
    v_b_mm_s: Floats


@dataclass(frozen=True, eq=False, slots=True)
class WallMotion:
    """What the frames of a search along the wall give.

    Attributes
    ----------
    interval_s : float
        Median time between two frames.
    observed_s : float
        Time in a chamber, breaks left out.
    windows : Means
        Over windows of a few seconds, for v_w.
    searches : Means
        Over searches, from the first contact of a visit on; a long one is cut into minutes.
    reversals : (int, int)
        Cycles (a contact and the excursion after it) that differ in direction from the cycle
        before, and pairs of cycles in all.
    collisions : ndarray, shape (n, 2)
        θ_h^i in degrees and θ̇_h over the time after it in degrees/s, of each contact.
    """

    interval_s: float
    observed_s: float
    windows: Means
    searches: Means
    reversals: tuple[int, int]
    collisions: Floats


def wall_motion(results: Results) -> WallMotion:
    """Return the motion along the wall of a trial."""
    settings = (results.provenance.get("parameters") or {}).get("analysis") or {}
    gap_s = float(settings.get("max_gap_s", MAX_GAP_S))
    window_s = float(settings.get("mean_window_s", MEAN_WINDOW_S))
    after_s = float(settings.get("theta_dot_window_s", THETA_DOT_WINDOW_S))
    tracks, t_s = results.tracks, results.t_s
    theta = tracks["theta_h_rad"]
    rows = np.flatnonzero(np.isfinite(theta) & np.isfinite(tracks["contact"]))
    step_s = np.diff(t_s[rows])
    same = tracks["where"][rows][1:] == tracks["where"][rows][:-1]
    visit = np.searchsorted(_visit_starts(results), tracks["stamp_ns"], side="right")
    joined = (step_s <= gap_s) & same & (visit[rows][1:] == visit[rows][:-1])
    stretch = np.zeros(len(t_s), dtype=np.int64) - 1
    stretch[rows] = np.r_[0, np.cumsum(~joined)] if len(rows) else 0
    interval_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else 1.0
    return WallMotion(
        interval_s=interval_s,
        observed_s=float(step_s[joined].sum()),
        windows=_windows(results, stretch, window_s),
        searches=_means(results, (visit, t_s // LONGEST_SEARCH_S), SHORTEST_SEARCH_S),
        reversals=_reversals(results),
        collisions=_collisions(results, stretch, after_s),
    )


def _visit_starts(results: Results) -> Any:
    passages = results.passages
    return np.sort(passages["start_ns"][passages["record"] == "visit"])


def _windows(results: Results, stretch: Any, window_s: float) -> Means:
    """Return the means of `speed_law.SpeedLaw`: sides of the normal averaged apart.

    ⟨ψ_b⟩ is the angle whose sine is the mean of both sides' sines.
    """
    tracks = results.tracks
    v, psi = tracks["v_b_mm_s"], np.radians(tracks["psi_b_deg"])
    rows = np.flatnonzero(np.isfinite(v) & np.isfinite(psi) & (stretch >= 0))
    if not len(rows):
        return Means(np.empty(0), np.empty(0))
    t_s, piece = results.t_s[rows], stretch[rows]
    begun, length = np.unique(piece, return_index=True, return_counts=True)[1:]
    window = (t_s - np.repeat(t_s[begun], length) + 1e-9) // window_s
    starts = np.r_[0, np.flatnonzero((np.diff(piece) != 0) | (np.diff(window) != 0)) + 1]
    ends = np.r_[starts[1:], len(rows)]
    left = psi[rows] > 0
    sine = np.zeros(len(starts))
    for side in (left, ~left):
        count = np.add.reduceat(side.astype(np.float64), starts)
        angle = np.add.reduceat(psi[rows] * side, starts) / np.maximum(count, 1.0)
        sine += count * np.sin(angle) / (ends - starts)
    mean_v = np.add.reduceat(v[rows], starts) / (ends - starts)
    full = t_s[ends - 1] - t_s[starts] >= FULL * window_s
    return Means(np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))[full], mean_v[full])


def _means(results: Results, keys: tuple[Any, Any], shortest_s: float) -> Means:
    """Return ⟨ψ_b⟩ and ⟨v_b⟩ of all frames that share both keys."""
    tracks = results.tracks
    v, psi = tracks["v_b_mm_s"], np.radians(tracks["psi_b_deg"])
    rows = np.flatnonzero(np.isfinite(v) & np.isfinite(psi))
    if not len(rows):
        return Means(np.empty(0), np.empty(0))
    first, second = (np.asarray(key)[rows].astype(np.int64) for key in keys)
    change = np.flatnonzero((np.diff(first) != 0) | (np.diff(second) != 0)) + 1
    starts = np.r_[0, change]
    ends = np.r_[change, len(rows)]
    t_s = results.t_s[rows]
    long = t_s[ends - 1] - t_s[starts] >= shortest_s
    count = ends - starts
    # The mean of an angle is taken from that of the first frame.
    first_psi = psi[rows][starts]
    away = np.remainder(psi[rows] - np.repeat(first_psi, count) + np.pi, 2 * np.pi) - np.pi
    mean_psi = first_psi + np.add.reduceat(away, starts) / count
    mean_v = np.add.reduceat(v[rows], starts) / count
    return Means(np.degrees(mean_psi)[long], mean_v[long])


def _rows_at(results: Results, stamps_ns: Any) -> Any:
    """Return the rows of the frames with these stamps."""
    return np.searchsorted(results.tracks["stamp_ns"], stamps_ns)


def _reversals(results: Results) -> tuple[int, int]:
    contacts, theta = results.contacts, results.tracks["theta_h_rad"]
    if not len(contacts["start_ns"]):
        return 0, 0
    last = len(theta) - 1
    start, end = (
        np.minimum(_rows_at(results, contacts[f"{name}_ns"]), last) for name in ("start", "end")
    )
    turn = theta[end] - theta[start]
    touching = contacts["kind"] == "contact"
    whole = contacts["complete"] == 1.0
    # A cycle is a complete contact and the complete excursion that follows it at once.
    joined = contacts["end_ns"][:-1] == contacts["start_ns"][1:]
    cycle = np.flatnonzero(touching[:-1] & ~touching[1:] & whole[:-1] & whole[1:] & joined)
    direction = np.sign(turn[cycle] + turn[cycle + 1])
    # The next cycle must begin where this one ends.
    linked = (np.diff(cycle) == 2) & (
        contacts["end_ns"][cycle[:-1] + 1] == contacts["start_ns"][cycle[1:]]
    )
    told = linked & (direction[1:] != 0) & (direction[:-1] != 0)
    told &= np.isfinite(direction[1:]) & np.isfinite(direction[:-1])
    return int((direction[1:] != direction[:-1])[told].sum()), int(told.sum())


def _collisions(results: Results, stretch: Any, after_s: float) -> Floats:
    contacts, theta, t_s = results.contacts, results.tracks["theta_h_rad"], results.t_s
    incidence = contacts["incidence_deg"]
    begun = np.flatnonzero((contacts["kind"] == "contact") & np.isfinite(incidence))
    rows = np.flatnonzero(stretch >= 0)
    if not len(begun) or not len(rows):
        return np.empty((0, 2))
    start = np.searchsorted(rows, _rows_at(results, contacts["start_ns"][begun]))
    start = np.minimum(start, len(rows) - 1)
    goal_s = t_s[rows[start]] + after_s
    after = np.searchsorted(t_s[rows], goal_s - 1e-9)
    known = after < len(rows)
    after = np.minimum(after, len(rows) - 1)
    known &= stretch[rows[after]] == stretch[rows[start]]
    there = np.interp(goal_s, t_s[rows], theta[rows])
    speed = np.degrees(there - theta[rows[start]]) / after_s
    return np.asarray(np.stack([incidence[begun], speed], axis=1)[known], dtype=np.float64)
