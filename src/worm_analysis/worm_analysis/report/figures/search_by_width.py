"""Fig. 6: mean time to find the exit, and skips over it, against the exit's width."""

from typing import Any

import numpy as np

from worm_analysis.pooling import Pooled, WalkPrediction
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    COLUMN_IN,
    INK,
    MODEL_COLOUR,
    SHADE,
    WALK_OF_PAPER,
    new_figure,
)
from worm_analysis.summary.definition import NO_CHAMBER

_READING = (
    " Points: all trials of one width together, with 95 % intervals; n above each is the number "
    "of trials. Purple: the boundary walk with this data’s ⟨<i>d</i><sub>c</sub>⟩, "
    "⟨<i>d</i><sub>nc</sub>⟩, ⟨|<i>v</i><sub>b</sub>|⟩ and reversals, with the exit’s arc "
    "<i>w</i><sub>s</sub> = √(<i>W</i>² + <i>h</i>²). Dotted: the walk with the paper’s parameters "
    "(caption of its Fig. 6), 45 % reversals per slide and hop; grey: 35 to 55 %. The paper "
    "gives its own points in the figure alone."
)


def search_time_by_width(data: ReportData) -> Panel:
    """Return Fig. 6a."""
    base: dict[str, Any] = {
        "key": "fig-6a", "title": "Mean time to find the exit against its width",
        "paper": "Fig. 6a", "reading": "⟨τ<sub>h</sub>⟩ of each width <i>W</i>." + _READING,
    }  # fmt: skip
    found = 0 if data.pool is None else len(data.pool.points("tau_h"))
    n = data.counted(found, "findings of the exit")
    return _width_panel(
        data, "tau_h", base, n, r"mean time to find the exit $\langle\tau_h\rangle$ (s)"
    )


def skips_by_width(data: ReportData) -> Panel:
    """Return Fig. 6b."""
    base: dict[str, Any] = {
        "key": "fig-6b", "title": "Skips over the exit against its width", "paper": "Fig. 6b",
        "reading": "<i>n</i><sub>s</sub>: times in 30 min in a chamber that the head passes the "
        "exit’s arc out of contact and does not enter." + _READING,
    }  # fmt: skip
    skips = 0 if data.pool is None else data.pool.count("n_s", 1)
    n = data.counted(skips, "skips")
    return _width_panel(data, "n_s", base, n, "skips $n_s$ (per 30 min)")


def _width_panel(data: ReportData, name: str, base: dict[str, Any], n: str, label: str) -> Panel:
    base |= {"n": n}
    if data.pool is None:
        return Panel(**base, why=NO_CHAMBER)
    rows = [(part.width_mm, numbers[name]) for part, numbers in data.by_width]
    known = [(width, pooled) for width, pooled in rows if pooled.quantity.value is not None]
    if not known:
        whys = {pooled.quantity.why for _, pooled in rows}
        return Panel(**base, why="; ".join(sorted(whys)) or "the exit’s width is not known")
    figure = new_figure(COLUMN_IN, 2.8)
    axes = figure.add_subplot()
    tables: dict[str, Any] = {}
    for walk in data.walks:
        tables["walk" if walk.is_own else "walk-of-the-paper"] = _draw_predicted_mean(
            axes, walk, name
        )
    tables[""] = draw_by_width(axes, known)
    width = np.array([width for width, _ in rows])
    axes.set_xlim(0, max(5.4, 1.08 * float(width.max())))
    top = max(axes.get_ylim()[1], 1.25 * max(_high(pooled) for _, pooled in known))
    axes.set_ylim(0, top)
    axes.set_xlabel("width of the exit $W$ (mm)")
    axes.set_ylabel(label)
    figure.legend(loc="outside upper center", ncols=3, title=n, title_fontsize=7.0)
    told = ", ".join(f"{w:g} mm: {p.quantity.value:.3g}" for w, p in known)
    return Panel(**base, figure=figure, alt=f"{base['title']}, {n}. {told}.", tables=tables)


def draw_by_width(axes: Any, known: list[tuple[float, Pooled]]) -> dict[str, Any]:
    """Draw one number against W with its intervals and trials; return what was drawn."""
    width = np.array([width for width, _ in known])
    value, low, high = (
        np.array([np.nan if end is None else end for end in ends], dtype=float)
        for ends in zip(
            *((p.quantity.value, p.quantity.low, p.quantity.high) for _, p in known), strict=True
        )
    )
    sides = [np.nan_to_num(value - low), np.nan_to_num(high - value)]
    axes.errorbar(
        width, value, yerr=sides, fmt="o", color=INK, markersize=4, elinewidth=0.9, capsize=2,
        label="measured", zorder=3,
    )  # fmt: skip
    for (place, pooled), end in zip(known, np.fmax(value, high), strict=True):
        axes.annotate(
            f"{pooled.trials}", (place, end), xytext=(0, 3), textcoords="offset points",
            ha="center", fontsize=6.5,
        )  # fmt: skip
    return {
        "W_mm": width, "value": value, "low": low, "high": high,
        "n": [p.quantity.n for _, p in known], "trials": [p.trials for _, p in known],
        "interval_by": [p.by for _, p in known],
    }  # fmt: skip


def _high(pooled: Pooled) -> float:
    quantity = pooled.quantity
    assert quantity.value is not None
    return quantity.value if quantity.high is None else quantity.high


def _draw_predicted_mean(axes: Any, walk: WalkPrediction, name: str) -> dict[str, Any]:
    value, low, high = (
        (walk.tau_h_s, walk.tau_low_s, walk.tau_high_s)
        if name == "tau_h"
        else (walk.n_s, walk.n_s_low, walk.n_s_high)
    )
    if np.isfinite(low).all():
        axes.fill_between(walk.width_mm, low, high, color=SHADE, linewidth=0, zorder=0)
    style = {"color": MODEL_COLOUR} if walk.is_own else WALK_OF_PAPER
    label = "boundary walk" if walk.is_own else "walk, the paper’s"
    axes.plot(walk.width_mm, value, label=label, **style)
    return {"W_mm": walk.width_mm, "value": value, "low": low, "high": high}
