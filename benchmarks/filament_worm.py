"""What emerges from the worm in two dimensions, beside what the paper measured.

Trials of the active filament over the paper's exit widths are seen at 30 frames/s, without noise,
and analysed as any other trial. Only the parameters that say so are fitted
(`worm_model.filament.parameters`); each of them is then changed by a quarter to see what hangs on
it. Writes docs/filament_worm.md and docs/filament_worm.png.
"""

import argparse
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import nan
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

from benchmarks import filament_figure
from benchmarks.filament_states import centroids, geometry_of, states_of_filament
from worm_analysis.analysis import Analysis
from worm_analysis.summary.quantities import quantities
from worm_analysis.summary.sums import Sums
from worm_model.filament.parameters import FITTED, FilamentParameters, parameter_table
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import simulate
from worm_msgs_py import Attempt, Episode, EpisodeKind, Quantity, Visit
from worm_msgs_py.paper import paper_value
from worm_msgs_py.units import MM_PER_M

DOCS = Path(__file__).parents[1] / "docs"
WIDTHS_MM = (0.5, 1.0, 2.0, 3.0, 5.0)
FRAMES_PER_S = 30.0
CHANGE = 0.25
SHOWN_S = 120.0
ROW_MINUTES = 15.0
"""Of the one trial, at W = 1 mm, that shows what a change does."""
SENSITIVE = (
    "r_c_over_R", "psi_b_positive_peak", "v_w", "d_c", "d_nc", "delta_r_h", "t_per", "tau_h",
    "success", "beta",
)  # fmt: skip
POOLED = (
    "r_h_over_R", "r_c_over_R", "psi_b_negative_peak", "psi_b_positive_peak", "v_w",
    "theta_dot_psi_b_correlation", "theta_dot_incidence_correlation", "d_c", "d_c_exponential_p",
    "d_nc", "d_nc_exponential_p", "delta_r_h", "delta_r_h_exponential_p", "t_per", "t_1e",
    "reversal_per_cycle", "contact_fraction",
)  # fmt: skip
BY_WIDTH = (
    "tau_h", "tau_h_exponential_p", "n_s", "success", "beta", "failures_without_contact",
    "failures_touching_in_elongation", "t_per",
)  # fmt: skip
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """One trial, analysed."""

    width_mm: float
    sums: Mapping[str, Floats]
    lag_s: Floats
    points: Mapping[str, Floats]
    path_mm: Floats
    cpu_s: float


def measure(parameters: FilamentParameters, minutes: float, job: tuple[float, int]) -> Measured:
    """Simulate and analyse one trial."""
    width_mm, seed = job
    begin = process_time()
    trial = simulate(
        parameters,
        FilamentRig(exit_width_mm=width_mm),
        seed=seed,
        duration_s=60.0 * minutes,
        frames_per_s=FRAMES_PER_S,
    )
    cpu_s = process_time() - begin
    analysis = Analysis()
    analysis.set_geometry(geometry_of(trial))
    events = []
    for state in states_of_filament(trial):
        events += analysis.push(state)[1]
    events += analysis.finish()
    points = points_of(events)
    for found in analysis.distributions():
        if found.name in ("r_h", "r_c", "r_t", "psi_b"):
            points[f"{found.name}_counts"] = found.counts.astype(np.float64)
            points[f"{found.name}_edges"] = found.edges
    shown = slice(0, round(SHOWN_S * FRAMES_PER_S))
    midline = trial.midline_mm[shown]
    keypoints = (midline[:, 0], centroids(midline), midline[:, -1])
    path_mm = np.concatenate([np.stack(keypoints, axis=1), midline], axis=1)
    lag_s = analysis.correlation().lag_s
    return Measured(width_mm, analysis.sums(), lag_s, points, path_mm, cpu_s)


def points_of(events: Sequence[object]) -> dict[str, Floats]:
    """Return the lengths of whole episodes (mm), τ_h (s) and x_p (mm) of failed attempts."""
    whole = [item for item in events if isinstance(item, Episode) and item.complete]
    free = [item for item in whole if item.kind is EpisodeKind.FREE]
    touching = [item for item in whole if item.kind is EpisodeKind.CONTACT]
    failed = [e for e in events if isinstance(e, Attempt) and e.complete and not e.success]
    found = {
        "d_c": [MM_PER_M * item.distance_m for item in touching],
        "d_nc": [MM_PER_M * item.distance_m for item in free],
        "delta_r_h": [MM_PER_M * item.delta_r_m for item in free],
        "x_p": [MM_PER_M * item.penetration_m for item in failed],
        "tau_h": [e.tau_h_s for e in events if isinstance(e, Visit) and e.complete],
    }
    return {name: np.array([v for v in values if v == v]) for name, values in found.items()}


def numbers(trials: Sequence[Measured]) -> dict[str, Quantity]:
    """Return all quantities of some trials taken together."""
    widths = {trial.width_mm for trial in trials}
    width_mm = widths.pop() if len(widths) == 1 else nan
    sums = Sums([trial.sums for trial in trials], width_mm, trials[0].lag_s)
    return {quantity.name: quantity for quantity in quantities(sums)}


def changed(parameters: FilamentParameters) -> Iterator[tuple[str, FilamentParameters]]:
    """Yield the fitted parameters, each a quarter smaller and larger."""
    for name, value, _, _, source in parameter_table(parameters):
        if source.startswith(FITTED):
            for factor in (1.0 - CHANGE, 1.0 + CHANGE):
                yield f"{name} × {factor:g}", replace(parameters, **{name: factor * value})


