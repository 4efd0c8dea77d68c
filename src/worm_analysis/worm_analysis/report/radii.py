"""Fig. 1d: how far head, centroid and tail are from the chamber's centre."""

from functools import partial

import numpy as np

from worm_analysis.report.panel import NO_CHAMBER, Panel, counted
from worm_analysis.report.tables import POINTS, Floats, Results
from worm_analysis.report.theme import (
    COLOURS,
    COLUMN_IN,
    PAPER_STYLE,
    new_figure,
    say_n,
)

BINS_PER_R = 50
BINS = 55
FEWEST = 100
PAPER_RC_OVER_R = 0.6
SYMBOLS = {"head": "h", "centroid": "c", "tail": "t"}
READING = (
    "<i>P</i>(<i>r</i>) d<i>r</i> is the fraction of frames in which head tip "
    "(<i>r</i><sub>h</sub>), centroid (<i>r</i><sub>c</sub>) or tail tip (<i>r</i><sub>t</sub>) "
    "is at a distance between <i>r</i> and <i>r</i> + d<i>r</i> from the centre of its chamber; "
    "each curve has unit area and is not divided by the circumference 2π<i>r</i>, so a point "
    "that is anywhere with equal probability would give a straight line through the origin "
    "(dotted). Frames in the passage are left out. Dashed: the paper's "
    "<i>r</i><sub>c</sub>/<i>R</i> ≈ 0.6."
)


def radial_density(r_mm: Floats, radius_mm: float) -> tuple[Floats, Floats]:
    """Return the normalised density of distances from the centre.

    Parameters
    ----------
    r_mm : ndarray
        Distances; NaN is left out.
    radius_mm : float
        R: bins are R/50 wide and reach to 1.1 R.

    Returns
    -------
    edges_mm : ndarray, shape (56,)
        Edges of the bins.
    density : ndarray, shape (55,)
        1/mm, of unit area where no distance is beyond the last edge.
    """
    edges: Floats = np.linspace(0.0, BINS / BINS_PER_R * radius_mm, BINS + 1)
    known = r_mm[np.isfinite(r_mm)]
    counts, _ = np.histogram(known, edges)
    density: Floats = counts / (max(len(known), 1) * np.diff(edges))
    return edges, density


def radii(results: Results) -> Panel:
    """Return the panel, all chambers together."""
    tracks, R = results.tracks, results.radius_mm
    inside = np.isin(tracks["where"], [chamber.name for chamber in results.chambers])
    inside &= np.isfinite(tracks["r_h_mm"])
    frames = int(inside.sum())
    n = counted(frames, "frames")
    base = {
        "key": "fig-1d",
        "title": "Distance from the chamber's centre",
        "paper": "Fig. 1d",
        "reading": READING,
        "n": n,
    }
    if not results.chambers:
        return Panel(**base, why=NO_CHAMBER)
    if frames < FEWEST:
        return Panel(**base, why=f"not enough data: {frames} frames, {FEWEST} are needed")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    axes.plot([0, R], [0, 2 / R], ":", color="#9a9a9a", linewidth=0.9)
    axes.axvline(PAPER_RC_OVER_R * R, **PAPER_STYLE)
    for point in POINTS:
        symbol = SYMBOLS[point]
        edges, density = radial_density(tracks[f"r_{symbol}_mm"][inside], R)
        axes.stairs(
            density, edges, color=COLOURS[point], linewidth=1.1, label=f"$r_{symbol}$, {point}"
        )
        axes.stairs(density, edges, color=COLOURS[point], fill=True, alpha=0.12)
    axes.axvline(R, color="#1a1a1a", linewidth=0.8)
    axes.set_xlim(0, 1.1 * R)
    axes.set_ylim(0, axes.get_ylim()[1] * 1.12)
    axes.set_xlabel("$r$ (mm)")
    axes.set_ylabel("$P(r)$ (mm$^{-1}$)")
    axes.annotate(
        "paper, $r_c$",
        (PAPER_RC_OVER_R * R, 0.97),
        xycoords=("data", "axes fraction"),
        xytext=(-3, 0),
        textcoords="offset points",
        rotation=90,
        va="top",
        ha="right",
        color="#5a5a5a",
        fontsize=6.5,
    )
    above = axes.secondary_xaxis(
        "top", functions=(partial(np.multiply, 1 / R), partial(np.multiply, R))
    )
    above.set_xlabel("$r/R$")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.9))
    say_n(axes, n, x=0.03)
    modes = ", ".join(
        f"{point} {quantity.value:.2f}"
        for point in POINTS
        if (quantity := results.quantity(f"r_{SYMBOLS[point]}_over_R")).value is not None
    )
    alt = f"Densities of the distance from the centre, {n}. Modes in units of R: {modes or 'none'}."
    return Panel(**base, figure=figure, alt=alt)
