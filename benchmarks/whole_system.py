"""Simulates, films, tracks and analyses a worm, and asks whether the truth is within.

`python -m benchmarks.whole_system`

Each trial is a worm of two dimensions in both chambers. Its film goes through the tracker and the
analysis; its true head, centroid and tail go through the same analysis. The number from the film
must hold the true one in its 95 % interval: what is checked is camera, tracker and their errors,
not the definitions (`benchmarks.coverage` and `benchmarks.known_worm` check those). What one trial
is too short for is asked of the trials of a width together, and each attempt and search of a film
is held to the true one.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import isfinite, nan
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray
from scipy.stats import binomtest

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.results import read_results
from worm_analysis.summary.quantities import DEFINITIONS
from worm_analysis.summary.sums import Sums, TrialSums
from worm_bringup.tracks.simulated_tracks import track_table
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import TableRig
from worm_bringup.tracks.track_table import TrackTable
from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import simulate
from worm_model.simulator.filming import Filming, film
from worm_model.simulator.rig import Optics
from worm_model.simulator.rig.views import both_chambers
from worm_msgs_py import Attempt, Event, Quantity, Visit
from worm_tracker.tracker import Tracker

WIDTHS_MM = (1.0, 2.0, 3.0, 5.0)
QUANTITIES = (
    "contact_fraction", "d_c", "d_nc", "delta_r_h", "reversal_per_cycle", "t_per", "v_b", "v_w",
    "tau_h", "success", "failures_without_contact", "beta", "r_h_over_R", "r_c_over_R",
    "psi_b_positive_peak", "psi_b_negative_peak",
)  # fmt: skip
GOOD = 0.90
SAME_S = 0.5
"""An attempt of the film and a true one that begin within this time are one."""
Floats = NDArray[np.float64]
Numbers = dict[str, Quantity]


@dataclass(frozen=True)
class Measured:
    """What the analysis gives of one trial.

    Attributes
    ----------
    numbers : dict of str to Quantity
        By name.
    sums : mapping of str to ndarray
        What it adds to a pool; `lag_s` are those of C_θ.
    attempts : ndarray, shape (n, 3)
        Of the decided ones: when it begins, s; x_p, mm; whether it succeeds.
    searches : ndarray, shape (n, 2)
        Of those that found the exit: when, s, and τ_h, s.
    """

    numbers: Numbers
    sums: TrialSums
    lag_s: Floats
    attempts: Floats
    searches: Floats


def trial(
    seed: int,
    *,
    minutes: float,
    frames_per_s: float,
    px_per_mm: float,
    exit_width_mm: float | None = None,
) -> tuple[Measured, Measured]:
    """Return what comes of a film, and of the true tracks of the same worm."""
    cv2.setNumThreads(1)
    worm = FilamentParameters()
    if exit_width_mm is None:
        exit_width_mm = WIDTHS_MM[seed % len(WIDTHS_MM)]
    rig = FilamentRig(exit_width_mm=exit_width_mm)
    life = simulate(worm, rig, seed=seed, duration_s=60.0 * minutes, frames_per_s=frames_per_s)
    optics = Optics(noise=1.5, shot_noise=0.01, seed=seed)
    view = both_chambers(px_per_mm, rig.exit_width_mm, optics)
    filming = Filming(frames_per_s=frames_per_s, body_width_mm=worm.width_mm)
    tracker, analysis = Tracker(), Analysis()
    events: list[Event] = []
    for frame in film(life.midline_mm, view, filming):
        for state in tracker.push(np.asarray(frame.picture, np.uint8), frame.stamp_ns):
            events += analysis.push(state)[1]
    for state in tracker.finish():
        events += analysis.push(state)[1]
    events += analysis.finish()
    true = _true(life.midline_mm, rig, frames_per_s, worm.width_mm)
    return _measured(analysis, events), true


def _measured(analysis: Analysis, events: Sequence[Event]) -> Measured:
    attempts = [
        (item.start_ns / 1e9, 1e3 * item.penetration_m, item.success)
        for item in events
        if isinstance(item, Attempt) and item.complete
    ]
    searches = [
        (item.end_ns / 1e9, item.tau_h_s)
        for item in events
        if isinstance(item, Visit) and isfinite(item.tau_h_s)
    ]
    return Measured(
        {item.name: item for item in analysis.summary()},
        analysis.sums(),
        analysis.correlation().lag_s,
        np.array(attempts, dtype=np.float64).reshape(-1, 3),
        np.array(searches, dtype=np.float64).reshape(-1, 2),
    )


def _true(lines: Floats, rig: FilamentRig, frames_per_s: float, width_mm: float) -> Measured:
    with tempfile.TemporaryDirectory() as folder:
        tracks, out = Path(folder) / "tracks.parquet", Path(folder) / "out"
        out.mkdir()
        pq.write_table(track_table(lines, frames_per_s, width_mm), tracks)
        placed = TableRig(exit_width_mm=rig.exit_width_mm or nan)
        analyse_tracks(TrackTable(tracks), placed, AnalysisParameters(), out)
        found = read_results(out)
    rows, correlation = found.passages, found.correlation
    decided = (rows["record"] == "attempt") & (rows["complete"] == 1.0)
    searched = (rows["record"] == "visit") & np.isfinite(rows["tau_h_s"])
    attempts = (rows["start_ns"] / 1e9, rows["penetration_mm"], rows["success"])
    return Measured(
        {item.name: item for item in found.quantities},
        found.sums,
        np.empty(0) if correlation is None else correlation.lag_s,
        np.column_stack(attempts)[decided],
        np.column_stack((rows["end_ns"] / 1e9, rows["tau_h_s"]))[searched],
    )


def holds(filmed: Quantity, true: Quantity) -> float:
    """Return 1 where the film's interval holds the true number, 0 where not; NaN without both."""
    numbers = (filmed.value, filmed.low, filmed.high, true.value)
    if any(item is None or not isfinite(item) for item in numbers):
        return nan
    return float(filmed.low <= true.value <= filmed.high)


