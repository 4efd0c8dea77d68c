"""Simulates, films, tracks and analyses a worm, and asks whether the truth is within.

`python -m benchmarks.whole_system`

Each trial is a worm of two dimensions in both chambers. Its film goes through the tracker and the
analysis; its true head, centroid and tail go through the same analysis. The number from the film
must hold the true one in its 95 % interval: what is checked is camera, tracker and their errors,
not the definitions (`benchmarks.coverage` and `benchmarks.known_worm` check those).
"""

import argparse
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import isfinite, nan
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from rich.console import Console
from rich.table import Table
from scipy.stats import binomtest

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.results import read_results
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
from worm_msgs_py import Quantity
from worm_tracker.tracker import Tracker

WIDTHS_MM = (1.0, 2.0, 3.0, 5.0)
QUANTITIES = (
    "contact_fraction", "d_c", "d_nc", "delta_r_h", "reversal_per_cycle", "t_per", "v_b", "v_w",
    "tau_h", "success", "beta", "r_c_over_R", "psi_b_positive_peak", "psi_b_negative_peak",
)  # fmt: skip
GOOD = 0.90
Numbers = dict[str, Quantity]


def trial(
    seed: int,
    *,
    minutes: float,
    frames_per_s: float,
    px_per_mm: float,
    exit_width_mm: float | None = None,
) -> tuple[Numbers, Numbers]:
    """Return the numbers from a film, and from the true tracks of the same worm."""
    worm = FilamentParameters()
    if exit_width_mm is None:
        exit_width_mm = WIDTHS_MM[seed % len(WIDTHS_MM)]
    rig = FilamentRig(exit_width_mm=exit_width_mm)
    life = simulate(worm, rig, seed=seed, duration_s=60.0 * minutes, frames_per_s=frames_per_s)
    optics = Optics(noise=1.5, shot_noise=0.01, seed=seed)
    view = both_chambers(px_per_mm, rig.exit_width_mm, optics)
    filming = Filming(frames_per_s=frames_per_s, body_width_mm=worm.width_mm)
    tracker, analysis = Tracker(), Analysis()
    for frame in film(life.midline_mm, view, filming):
        for state in tracker.push(np.asarray(frame.picture, np.uint8), frame.stamp_ns):
            analysis.push(state)
    for state in tracker.finish():
        analysis.push(state)
    analysis.finish()
    filmed = {item.name: item for item in analysis.summary()}
    return filmed, _true(life.midline_mm, rig, frames_per_s, worm.width_mm)


def _true(lines: np.ndarray, rig: FilamentRig, frames_per_s: float, width_mm: float) -> Numbers:
    with tempfile.TemporaryDirectory() as folder:
        tracks, out = Path(folder) / "tracks.parquet", Path(folder) / "out"
        out.mkdir()
        pq.write_table(track_table(lines, frames_per_s, width_mm), tracks)
        placed = TableRig(exit_width_mm=rig.exit_width_mm or nan)
        analyse_tracks(TrackTable(tracks), placed, AnalysisParameters(), out)
        return {item.name: item for item in read_results(out).quantities}


def holds(filmed: Quantity, true: Quantity) -> float:
    """Return 1 where the film's interval holds the true number, 0 where not; NaN without both."""
    numbers = (filmed.value, filmed.low, filmed.high, true.value)
    if any(item is None or not isfinite(item) for item in numbers):
        return nan
    return float(filmed.low <= true.value <= filmed.high)


def table_of(pairs: Sequence[tuple[Numbers, Numbers]]) -> Table:
    """Return a row for each number: how often it is held, and how far it is off."""
    columns = ("number", "trials with both", "truth within", "95 %", "median error, %", "refused")
    title = "Numbers from films against those from the same worms' true tracks"
    table = Table(*columns, title=title)
    for name in QUANTITIES:
        both = [(filmed[name], true[name]) for filmed, true in pairs if name in filmed]
        held = np.array([holds(*pair) for pair in both])
        known = held[np.isfinite(held)]
        if not len(known):
            table.add_row(name, "0", "", "", "", str(len(both)))
            continue
        off = [100 * (a.value / b.value - 1) for (a, b), h in zip(both, held, strict=True)
               if isfinite(h) and b.value]  # fmt: skip
        interval = binomtest(int(known.sum()), len(known)).proportion_ci()
        mark = "" if known.mean() >= GOOD else " !"
        table.add_row(name, str(len(known)), f"{100 * known.mean():.0f} %{mark}",
                      f"{100 * interval.low:.0f} … {100 * interval.high:.0f}",
                      f"{np.median(off):+.1f}" if off else "",
                      str(len(both) - len(known)))  # fmt: skip
    return table


def main() -> None:
    """Run the trials in two processes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--fps", type=float, default=15.0)
    parser.add_argument("--px-per-mm", type=float, default=20.0)
    options = parser.parse_args()
    run = partial(
        trial,
        minutes=options.minutes,
        frames_per_s=options.fps,
        px_per_mm=options.px_per_mm,
    )
    with ProcessPoolExecutor(2) as pool:
        pairs = list(pool.map(run, range(options.trials)))
    Console(width=110).print(table_of(pairs))


if __name__ == "__main__":
    main()
