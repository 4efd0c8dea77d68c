"""How far d_c and d_nc hang on the rule by which contact is told."""

from typing import Any

from worm_analysis.report.numbers import with_interval
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.symbols import under_rule
from worm_analysis.report.theme import (
    CENTROID_COLOUR,
    COLUMN_IN,
    GREY,
    HEAD_COLOUR,
    PAPER_STYLE,
    new_figure,
)
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py import Quantity
from worm_msgs_py.paper import paper_number

OWN = "hidden states"
SHOWN = (
    ("d_c", "$d_c$", HEAD_COLOUR, "o", -0.14),
    ("d_nc", "$d_{nc}$", CENTROID_COLOUR, "D", 0.14),
)
_READING = (
    "⟨<i>d</i><sub>c</sub>⟩ (blue) and ⟨<i>d</i><sub>nc</sub>⟩ (red) with their 95 % intervals, as "
    "they would be had contact been told in another way. First row: two hidden states under the "
    "noise of the radius, as everywhere else on this page. Below: one threshold on the radius as "
    "it is seen, the paper’s rule first (contact factor 0.3: within 0.3 <i>d</i><sub>w</sub> of "
    "the wall); a release factor lets contact go at a larger distance than it begins; a shortest "
    "episode joins what is shorter to its neighbours. Dashed: the paper’s values. Where rows lie "
    "apart by more than their intervals, the number is one of the rule as much as of the worm."
)


def sensitivity(data: ReportData) -> Panel:
    """Return the panel: a row a rule."""
    pool = data.pool
    rules = () if pool is None else pool.rules
    found = [
        (rule, [data.quantity(f"{name}_at_{rule}" if rule else name) for name, *_ in SHOWN])
        for rule in ("", *rules)
    ]
    told = [pair for pair in found if any(item.value is not None for item in pair[1])]
    n = data.counted(found[0][1][0].n, "complete contacts")
    base: dict[str, Any] = {
        "key": "fig-sensitivity", "title": "What the rule of contact does to the distances",
        "paper": "", "label": "Sensitivity", "reading": _READING, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if len(told) < 2:
        whys = [item.why for _, pair in found[1:] for item in pair if item.why]
        return Panel(**base, why=whys[0] if whys else "no other rule was tried")
    figure = new_figure(COLUMN_IN, 0.85 + 0.19 * len(found))
    axes = figure.add_subplot()
    for place, (_, pair) in enumerate(found):
        _draw_pair(axes, place, pair)
    for name, _, colour, *_ in SHOWN:
        axes.axvline(paper_number(name), zorder=0, **PAPER_STYLE | {"color": colour, "alpha": 0.5})
    labels = [OWN if not rule else under_rule(f"d_c_at_{rule}")[1] for rule, _ in found]
    axes.set_yticks(range(len(found)), labels)
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(found) - 0.5, -0.5)
    axes.set_xlim(left=0)
    axes.set_xlabel("mean distance along the wall (mm)")
    handles = [
        axes.errorbar([], [], xerr=[], fmt=marker, color=colour, markersize=3.5, label=label)
        for _, label, colour, marker, _ in SHOWN
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=2, title=n, title_fontsize=7.0)
    words = "; ".join(
        f"{label}: {', '.join(with_interval(item) for item in pair)} mm"
        for label, (_, pair) in zip(labels, found, strict=True)
    )
    return Panel(**base, figure=figure, alt=f"Mean distances in and out of contact: {words}.",
                 tables={"": _sensitivity_table(labels, found)})  # fmt: skip


def _draw_pair(axes: Any, place: int, pair: list[Quantity]) -> None:
    for (_, _, colour, marker, shift), item in zip(SHOWN, pair, strict=True):
        if item.value is None:
            continue
        sides = None
        if item.low is not None and item.high is not None:
            sides = [[item.value - item.low], [item.high - item.value]]
        axes.errorbar(
            item.value, place + shift, xerr=sides, fmt=marker, color=colour, markersize=3.0,
            elinewidth=0.9,
        )  # fmt: skip
    if all(item.value is None for item in pair):
        why = pair[0].why.partition(":")[0]
        axes.text(0.02, place, why, color=GREY, fontsize=6.0, va="center",
                  transform=axes.get_yaxis_transform())  # fmt: skip


def _sensitivity_table(
    labels: list[str], found: list[tuple[str, list[Quantity]]]
) -> dict[str, Any]:
    table: dict[str, Any] = {"rule": labels}
    for column, (name, *_) in enumerate(SHOWN):
        for end in ("value", "low", "high"):
            table[f"{name}_{end}_mm"] = [getattr(pair[column], end) for _, pair in found]
    return table
