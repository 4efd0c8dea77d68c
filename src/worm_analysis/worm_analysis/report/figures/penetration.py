"""Fig. 9: how far the head gets into the passage before it turns back."""

from typing import Any

import numpy as np

from worm_analysis.accumulators.bins import DEPTH_BIN_M
from worm_analysis.pooling import Pool
from worm_analysis.report.figures.wall_distances import LengthDensity, as_table, draw_points
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    COLUMN_IN,
    HEAD_COLOUR,
    PAGE_IN,
    PAPER_STYLE,
    new_figure,
)
from worm_analysis.report.verdicts import REJECTED, chance
from worm_analysis.statistics.penetration_law import penetration_p
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.summary.estimates import penetration
from worm_analysis.summary.settings import DEFAULTS
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import poisson_rate
from worm_msgs_py.units import MM_PER_M

DEPTH_BIN_MM = MM_PER_M * DEPTH_BIN_M
_DEPTH_BINS_MERGED = 5
"""Bins of the fit that are drawn as one."""
BIN_MM = _DEPTH_BINS_MERGED * DEPTH_BIN_MM
_READING = (
    "<i>x</i><sub>p</sub>: how far along the passage the head got, from where its walls meet the "
    "circle, in an attempt that failed. Points: density with its 95 % Poisson interval. Blue: "
    "<i>F</i>(<i>x</i><sub>p</sub>) = α exp(−β <i>x</i><sub>p</sub>) + constant, by maximum "
    "likelihood from the depth of the circle’s own bulge over the mouth on. Dashed: an exponential "
    "with the paper’s β of this width."
)


def penetration_depths(data: ReportData) -> Panel:
    """Return the panel: axes for each W."""
    pool = data.pool
    failed = 0 if pool is None else len(pool.points("x_p"))
    n = data.counted(failed, "failed attempts")
    base: dict[str, Any] = {
        "key": "fig-9", "title": "How far the head gets before it withdraws", "paper": "Fig. 9",
        "reading": _READING, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    betas = [(part, numbers["beta"].quantity) for part, numbers in data.by_width]
    rows = [(part, beta) for part, beta in betas if beta.value is not None]
    needed = f"{DEFAULTS.fewest_for_decay} are needed for a W"
    if not rows:
        return Panel(**base, why=f"not enough data: {failed} failed attempts, {needed}")
    few = [plain(part.width_mm) for part, beta in betas if beta.value is None]
    if few:
        base["n"] = f"{n}; too few at W = {' and '.join(few)} mm, {needed}"
    columns = 1 if len(rows) == 1 else 2
    lines = -(-len(rows) // columns)
    figure = new_figure(COLUMN_IN if columns == 1 else PAGE_IN, 0.3 + 2.0 * lines)
    grid = figure.subplots(lines, columns, squeeze=False)
    tables: dict[str, Any] = {}
    for axes, (part, beta), letter in zip(grid.flat, rows, "abcdefghijklmnop", strict=False):
        axes.set_title(f"({letter}) $W$ = {plain(part.width_mm)} mm", loc="left", pad=3)
        axes.set_xlabel("depth in the passage $x_p$ (mm)")
        axes.set_ylabel("probability density (1/mm)")
        drawn = _draw_depths(axes, data, part, beta)
        tables[f"W{part.width_mm:g}"] = as_table(drawn, "x_p_mm")
    for axes in list(grid.flat)[len(rows) :]:
        axes.set_axis_off()
    alt = "; ".join(
        f"W {plain(part.width_mm)} mm, β {with_interval(beta)} per mm" for part, beta in rows
    )
    wrong = tuple(filter(None, (_not_the_law(part, beta) for part, beta in rows)))
    alt = f"Densities of the depth: {alt}."
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def _not_the_law(part: Pool, beta: Quantity) -> str:
    """Say that F(x_p) is rejected for a W, if it is."""
    counts = part.total("x_p")
    fit = penetration(counts)
    seen = np.rint(counts[: int(np.flatnonzero(counts)[-1]) + 1]).astype(np.int64)
    edges = np.arange(len(seen) + 1, dtype=np.float64) * DEPTH_BIN_M
    p = penetration_p(edges, seen, fit)
    if not p < REJECTED:
        return ""
    return (
        f"<i>W</i> = {plain(part.width_mm)} mm: a decay over a constant is rejected (χ² test, "
        f"{chance(p)}, <i>n</i> = {seen.sum()}); β says less than it seems to"
    )


def _draw_depths(axes: Any, data: ReportData, part: Pool, beta: Quantity) -> LengthDensity:
    failed = len(part.points("x_p"))
    n = data.counted_in(part, failed, "failed attempts")
    assert beta.value is not None
    counts = part.total("x_p")
    trials, sum_m = part.total("x_p_least")
    least = float(MM_PER_M * sum_m / trials)
    drawn = _depth_density(counts, least, failed)
    draw_points(axes, drawn)
    fit = penetration(counts)
    x = np.linspace(least, least + DEPTH_BIN_MM * (1 + int(np.flatnonzero(counts)[-1])), 200)
    law = fit.alpha[0] / MM_PER_M * np.exp(-beta.value * (x - least)) + fit.const[0] / MM_PER_M
    axes.plot(x, law, color=HEAD_COLOUR, label=rf"$\beta$ = {with_interval(beta)} mm$^{{-1}}$")
    if beta.paper:
        span = x[-1] - least
        paper = beta.paper * np.exp(-beta.paper * (x - least)) / -np.expm1(-beta.paper * span)
        axes.plot(x, paper, label=f"paper, {plain(beta.paper)} mm$^{{-1}}$", **PAPER_STYLE)
    axes.set_yscale("log")
    seen = drawn.density[drawn.density > 0]
    axes.set_ylim(float(seen.min()) / 5, float(seen.max()) * 20)
    axes.set_xlim(0, float(x[-1]) * 1.02)
    axes.legend(loc="upper right", title=n, title_fontsize=7.0, alignment="right")
    return drawn


def _depth_density(counts: Floats, least_mm: float, failed: int) -> LengthDensity:
    """Return the density in bins of half a millimetre, of unit area above the least depth seen."""
    merged = counts.reshape(-1, _DEPTH_BINS_MERGED).sum(axis=1)
    last = int(np.flatnonzero(merged)[-1]) + 1
    merged = merged[:last]
    edges: Floats = least_mm + BIN_MM * np.arange(last + 1, dtype=np.float64)
    unit = float(merged.sum()) * BIN_MM
    low, high = np.array([poisson_rate(int(count), 1.0)[1:] for count in merged]).T
    n = int(merged.sum())
    return LengthDensity(edges, merged / unit, low / unit, high / unit, float(edges[0]), n, failed)
