"""Fig. 3: how far the head goes along the wall in contact, out of contact, and away from it."""

from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import numpy as np
from scipy.special import chdtri

from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.numbers import interval, plain, value
from worm_analysis.report.panel import Panel, counted, number_of, thousands
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.symbols import spoken
from worm_analysis.report.theme import COLOURS, GREY, INK, PAGE_IN, PAPER_STYLE, new_figure
from worm_analysis.report.verdicts import not_exponential
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats

BINS_PER_MEAN = 2.0
LONGEST_IN_MEANS = 6.0
FIT = COLOURS["head"]
LABELS = {"a": "distance in contact", "b": "distance out of contact", "c": "excursion"}
_READING = (
    "<i>d</i><sub>c</sub> and <i>d</i><sub>nc</sub>: arc length <i>R</i>|Δθ<sub>h</sub>| that the "
    "head travels during one contact with the wall and during one excursion from it; "
    "Δ<i>r</i><sub>h</sub>: the largest <i>R</i> − <i>r</i><sub>h</sub> of an excursion. Only "
    "episodes whose start and end were seen are counted. Points: density per millimetre with its "
    "95 % Poisson interval, on a logarithmic scale, where an exponential law is a straight line. "
    "Blue: the maximum-likelihood exponential (mean and 95 % interval as written); it rests on the "
    "filled points alone: episodes below the resolution limit (open points) and the time "
    "resolution are accounted for. Dashed: the paper's exponential. All are normalised to unit "
    "area above the resolution limit."
)


@dataclass(frozen=True, slots=True, eq=False)
class LengthDensity:
    """A histogram of episode lengths, normalised above the resolution limit.

    Attributes
    ----------
    edges_mm : ndarray, shape (k + 1,)
        Bins; the resolution limit is one of the edges.
    density, low, high : ndarray, shape (k,)
        1/mm, with its 95 % Poisson interval; unit area above the limit.
    limit_mm : float
        The resolution limit: shorter episodes are not in the fit.
    n_above, n : int
        Episodes above it, and all.
    """

    edges_mm: Floats
    density: Floats
    low: Floats
    high: Floats
    limit_mm: float
    n_above: int
    n: int


def length_density(lengths_mm: Floats, mean_mm: float, n_fitted: int) -> LengthDensity:
    """Return the density of episode lengths in bins of half a mean.

    Parameters
    ----------
    lengths_mm : ndarray
        Lengths of the complete episodes.
    mean_mm : float
        Mean of the exponential law; sets the bins.
    n_fitted : int
        How many of the longest episodes the fit rests on; the shortest of them is the limit.
    """
    ordered = np.sort(lengths_mm[np.isfinite(lengths_mm)])[::-1]
    n_fitted = min(n_fitted, len(ordered))
    limit = float(ordered[n_fitted - 1]) if n_fitted < len(ordered) else 0.0
    width = mean_mm / BINS_PER_MEAN
    below = limit - width * np.arange(int(np.ceil(limit / width)), 0, -1)
    above = limit + width * np.arange(int(LONGEST_IN_MEANS * BINS_PER_MEAN) + 1)
    edges = np.concatenate([np.maximum(below, 0.0), above])
    counts, _ = np.histogram(ordered, edges)
    unit = n_fitted * np.diff(edges)
    low = np.where(counts > 0, chdtri(2 * np.maximum(counts, 1), 0.975) / 2, 0.0)
    high = chdtri(2 * counts + 2, 0.025) / 2
    return LengthDensity(
        edges, counts / unit, low / unit, high / unit, limit, n_fitted, len(ordered)
    )


def exponential_above(x_mm: Floats, mean_mm: float, limit_mm: float) -> Floats:
    """Return the exponential law's density, normalised to unit area above the limit."""
    density: Floats = np.exp(-(x_mm - limit_mm) / mean_mm) / mean_mm
    return density


