"""Fig. 1d: how far head, centroid and tail are from the chamber's centre."""

from functools import partial
from typing import Any

import numpy as np

from worm_analysis.accumulators.bins import RADIUS_EDGES
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    COLOURS,
    COLUMN_IN,
    PAPER_STYLE,
    new_figure,
    say_n,
)
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.paper import paper_number

_BINS_MERGED = 2
"""Bins of R/100 that are drawn as one."""
_SHOWN_BINS = 55
_LETTERS = {"head": "h", "centroid": "c", "tail": "t"}
_READING = (
    "<i>P</i>(<i>r</i>) d<i>r</i> is the fraction of frames in which head tip "
    "(<i>r</i><sub>h</sub>), centroid (<i>r</i><sub>c</sub>) or tail tip (<i>r</i><sub>t</sub>) "
    "is at a distance between <i>r</i> and <i>r</i> + d<i>r</i> from the centre of its chamber; "
    "each curve has unit area and is not divided by the circumference 2π<i>r</i>, so a point "
    "that is anywhere with equal probability would give a straight line through the origin "
    "(dotted). Frames in the passage are left out. Dashed: the paper's "
    "<i>r</i><sub>c</sub>/<i>R</i> ≈ 0.6."
)


def radial_density(counts: Floats, radius_mm: float) -> tuple[Floats, Floats]:
    """Return the normalised density of distances from the centre.

    Parameters
    ----------
    counts : ndarray, shape (120,)
        Frames in bins of R/100.
    radius_mm : float
        R.

    Returns
    -------
    edges_mm : ndarray, shape (56,)
        Edges of bins of R/50, up to 1.1 R.
    density : ndarray, shape (55,)
        1/mm, of unit area where no distance is beyond the last edge.
    """
    edges: Floats = RADIUS_EDGES[::_BINS_MERGED][: _SHOWN_BINS + 1] * radius_mm
    merged = counts.reshape(-1, _BINS_MERGED).sum(axis=1)[:_SHOWN_BINS]
    density: Floats = merged / (max(float(counts.sum()), 1.0) * np.diff(edges))
    return edges, density


def radii(data: ReportData) -> Panel:
    """Return the panel, all chambers and trials together."""
    pool = data.pool
    frames = 0 if pool is None else int(pool.total("r_h").sum())
    n = data.counted(frames, "frames")
    base: dict[str, Any] = {
        "key": "fig-1d",
        "title": "Distance from the chamber's centre",
        "paper": "Fig. 1d",
        "reading": _READING,
        "n": n,
    }
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if frames < FIGURES.fewest_frames:
        return Panel(**base, why=not_enough(frames, "frames", FIGURES.fewest_frames))
    R = pool.radius_mm
    table: dict[str, Any] = {}
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    axes.plot([0, R], [0, 2 / R], ":", color="#9a9a9a", linewidth=0.9)
    for point in KEYPOINTS:
        symbol = _LETTERS[point]
        if not pool.sums.has(f"r_{symbol}"):  # a table of another tracker may lack the tail
            continue
        edges, density = radial_density(pool.total(f"r_{symbol}"), R)
        table |= {"r_mm": (edges[1:] + edges[:-1]) / 2, f"P_r_{symbol}_per_mm": density}
        axes.stairs(
            density, edges, color=COLOURS[point], linewidth=1.1, label=f"$r_{symbol}$, {point}"
        )
        axes.stairs(density, edges, color=COLOURS[point], fill=True, alpha=0.12)
    axes.axvline(R, color="#1a1a1a", linewidth=0.8)
    axes.set_xlim(0, 1.1 * R)
    axes.set_ylim(0, axes.get_ylim()[1] * 1.12)
    axes.set_xlabel("distance from the centre $r$ (mm)")
    axes.set_ylabel("probability density (1/mm)")
    _mark_paper(axes, R)
    above = axes.secondary_xaxis(
        "top", functions=(partial(np.multiply, 1 / R), partial(np.multiply, R))
    )
    above.set_xlabel("$r/R$")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.9))
    say_n(axes, n, x=0.03)
    modes = ", ".join(
        f"{point} {quantity.value:.2f}"
        for point in KEYPOINTS
        if (quantity := data.quantity(f"r_{_LETTERS[point]}_over_R")).value is not None
    )
    alt = f"Densities of the distance from the centre, {n}. Modes in units of R: {modes or 'none'}."
    return Panel(**base, figure=figure, alt=alt, tables={"": table})


def _mark_paper(axes: Any, radius_mm: float) -> None:
    place = paper_number("r_c_over_R") * radius_mm
    axes.axvline(place, **PAPER_STYLE)
    axes.annotate(
        "paper, $r_c$", (place, 0.8), xycoords=("data", "axes fraction"), xytext=(-3, 0),
        textcoords="offset points", rotation=90, va="top", ha="right", color="#5a5a5a",
        fontsize=6.5,
    )  # fmt: skip
