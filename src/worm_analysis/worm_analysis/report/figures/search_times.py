"""Fig. 5: how long the head takes to find the exit, for each width, beside the walk."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from worm_analysis.pooling import Pool, Pooled, WalkPrediction
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.figures.wall_distances import (
    LengthDensity,
    as_table,
    draw_points,
    exponential_above,
    length_density,
)
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    COLUMN_IN,
    GREY,
    HEAD_COLOUR,
    MODEL_COLOUR,
    PAGE_IN,
    PAPER_STYLE,
    new_figure,
)
from worm_analysis.report.verdicts import not_exponential
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats

ROW_IN = 1.55
_READING = (
    "τ<sub>h</sub>: time from the head’s first contact with the wall after it entered a chamber "
    "until it enters the exit; one value a visit that ended so. Points: density with its 95 % "
    "Poisson interval, on a logarithmic scale, where an exponential law is a straight line. Blue: "
    "the exponential law whose mean is ⟨τ<sub>h</sub>⟩, by maximum likelihood; searches that were "
    "cut short count as longer than what was seen of them."
)
_READING_WALK = (
    " Right: the boundary walk with the parameters of this data, worked out exactly, and the "
    "exponential law of the same mean; dashed: that of the walk with the paper’s parameters."
)


def search_times(data: ReportData) -> Panel:
    """Return the panel: a row for each W, the walk in a second column where there is one."""
    pool = data.pool
    found = 0 if pool is None else len(pool.points("tau_h"))
    walk, paper = (next((w for w in data.walks if w.is_own is own), None) for own in (True, False))
    reading = _READING if walk is None else _READING + _READING_WALK
    base: dict[str, Any] = {
        "key": "fig-5", "title": "Time to find the exit", "paper": "Fig. 5", "reading": reading,
        "n": data.counted(found, "findings of the exit"),
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    rows = data.by_width
    if not rows:
        return Panel(**base, why="the exit’s width is not known")
    if not any(len(part.points("tau_h")) >= FIGURES.fewest_items for part, _ in rows):
        few = not_enough(found, "findings", FIGURES.fewest_items)
        return Panel(**base, why=f"{few} for a W")
    columns, width_in = (1, COLUMN_IN) if walk is None else (2, PAGE_IN)
    figure = new_figure(width_in, max(2.7, 0.35 + ROW_IN * len(rows)))
    grid = figure.subplots(len(rows), columns, squeeze=False, sharex=True, sharey="row")
    longest = max(_longest(part, numbers["tau_h"].quantity) for part, numbers in rows)
    tables: dict[str, Any] = {}
    for row, (part, numbers) in enumerate(rows):
        name = f"W{part.width_mm:g}"
        drawn = _draw_measured(grid[row, 0], data, part, numbers["tau_h"].quantity)
        if drawn is not None:
            tables[f"{name}-measured"] = as_table(drawn, "tau_h_s")
        if walk is not None:
            tables[f"{name}-walk"] = _draw_predicted_density(grid[row, 1], walk, part)
            if paper is not None:
                _draw_paper(grid[row, 1], paper.at_widths("tau_h", [part.width_mm])[0], longest)
            grid[row, 1].legend(loc="upper right")
            if drawn is None:
                _scale_to(grid[row, 1], walk, part)
        for letter, axes in zip(_letters(row, columns), grid[row], strict=True):
            axes.set_title(f"({letter}) $W$ = {plain(part.width_mm)} mm", loc="left", pad=3)
            axes.set_xlim(0, longest)
    for axes, title in zip(grid[0], ("measured", "boundary walk")[:columns], strict=True):
        axes.set_title(title if walk is not None else "", loc="right", pad=3)
    for axes in grid[-1]:
        axes.set_xlabel(r"time to find the exit $\tau_h$ (s)")
    means = [
        f"W {plain(part.width_mm)} mm, mean {with_interval(numbers['tau_h'].quantity)} s"
        for part, numbers in rows
    ]
    alt = f"Densities of the time: {'; '.join(means)}."
    wrong = tuple(filter(None, (_not_exponential(part, numbers) for part, numbers in rows)))
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def _not_exponential(part: Pool, numbers: Mapping[str, Pooled]) -> str:
    told = not_exponential(*(numbers[key].quantity for key in ("tau_h", "tau_h_exponential_p")))
    return f"<i>W</i> = {plain(part.width_mm)} mm: {told}" if told else ""


def _scale_to(axes: Any, walk: WalkPrediction, part: Pool) -> None:
    top = float(walk.density_at(part.width_mm)[1].max())
    axes.set_yscale("log")
    axes.set_ylim(top / 300, 8 * top)


def _letters(row: int, columns: int) -> list[str]:
    return [chr(ord("a") + row * columns + column) for column in range(columns)]


def _longest(part: Pool, mean: Quantity) -> float:
    times = part.points("tau_h")
    return 6.0 * mean.value if mean.value else float(times.max(initial=1.0))


def _draw_measured(axes: Any, data: ReportData, part: Pool, mean: Quantity) -> LengthDensity | None:
    times = part.points("tau_h")
    axes.set_ylabel("density (1/s)")
    n = data.counted_in(part, len(times), "findings")
    if mean.value is None or len(times) < FIGURES.fewest_items:
        axes.text(
            0.5, 0.5, f"not enough data:\n{n}", transform=axes.transAxes, ha="center",
            va="center", color=GREY,
        )  # fmt: skip
        return None
    drawn = _draw_times(axes, times, mean.value)
    x = np.array([0.0, drawn.edges_mm[-1]])
    label = f"mean {with_interval(mean)} s"
    axes.plot(x, exponential_above(x, mean.value, 0.0), color=HEAD_COLOUR, label=label)
    axes.legend(loc="upper right", title=n, title_fontsize=7.0, alignment="right")
    return drawn


def _draw_predicted_density(axes: Any, walk: WalkPrediction, part: Pool) -> dict[str, Floats]:
    edges, density = walk.density_at(part.width_mm)
    mean = walk.at_widths("tau_h", [part.width_mm])[0]
    axes.stairs(density, edges, color=MODEL_COLOUR, linewidth=1.1, label="this data’s")
    x = np.array([0.0, edges[-1]])
    label = f"exponential, mean {plain(mean)} s"
    axes.plot(
        x,
        exponential_above(x, mean, 0.0),
        color=MODEL_COLOUR,
        linewidth=0.7,
        alpha=0.7,
        label=label,
    )
    return {"tau_h_s_from": edges[:-1], "tau_h_s_to": edges[1:], "density": density}


def _draw_paper(axes: Any, mean: float, longest: float) -> None:
    x = np.array([0.0, longest])
    label = f"the paper’s, mean {plain(mean)} s"
    axes.plot(x, exponential_above(x, mean, 0.0), label=label, **PAPER_STYLE)


def _draw_times(axes: Any, times: Floats, mean: float) -> LengthDensity:
    drawn = length_density(times, mean, len(times))
    draw_points(axes, drawn)
    axes.set_yscale("log")
    seen = drawn.density[drawn.density > 0]
    axes.set_ylim(float(seen.min()) / 4, float(max(seen.max(), 1 / mean)) * 8)
    return drawn
