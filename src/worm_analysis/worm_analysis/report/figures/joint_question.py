"""The joint question: which observations one boundary walk can hold together."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite, nan
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from worm_analysis.report.numbers import plain
from worm_analysis.report.panel import Panel, counted
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.symbols import html_symbol, plain_symbol, spoken
from worm_analysis.report.theme import CENTROID_COLOUR, HEAD_COLOUR, INK, PAGE_IN, SHADE, new_figure
from worm_analysis.results import Results
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py import Comparison, NeededReversal
from worm_msgs_py.contract.agreement import Agreement, agreements

OF_PAPER = {
    "reversal": "reversals, text: 30 %",
    "reversal_fig_6": "reversals, Fig. 6: 45 %",
    "t_per": "$t_{per}$ = 27 s",
    "tau_h_text": r"$\langle \tau_h \rangle$ > 40 s",
    "tau_h": r"$\langle \tau_h \rangle$, Fig. 6a",
    "n_s": "$n_s$, Fig. 6b",
    "escape_ratio": r"$\tau_{escape}$, 1.7 to 2 $\langle \tau_h \rangle$",
}
RULE_LABELS = {"per_cycle": "per slide + hop", "per_phase": "per phase", "rate": "per second"}
SPEED_LABELS = {"v_w": "$v_w$", "v_b": r"$\langle |v_b| \rangle$"}
TOLD = "per_cycle"
"""The rule whose answers are told in words: reversals as the paper counts them."""
LEAST_DRAWN_REVERSAL = 1e-3
"""An interval that reaches down to no reversal at all is drawn to here."""
_READING = (
    "Each row is one observation: the dot is the reversal that the exact boundary walk needs to "
    "give its value, the bar those that give its 95 % interval; all else is as measured. One "
    "column for each thing that a reversal may count, one row of panels for each speed that the "
    "walk may have. Grey band: the reversals that hold the largest set of observations together, "
    "in blue; an orange row cannot be had with these. “none”: no reversal gives it. A bar that "
    "ends at an edge goes on beyond it."
)


def joint_question(results: Results) -> Panel:
    """Return the panel of a trial."""
    panel = _joint_panel(results.comparison)
    return panel if results.chambers else replace(panel, figure=None, why=NO_CHAMBER)


def joint_questions(data: ReportData) -> list[Panel]:
    """Return a panel for each W of a pool."""
    return [
        _joint_panel(data.comparisons.get(part.width_mm), part.width_mm)
        for part, _ in data.by_width
    ]


def answers_in_words(data: ReportData) -> list[str]:
    """Return, for each W of a pool, what one walk can hold together of it; HTML."""
    lines = []
    for width_mm, comparison in data.comparisons.items():
        told = [found for found in agreements(comparison.needs) if found.rule == TOLD]
        if told:
            answers = "; ".join(agreement_in_words(found, html_symbol) for found in told)
            lines.append(f"One boundary walk and <i>W</i> = {plain(width_mm)} mm: {answers}.")
    return lines


def _joint_panel(comparison: Comparison | None, width_mm: float = nan) -> Panel:
    needs = () if comparison is None else comparison.needs
    observations = list(dict.fromkeys(need.observation for need in needs))
    of_width = f", W = {plain(width_mm)} mm" if isfinite(width_mm) else ""
    base: dict[str, Any] = {
        "key": f"fig-joint-W{width_mm:g}".replace(".", "-") if of_width else "fig-joint",
        "title": f"What one boundary walk can hold together{of_width}",
        "paper": "",
        "label": f"Joint question{of_width}",
        "reading": _READING,
        "n": counted(len(observations), "observations"),
    }
    if len(observations) < 2:
        return Panel(**base, why="fewer than two observations to hold together")
    alt = "; ".join(agreement_in_words(agreement, spoken) for agreement in agreements(needs))
    columns = ("rule", "speed", "observation", "value", "low", "high")
    table = {name: [getattr(need, name) for need in needs] for name in columns}
    return Panel(**base, figure=joint_figure(needs), alt=f"{alt}.", tables={"": table})


def agreement_in_words(agreement: Agreement, symbol: Callable[[str], str]) -> str:
    """Return the answer for one rule and speed, with symbols for names."""
    held, left = (tuple(map(symbol, names)) for names in (agreement.held, agreement.left))
    return replace(agreement, held=held, left=left, speed=symbol(agreement.speed)).in_words()


def joint_figure(needs: Sequence[NeededReversal]) -> Any:
    """Return the figure for needed reversals, of a trial or of the paper; made within `style`."""
    found = {(item.rule, item.speed): item for item in agreements(needs)}
    speeds = [speed for speed in SPEED_LABELS if any(key[1] == speed for key in found)]
    names = list(dict.fromkeys(need.observation for need in needs))
    of_paper = not any(need.is_measured for need in needs)
    height = 1.2 + len(speeds) * (0.35 + 0.2 * len(names))
    figure = new_figure(PAGE_IN, height)
    grid = figure.subplots(len(speeds), len(RULE_LABELS), sharex="col", sharey=True, squeeze=False)
    for row, speed in enumerate(speeds):
        for column, rule in enumerate(RULE_LABELS):
            axes = grid[row][column]
            case = found.get((rule, speed))
            own = {n.observation: n for n in needs if (n.rule, n.speed) == (rule, speed)}
            _draw_needs(axes, names, own, case)
            axes.set_title(f"{RULE_LABELS[rule]}, at {SPEED_LABELS[speed]}")
            if row == len(speeds) - 1:
                axes.set_xlabel("reversals (1/s)" if rule == "rate" else "chance of reversal")
        labels = [OF_PAPER[name] if of_paper else plain_symbol(name) for name in names]
        grid[row][0].set_yticks(range(len(names)), labels)
        grid[row][0].set_ylim(len(names) - 0.5, -0.5)
    lines = [
        Line2D([], [], color=colour, linewidth=2.0) for colour in (HEAD_COLOUR, CENTROID_COLOUR)
    ]
    told = ["one reversal gives these together", "and not these"]
    n = counted(len(names), "observations")
    figure.legend(lines, told, loc="outside upper center", ncols=2, title=n, title_fontsize=7.0)
    return figure


def _draw_needs(
    axes: Any, names: list[str], needs: dict[str, NeededReversal], case: Agreement | None
) -> None:
    axes.set_xscale("log")
    top = 5.0 if any(need.rule == "rate" for need in needs.values()) else 1.0
    axes.set_xlim(LEAST_DRAWN_REVERSAL, top)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    if case is not None and len(case.held) > 1:
        low, high = np.clip((case.low, case.high), LEAST_DRAWN_REVERSAL, top)
        axes.axvspan(low / 1.02, high * 1.02, color=SHADE, linewidth=0)
    for place, name in enumerate(names):
        need = needs.get(name)
        if need is None:
            axes.text(
                LEAST_DRAWN_REVERSAL * 1.2,
                place,
                "not measured",
                va="center",
                color=INK,
                fontsize=6.5,
            )
            continue
        colour = HEAD_COLOUR if case is not None and name in case.held else CENTROID_COLOUR
        if not isfinite(need.low):
            axes.text(
                LEAST_DRAWN_REVERSAL * 1.2, place, "none", va="center", color=colour, fontsize=6.5
            )
            continue
        ends = np.clip((need.low, need.high), LEAST_DRAWN_REVERSAL, top)
        axes.plot(ends, [place, place], color=colour, linewidth=2.0, solid_capstyle="butt")
        if isfinite(need.value):
            axes.plot(need.value, place, "o", color=colour, markersize=3.5)
