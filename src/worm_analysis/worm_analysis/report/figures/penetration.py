"""Fig. 9: how far the head gets into the passage before it turns back."""

from typing import Any

import numpy as np

from worm_analysis.pooling import Pool
from worm_analysis.pooling.estimates import FEWEST_FOR_DECAY, penetration_range
from worm_analysis.pooling.trial_sums import DEPTH_EDGES_MM
from worm_analysis.report.evidence import Evidence
from worm_analysis.report.figures.wall_distances import LengthDensity, as_table, draw_points
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import NO_CHAMBER, Panel
from worm_analysis.report.theme import (
    COLUMN_IN,
    GREY,
    HEAD,
    PAGE_IN,
    PAPER_STYLE,
    new_figure,
)
from worm_analysis.results import Floats
from worm_analysis.statistics.estimators import poisson_rate
from worm_analysis.statistics.penetration_law import fit_penetration
from worm_msgs_py import Quantity

BIN_MM = 0.5
MERGED = 5
READING = (
    "<i>x</i><sub>p</sub>: how far along the passage the head got, from where its walls meet the "
    "circle, in an attempt that failed. Points: density with its 95 % Poisson interval. Blue: "
    "<i>F</i>(<i>x</i><sub>p</sub>) = α exp(−β <i>x</i><sub>p</sub>) + constant, by maximum "
    "likelihood from the depth of the circle’s own bulge over the mouth on. Dashed: an exponential "
    "with the paper’s β of this width."
)


def penetration(evidence: Evidence) -> Panel:
    """Return the panel: axes for each W."""
    pool = evidence.pool
    failed = 0 if pool is None else len(pool.events("x_p"))
    n = evidence.counted(failed, "failed attempts")
    base: dict[str, Any] = {
        "key": "fig-9", "title": "How far the head gets before it withdraws", "paper": "Fig. 9",
        "reading": READING, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    rows = [(part, numbers["beta"].quantity) for part, numbers in evidence.by_width]
    if not any(beta.value is not None for _, beta in rows):
        needed = f"{FEWEST_FOR_DECAY} are needed for a W"
        return Panel(**base, why=f"not enough data: {failed} failed attempts, {needed}")
    columns = 1 if len(rows) == 1 else 2
    lines = -(-len(rows) // columns)
    figure = new_figure(COLUMN_IN if columns == 1 else PAGE_IN, 0.3 + 2.0 * lines)
    grid = figure.subplots(lines, columns, squeeze=False)
    tables: dict[str, Any] = {}
    for axes, (part, beta), letter in zip(grid.flat, rows, "abcdefghijklmnop", strict=False):
        axes.set_title(f"({letter}) $W$ = {plain(part.width_mm)} mm", loc="left", pad=3)
        axes.set_xlabel("$x_p$ (mm)")
        axes.set_ylabel("$F(x_p)$ (mm$^{-1}$)")
        drawn = _draw(axes, evidence, part, beta)
        if drawn is not None:
            tables[f"W{part.width_mm:g}"] = as_table(drawn, "x_p_mm")
    for axes in list(grid.flat)[len(rows) :]:
        axes.set_axis_off()
    alt = "; ".join(
        f"W {plain(part.width_mm)} mm, β {with_interval(beta)} per mm" for part, beta in rows
    )
    return Panel(**base, figure=figure, alt=f"Densities of the depth: {alt}.", tables=tables)


def _draw(axes: Any, evidence: Evidence, part: Pool, beta: Quantity) -> LengthDensity | None:
    counts = part.total("x_p")
    failed = int(counts.sum())
    n = evidence.counted_in(part, failed, "failed attempts")
    if beta.value is None:
        axes.text(
            0.5, 0.5, f"not enough data:\n{n}", transform=axes.transAxes, ha="center",
            va="center", color=GREY,
        )  # fmt: skip
        axes.set_xticks([])
        axes.set_yticks([])
        return None
    chosen = penetration_range(part, counts)
    drawn = _density(counts, chosen.start)
    draw_points(axes, drawn)
    fit = fit_penetration(
        DEPTH_EDGES_MM[chosen.start : chosen.stop + 1], np.rint(counts[chosen]).astype(np.int64)
    )
    least = float(DEPTH_EDGES_MM[chosen.start])
    x = np.linspace(least, DEPTH_EDGES_MM[chosen.stop], 200)
    law = fit.alpha[0] * np.exp(-beta.value * (x - least)) + fit.const[0]
    axes.plot(x, law, color=HEAD, label=rf"$\beta$ = {with_interval(beta)} mm$^{{-1}}$")
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


def _density(counts: Floats, first: int) -> LengthDensity:
    """Return the density in bins of half a millimetre, of unit area above the first one fitted."""
    kept = counts[first:]
    bins = -(-len(kept) // MERGED)
    merged = np.pad(kept, (0, bins * MERGED - len(kept))).reshape(bins, MERGED).sum(axis=1)
    last = int(np.flatnonzero(merged)[-1]) + 1
    merged = merged[:last]
    edges = DEPTH_EDGES_MM[first] + BIN_MM * np.arange(last + 1)
    unit = float(merged.sum()) * BIN_MM
    low, high = np.array([poisson_rate(int(count), 1.0)[1:] for count in merged]).T
    n = int(merged.sum())
    return LengthDensity(
        edges, merged / unit, low / unit, high / unit, float(edges[0]), n, int(counts.sum())
    )