def without(parameters: FilamentParameters) -> Iterator[tuple[str, FilamentParameters]]:
    """Yield the worm with one of the things that it does left out."""
    yield "no peristalsis", replace(parameters, peristalsis_mm=0.0)
    yield "no undulation", replace(parameters, undulation_mm=0.0)
    yield "no search of the head", replace(parameters, head_bend_per_mm=0.0)
    yield "no withdrawals", replace(parameters, withdrawal_per_s=0.0)
    yield "40 segments", replace(parameters, segments=40)
    yield "strands may overlap", replace(parameters, self_contact=False)


def cell(quantity: Quantity) -> str:
    """Return a number with its interval and n, or why there is none."""
    if quantity.value is None:
        return f"– ({quantity.why}; n = {quantity.n})"
    ends = [quantity.low, quantity.high]
    interval = "" if None in ends else f" [{ends[0]:.2g}, {ends[1]:.2g}]"
    return f"{quantity.value:.3g}{interval}, n = {quantity.n}"


def paper_cell(name: str, width_mm: float = nan) -> str:
    """Return the paper's value, or that it gives none."""
    value = paper_value(name, width_mm)
    if name.endswith("exponential_p"):
        return "exponential"
    if name == "theta_dot_incidence_correlation":
        return "none evident"
    return "–" if value is None else f"{value:g}"


def tables(
    trials: Sequence[Measured], sensitivity: Mapping[str, dict[str, Quantity]], minutes: float
) -> str:
    """Return the tables of the page."""
    together = numbers(trials)
    lines = [
        f"{len(trials)} trials of {minutes:g} min, {len(trials) // len(WIDTHS_MM)} for each W; 95 %"
        " intervals; p: fit of an exponential law, small is bad.",
        "",
        "| quantity | unit | emerges (all W) | paper |",
        "|---|---|---|---|",
    ]
    for name in POOLED:
        quantity = together[name]
        lines.append(f"| `{name}` | {quantity.unit} | {cell(quantity)} | {paper_cell(name)} |")
    by_width = {w: numbers([trial for trial in trials if trial.width_mm == w]) for w in WIDTHS_MM}
    lines += ["", "| quantity | unit | " + " | ".join(f"W = {w:g} mm" for w in WIDTHS_MM) + " |"]
    lines.append("|---" * (len(WIDTHS_MM) + 2) + "|")
    for name in BY_WIDTH:
        row = [cell(by_width[w][name]) for w in WIDTHS_MM]
        lines.append(f"| `{name}` | {together[name].unit} | " + " | ".join(row) + " |")
        if any(paper_value(name, w) is not None for w in WIDTHS_MM):
            row = [paper_cell(name, w) for w in WIDTHS_MM]
            lines.append(f"| — paper | {together[name].unit} | " + " | ".join(row) + " |")
    lines += ["", "### Changes", ""]
    lines += [f"One trial of {ROW_MINUTES:g} min a row, W = 1 mm, ± half of the 95 % interval.", ""]
    lines += ["| change | " + " | ".join(f"`{name}`" for name in SENSITIVE) + " |"]
    lines.append("|---" * (len(SENSITIVE) + 1) + "|")
    for change, found in sensitivity.items():
        row = [short_cell(found[name]) for name in SENSITIVE]
        lines.append(f"| {change} | " + " | ".join(row) + " |")
    lines += ["", "### Parameters", "", "| parameter | value | unit | meaning | source |"]
    lines.append("|---|---|---|---|---|")
    lines += [parameter_row(*row) for row in parameter_table(FilamentParameters())]
    return "\n".join(lines) + "\n"


def parameter_row(name: str, value: float | bool, unit: str, meaning: str, source: str) -> str:
    """Return a row of the table of parameters."""
    told = ("yes" if value else "no") if isinstance(value, bool) else f"{value:g}"
    return f"| `{name}` | {told} | {unit} | {meaning} | {source} |"


def short_cell(quantity: Quantity) -> str:
    """Return a number with half the width of its interval."""
    if quantity.value is None:
        return "–"
    if quantity.low is None or quantity.high is None:
        return f"{quantity.value:.3g}"
    return f"{quantity.value:.3g} ± {0.5 * (quantity.high - quantity.low):.1g}"


def main() -> None:
    """Print the tables; write them into the page between its marks, and draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="trials for each W")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--no-write", action="store_true", help="leave docs/ as it is")
    given = parser.parse_args()
    worm = FilamentParameters()
    jobs = [(w, 100 + seed) for seed in range(given.seeds) for w in WIDTHS_MM]
    with ProcessPoolExecutor(given.workers) as pool:
        found = pool.map(partial(measure, worm, given.minutes), jobs)
        trials = sorted(found, key=lambda trial: trial.width_mm)
        variants = {"as it is": worm, **dict(without(worm)), **dict(changed(worm))}
        runs = {
            name: pool.submit(measure, variant, ROW_MINUTES, (1.0, 100))
            for name, variant in variants.items()
        }
        sensitivity = {name: numbers([run.result()]) for name, run in runs.items()}
    text = tables(trials, sensitivity, given.minutes)
    print(text)
    slowest = max(trial.cpu_s for trial in trials)
    print(f"The slowest trial took {slowest:.0f} s of one core.")
    if not given.no_write:
        page = DOCS / "filament_worm.md"
        before, _, rest = page.read_text("utf-8").partition(START)
        after = rest.partition(END)[2]
        page.write_text(f"{before}{START}\n{text}{END}{after}", "utf-8")
        by_width = {w: numbers([t for t in trials if t.width_mm == w]) for w in WIDTHS_MM}
        filament_figure.draw(trials, numbers(trials), by_width, DOCS / "filament_worm.png")


START, END = "<!-- from here on: python -m benchmarks.filament_worm -->", "<!-- to here -->"

if __name__ == "__main__":
    main()