def wall_distances(data: ReportData) -> Panel:
    """Return the panel: d_c, d_nc and Δr_h, all chambers and trials together."""
    pool = data.pool
    parts = [
        (name, symbol, np.empty(0) if pool is None else pool.points(name))
        for name, symbol in (("d_c", "$d_c$"), ("d_nc", "$d_{nc}$"), ("delta_r_h", r"$\Delta r_h$"))
    ]
    n = data.counted(len(parts[0][2]), "complete contacts")
    n += f", {number_of(len(parts[1][2]), 'complete excursions')}"
    base: dict[str, Any] = {
        "key": "fig-3",
        "title": "Distances travelled in contact, out of contact, and away from the wall",
        "paper": "Fig. 3",
        "reading": _READING,
        "n": n,
    }
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    found = [(data.quantity(name), symbol, lengths) for name, symbol, lengths in parts]
    if not any(_drawable(quantity, lengths) for quantity, _, lengths in found):
        return Panel(**base, why=_why(*found[0][::2]))
    figure = new_figure(PAGE_IN, 2.5)
    tables = {}
    for axes, letter, part, (name, _, _) in zip(
        figure.subplots(1, 3), "abc", found, parts, strict=True
    ):
        drawn = _draw_law(axes, letter, *part)
        if drawn is not None:
            tables[name] = as_table(drawn, f"{name}_mm")
    means = ", ".join(f"{spoken(name)} {value(data.quantity(name))} mm" for name, _, _ in parts)
    alt = f"Densities of episode lengths, {n}. Means: {means}."
    tested = [(data.quantity(name), data.quantity(f"{name}_exponential_p")) for name, *_ in parts]
    wrong = tuple(filter(None, [not_exponential(*pair) for pair in tested]))
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def _drawable(quantity: Quantity, lengths_mm: Floats) -> bool:
    return (
        quantity.value is not None
        and quantity.value > 0
        and len(lengths_mm) >= FIGURES.fewest_items
    )


def _why(quantity: Quantity, lengths_mm: Floats) -> str:
    if quantity.value is None:
        return quantity.why or "the summary has no value"
    return (
        f"not enough data: {len(lengths_mm)} complete episodes, {FIGURES.fewest_items} are needed"
    )


def as_table(found: LengthDensity, name: str) -> dict[str, Any]:
    """Return what is drawn of a density, as columns."""
    edges = found.edges_mm
    return {
        f"{name}_from": edges[:-1],
        f"{name}_to": edges[1:],
        "density": found.density,
        "low": found.low,
        "high": found.high,
        "fitted": edges[:-1] >= found.limit_mm,
    }


def _draw_law(
    axes: Any, letter: str, quantity: Quantity, symbol: str, lengths_mm: Floats
) -> LengthDensity | None:
    axes.set_title(f"({letter})", loc="left", pad=3)
    axes.set_xlabel(f"{LABELS[letter]} {symbol} (mm)")
    if not _drawable(quantity, lengths_mm) or quantity.value is None:
        axes.text(
            0.5, 0.5, "\n".join(wrap(_why(quantity, lengths_mm), 30)), transform=axes.transAxes,
            ha="center", va="center", color=GREY,
        )  # fmt: skip
        axes.set_xticks([])
        axes.set_yticks([])
        return None
    mean = quantity.value
    found = length_density(lengths_mm, mean, quantity.n)
    draw_points(axes, found)
    x = np.array([found.limit_mm, found.edges_mm[-1]])
    fit_label = f"fit, mean {value(quantity)} mm\n[{interval(quantity)}]"
    axes.plot(x, exponential_above(x, mean, found.limit_mm), color=FIT, label=fit_label)
    if quantity.paper:
        paper = exponential_above(x, quantity.paper, found.limit_mm)
        axes.plot(x, paper, label=f"paper, {plain(quantity.paper)} mm", **PAPER_STYLE)
    axes.set_yscale("log")
    seen = found.density[found.density > 0]
    axes.set_ylim(float(seen.min()) / 4, float(max(seen.max(), 1 / mean)) * 12)
    axes.set_xlim(-0.02 * found.edges_mm[-1], found.edges_mm[-1])
    axes.set_ylabel("probability density (1/mm)")
    axes.legend(loc="upper right", title=_n(found), title_fontsize=7.0, alignment="right")
    return found


def draw_points(axes: Any, found: LengthDensity) -> None:
    """Draw a density with its intervals; open points are below the resolution limit."""
    centres = (found.edges_mm[1:] + found.edges_mm[:-1]) / 2
    seen = found.density > 0
    fitted = found.edges_mm[:-1] >= found.limit_mm
    for chosen, face in ((seen & fitted, INK), (seen & ~fitted, "white")):
        axes.errorbar(
            centres[chosen],
            found.density[chosen],
            yerr=[
                (found.density - found.low)[chosen],
                (found.high - found.density)[chosen],
            ],
            fmt="o",
            color=INK,
            markerfacecolor=face,
            markersize=3,
            markeredgewidth=0.7,
            elinewidth=0.7,
        )


def _n(found: LengthDensity) -> str:
    if found.n_above == found.n:
        return counted(found.n, "episodes")
    return f"n\u00a0=\u00a0{thousands(found.n_above)} of {thousands(found.n)} episodes"
