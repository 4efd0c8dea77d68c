"""Fig. 7a: how long the worm keeps its direction along the wall."""

from textwrap import fill
from typing import Any

import numpy as np

from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    CENTROID_COLOUR,
    COLUMN_IN,
    HEAD_COLOUR,
    INK,
    MODEL_COLOUR,
    PAPER_STYLE,
    new_figure,
    say_n,
)
from worm_analysis.report.verdicts import not_one_exponential
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.summary.direction_persistence import ONE_E
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import NORMAL_95
from worm_msgs_py.paper import paper_number

WIDE = 44
"""Letters in a line of a panel."""
_READING = (
    "<i>C</i><sub>θ</sub>(<i>t</i>) = ⟨sgn θ̇<sub>h</sub>(<i>t</i> + <i>t</i><sub>0</sub>) · sgn "
    "θ̇<sub>h</sub>(<i>t</i><sub>0</sub>)⟩ over all <i>t</i><sub>0</sub> in one unbroken visit; 1: "
    "always the same direction, 0: no memory of it. Band: 95 % interval, from blocks of time, or "
    "from whole trials; there is none where fewer than five of them hold the pairs. Blue: "
    "exp(−<i>t</i>/<i>t</i><sub>per</sub>) fitted to the measurement. Red: where the measurement "
    "itself has fallen to 1/e, with its 95 % interval; for a single exponential that is "
    "<i>t</i><sub>per</sub>. Purple: the boundary walk with the parameters of this data. Dashed: "
    "the paper's decay time of about 27 s. n counts the moments at which the direction is known; "
    "they are not independent. Lags with fewer than a quarter as many pairs are not shown."
)


def persistence_panel(data: ReportData) -> Panel:
    """Return the panel: C_θ(t) with its error, the fit, the model's and the paper's decay."""
    correlation = data.correlation
    t_per, fall = data.quantity("t_per"), data.quantity("t_1e")
    pairs = 0 if correlation is None or not len(correlation.pairs) else int(correlation.pairs[0])
    step_s = correlation.lag_s[1] if correlation is not None and len(correlation.lag_s) > 1 else 0
    n = data.counted(pairs, f"moments, {step_s:g} s apart" if pairs else "moments with a direction")
    base: dict[str, Any] = {
        "key": "fig-7a",
        "title": "Persistence of the direction along the wall",
        "paper": "Fig. 7a",
        "reading": _READING,
        "n": n,
    }
    if data.pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if correlation is None:
        return Panel(**base, why="the summary has no correlation function")
    enough = max(FIGURES.fewest_pairs, pairs * FIGURES.smallest_part_of_pairs)
    known = np.isfinite(correlation.c) & (correlation.pairs >= enough)
    if np.count_nonzero(known) < 3:
        return Panel(**base, why=t_per.why or f"not enough data: {pairs} moments")
    figure = new_figure(COLUMN_IN, 3.0)
    axes = figure.add_subplot()
    lag, c = correlation.lag_s[known], correlation.c[known]
    error = NORMAL_95 * correlation.error[known]
    axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.fill_between(lag, c - error, c + error, color=INK, alpha=0.18, linewidth=0)
    axes.plot(lag, c, color=INK, label="measured")
    if t_per.value is not None:
        label = rf"fit, $t_{{per}}$ = {with_interval(t_per)} s"
        axes.plot(lag, correlation.model[known], color=HEAD_COLOUR, label=label)
    _draw_fall(axes, fall)
    table = {"lag_s": lag, "C_theta": c, "low": c - error, "high": c + error}
    tables = {"": table | {"pairs": correlation.pairs[known]}} | _draw_walks(axes, data, lag[-1])
    paper = paper_number("t_per")
    axes.plot(lag, np.exp(-lag / paper), label=f"paper, {plain(paper)} s", **PAPER_STYLE)
    axes.set_xlim(0, lag[-1])
    low = min(0.0, float(np.min(c - np.nan_to_num(error))))
    axes.set_ylim(max(-1.05, low - 0.1), 1.08)
    axes.set_xlabel("time $t$ (s)")
    axes.set_ylabel(r"correlation of direction $C_\theta(t)$")
    figure.legend(loc="outside upper center", ncols=2, title=n, title_fontsize=7.0)
    if t_per.value is None:
        say_n(axes, "no fit:\n" + fill(t_per.why, WIDE), x=0.03, y=0.03)
    times = f"fitted decay time {with_interval(t_per)} s, 1/e at {with_interval(fall)} s"
    alt = f"Correlation of the direction with itself, {n}; {times}."
    wrong = tuple(filter(None, [not_one_exponential(data.quantity)]))
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def _draw_walks(axes: Any, data: ReportData, longest_s: float) -> dict[str, Any]:
    """Draw C_θ of the walks with the parameters of this data; return what is drawn."""
    tables = {}
    for lag_s, walk_c in _walks(data):
        shown = lag_s <= longest_s
        axes.plot(lag_s[shown], walk_c[shown], color=MODEL_COLOUR, label="boundary walk")
        tables["walk"] = {"lag_s": lag_s[shown], "C_theta": walk_c[shown]}
    return tables


def _draw_fall(axes: Any, fall: Quantity) -> None:
    """Mark where the curve has fallen to 1/e."""
    if fall.value is None:
        return
    sides = None
    if fall.low is not None and fall.high is not None:
        sides = [[fall.value - fall.low], [fall.high - fall.value]]
    axes.errorbar(
        fall.value, ONE_E, xerr=sides, fmt="o", color=CENTROID_COLOUR, markersize=3.5, capsize=2.5,
        elinewidth=1.0, zorder=4, label=rf"1/e, $t_{{1/e}}$ = {with_interval(fall)} s",
    )  # fmt: skip


def _walks(data: ReportData) -> list[tuple[Floats, Floats]]:
    """Return lags and C_θ of the walk with the parameters of this data."""
    single = data.walk_correlation
    found = [] if single is None else [(single.lag_s, single.c)]
    return found + [(walk.lag_s, walk.c) for walk in data.walks if walk.is_own]
