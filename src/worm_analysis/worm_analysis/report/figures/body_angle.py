"""Fig. 1e: the angle between the body and the wall's normal."""

from typing import Any

import numpy as np

from worm_analysis.accumulators.bins import ANGLE_EDGES
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.numbers import with_interval
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import COLUMN_IN, INK, PAPER_STYLE, new_figure
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.paper import paper_number

_ANGLE_BINS_MERGED = 2
"""Bins of 2° that are drawn as one."""
_PAPER_PEAKS_DEG = [paper_number(f"psi_b_{side}_peak") for side in ("negative", "positive")]
ANGLE_EDGES_DEG = np.degrees(ANGLE_EDGES)
_READING = (
    "ψ<sub>b</sub> is the signed angle from the outward normal at the head to the vector from the "
    "centroid to the head, positive counter-clockwise as seen in the picture, so that "
    "<i>v</i><sub>b</sub> = <i>v</i><sub>w</sub> sin ψ<sub>b</sub>: a worm with "
    "ψ<sub>b</sub> &gt; 0 moves counter-clockwise. Two peaks are the two directions along the "
    "wall. Dashed: the paper's peaks at −34° and +30°. Black marks: this data's peaks with "
    "their 95 % intervals."
)


def angle_density(counts: Floats) -> tuple[Floats, Floats]:
    """Return the normalised density of an angle over (−180°, 180°].

    Parameters
    ----------
    counts : ndarray, shape (180,)
        Frames in bins of 2°.

    Returns
    -------
    edges_deg : ndarray, shape (91,)
        Bins of 4°, symmetric about 0.
    density : ndarray, shape (90,)
        1/degree, of unit area.
    """
    edges: Floats = ANGLE_EDGES_DEG[::_ANGLE_BINS_MERGED]
    merged = counts.reshape(-1, _ANGLE_BINS_MERGED).sum(axis=1)
    density: Floats = merged / (max(float(counts.sum()), 1.0) * np.diff(edges))
    return edges, density


def body_angle_panel(data: ReportData) -> Panel:
    """Return the panel, all chambers and trials together."""
    counts = np.empty(0) if data.pool is None else data.pool.total("psi_b")
    frames = int(counts.sum())
    n = data.counted(frames, "frames")
    base: dict[str, Any] = {
        "key": "fig-1e",
        "title": "Orientation of the body at the wall",
        "paper": "Fig. 1e",
        "reading": _READING,
        "n": n,
    }
    if data.pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if frames < FIGURES.fewest_frames:
        return Panel(**base, why=not_enough(frames, "frames", FIGURES.fewest_frames))
    edges, density = angle_density(counts)
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    axes.stairs(density, edges, color=INK, linewidth=1.1)
    axes.stairs(density, edges, color=INK, fill=True, alpha=0.1)
    top = float(density.max()) * 1.6
    for paper_deg, label in zip(_PAPER_PEAKS_DEG, ("paper, −34° and +30°", None), strict=True):
        axes.plot([paper_deg, paper_deg], [0, 0.72 * top], label=label, **PAPER_STYLE)
    peaks = [data.quantity(f"psi_b_{side}_peak") for side in ("negative", "positive")]
    for peak in peaks:
        _draw_peak(axes, peak, 0.68 * top)
    reach = 180.0 if _exceeds(counts, 120.0) else 120.0
    axes.set_xlim(-reach, reach)
    axes.set_xticks(np.arange(-reach, reach + 1, 60.0 if reach > 120 else 30.0))
    axes.set_ylim(0, top)
    axes.set_xlabel(r"body angle $\psi_b$ (degrees)")
    axes.set_ylabel("probability density (1/degree)")
    axes.legend(loc="upper right", title=n, title_fontsize=7.0, alignment="right")
    found = " and ".join(with_interval(peak) for peak in peaks if peak.value is not None)
    alt = f"Probability density of the body angle, {n}. Peaks: {found or 'none found'} degrees."
    table = {"psi_b_deg": (edges[1:] + edges[:-1]) / 2, "P_psi_b_per_deg": density}
    return Panel(**base, figure=figure, alt=alt, tables={"": table})


def _draw_peak(axes: Any, peak: Quantity, height: float) -> None:
    if peak.value is None:
        return
    sides = None
    if peak.low is not None and peak.high is not None:
        sides = [[peak.value - peak.low], [peak.high - peak.value]]
    axes.errorbar(
        peak.value, height, xerr=sides, fmt="o", color=INK, markersize=2.5, capsize=2.5,
        elinewidth=0.9,
        label="" if axes.get_legend_handles_labels()[1][1:] else "peak, 95 % interval",
    )  # fmt: skip


def _exceeds(counts: Floats, limit_deg: float) -> bool:
    centres = (ANGLE_EDGES_DEG[1:] + ANGLE_EDGES_DEG[:-1]) / 2
    return float(counts[np.abs(centres) > limit_deg].sum()) > 0.005 * float(counts.sum())
