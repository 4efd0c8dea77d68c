"""Fig. 7b: where the head first touches the wall after it has entered a chamber."""

from typing import Any

import numpy as np

from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import COLUMN_IN, INK, PAPER_STYLE, new_figure
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough

_ANGLE_BINS = 18
_READING = (
    "θ<sub>h</sub><sup>0</sup>: polar angle of the head at its first contact with the wall after "
    "it entered a chamber; 0 is the middle of the exit through which it came. One value a visit, "
    "the trial’s first included, but for those in which noise may hide an earlier touch elsewhere. "
    "Dashed: anywhere on the wall with equal probability, as the walk "
    "starts; the paper finds more near the exit."
)


def first_contact(data: ReportData) -> Panel:
    """Return the panel, all widths together."""
    pool = data.pool
    angles = np.empty(0) if pool is None else pool.points("theta_h0")
    n = data.counted(len(angles), "visits")
    base: dict[str, Any] = {
        "key": "fig-7b", "title": "Where the head first touches the wall", "paper": "Fig. 7b",
        "reading": _READING, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if len(angles) < FIGURES.fewest_items:
        return Panel(**base, why=not_enough(len(angles), "visits", FIGURES.fewest_items))
    edges = np.linspace(-180.0, 180.0, _ANGLE_BINS + 1)
    counts, _ = np.histogram(angles, edges)
    density = counts / len(angles) / np.diff(edges)
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    axes.stairs(density, edges, color=INK, linewidth=1.1)
    axes.stairs(density, edges, color=INK, fill=True, alpha=0.1)
    axes.axhline(1 / 360, label="uniform, as in the walk", **PAPER_STYLE)
    axes.set_xlim(-180, 180)
    axes.set_xticks(np.arange(-180, 181, 60))
    axes.set_ylim(0, max(float(density.max()), 1 / 360) * 1.35)
    axes.set_xlabel(r"angle of the first contact $\theta_h^{\,0}$ (degrees)")
    axes.set_ylabel("probability density (1/degree)")
    axes.legend(loc="upper right", title=n, title_fontsize=7.0, alignment="right")
    table = {"from_deg": edges[:-1], "to_deg": edges[1:], "density": density, "visits": counts}
    return Panel(**base, figure=figure, alt=f"Density of θ_h⁰, {n}.", tables={"": table})