def rows_of(pairs: Sequence[tuple[Numbers, Numbers]]) -> Iterator[str]:
    """Yield a row for each number: how often it is held, and how far it is off."""
    yield "| number | told by both | truth within | median error, % | largest, % | by one, none |"
    yield "|---|---|---|---|---|---|"
    for name in QUANTITIES:
        both = [(filmed[name], true[name]) for filmed, true in pairs if name in filmed]
        held = np.array([holds(*pair) for pair in both])
        known = held[np.isfinite(held)]
        one = sum((filmed.value is None) != (true.value is None) for filmed, true in both)
        other = f"{one}, {len(both) - len(known) - one}"
        if not len(known):
            yield f"| {name} | 0 | | | | {other} |"
            continue
        off = [100 * (a.value / b.value - 1) for (a, b), h in zip(both, held, strict=True)
               if isfinite(h) and b.value]  # fmt: skip
        interval = binomtest(int(known.sum()), len(known)).proportion_ci()
        within = (
            f"{100 * known.mean():.0f} % [{100 * interval.low:.0f} … {100 * interval.high:.0f}]"
        )
        mark = "" if known.mean() >= GOOD else " **!**"
        errors = f"{np.median(off):+.1f} | {max(off, key=abs):+.1f}" if off else "|"
        yield f"| {name} | {len(known)} | {within}{mark} | {errors} | {other} |"


def pooled(trials: Sequence[Measured], width_mm: float) -> Numbers:
    """Return the numbers of trials of one width together."""
    sums = Sums([one.sums for one in trials], width_mm, trials[0].lag_s)
    return {name: DEFINITIONS[name].of(sums) for name in QUANTITIES}


def of_widths(pairs: Sequence[tuple[Measured, Measured]]) -> list[tuple[Numbers, Numbers]]:
    """Return the pairs of pools, one for each width."""
    step = len(WIDTHS_MM)
    return [
        (pooled([film for film, _ in group], width), pooled([true for _, true in group], width))
        for k, width in enumerate(WIDTHS_MM)
        if (group := pairs[k::step])
    ]


def lines_of_events(pairs: Sequence[tuple[Measured, Measured]]) -> Iterator[str]:
    """Yield how attempts and searches of films differ from the true ones."""
    count = matched = alike = films = searches = found = 0
    x_p, tau = [], []
    for film_of, true_of in pairs:
        films, count = films + len(film_of.attempts), count + len(true_of.attempts)
        searches += len(true_of.searches)
        for start_s, depth_mm, success in true_of.attempts:
            for _, told_mm, told_success in _nearest(film_of.attempts, start_s):
                matched, alike = matched + 1, alike + (told_success == success)
                x_p += [] if success else [told_mm - depth_mm]
        for end_s, tau_s in true_of.searches:
            told = _nearest(film_of.searches, end_s)
            found += len(told)
            tau += (told[:, 1] - tau_s).tolist()
    yield (
        f"Attempts: {count} true, {films} in the films, {matched} in both; success alike in {alike}"
    )
    yield f"x_p of the failures less the true one: {_spread(x_p)} mm"
    yield f"Searches that find the exit: {searches} true, {found} in both"
    yield f"τ_h less the true one: {_spread(tau)} s"


def _nearest(rows: Floats, at_s: float) -> Floats:
    """Return the row whose first column is nearest to a time; none where it is another event."""
    off = np.abs(rows[:, 0] - at_s)
    return rows[np.argsort(off)[:1]][np.sort(off)[:1] < SAME_S]


def _spread(values: Sequence[float]) -> str:
    if not len(values):
        return "none"
    low, middle, high = np.quantile(values, [0.025, 0.5, 0.975])
    return f"median {middle:+.3f}, 95 % within {low:+.3f} … {high:+.3f}, n = {len(values)},"


def main() -> None:
    """Run the trials and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--fps", type=float, default=15.0)
    parser.add_argument("--px-per-mm", type=float, default=20.0)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    run = partial(
        trial,
        minutes=options.minutes,
        frames_per_s=options.fps,
        px_per_mm=options.px_per_mm,
    )
    with ProcessPoolExecutor(options.workers) as pool:
        pairs = list(pool.map(run, range(options.trials)))
    print("Each trial:", *rows_of([(a.numbers, b.numbers) for a, b in pairs]), sep="\n")
    print("\nThe trials of each width together:", *rows_of(of_widths(pairs)), sep="\n")
    print("\nEvents:", *lines_of_events(pairs), sep="\n")


if __name__ == "__main__":
    main()
