"""The boundary walk beside the measurement: which numbers it can hold together, and which not."""

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from markupsafe import Markup, escape
from matplotlib.ticker import FuncFormatter, NullFormatter

from worm_analysis.report.numbers import plain, value
from worm_analysis.report.panel import Panel, counted
from worm_analysis.report.symbols import plain_symbol, spoken
from worm_analysis.report.theme import COLUMN_IN, INK, MODEL_COLOUR, PAPER_STYLE, new_figure
from worm_analysis.results import Results
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py import ModelQuantity, Quantity

SUFFIX_UNITS = {"_m_s": ("mm/s", 1e3), "_m": ("mm", 1e3), "_per_s": ("1/s", 1.0), "_s": ("s", 1.0)}
CHOICES = ("hop_may_land", "effective_width")
IS_MEASURED = "_is_measured"
AGREES, DISAGREES, GIVEN = "agrees", "does not agree", "given to the walk"
MILLI = {"m": "mm", "m/s": "mm/s"}
_READING = (
    "Each row is one quantity, in units of its measured value: black, the measurement with its "
    "95 % interval; purple, the boundary walk (slides and hops along the wall, reversing at "
    "random) with the 95 % interval of its mean; cross, the paper's value. Where the two intervals "
    "do not overlap, the walk with these parameters does not describe the trial in that respect. "
    "A quantity that is 0 is in the table alone."
)


@dataclass(frozen=True, slots=True)
class ComparisonRow:
    """One quantity, measured and modelled, in the units of people.

    Attributes
    ----------
    measured, modelled : Quantity
        Value and 95 % interval; the measured one with n and the paper's value.
    verdict : str
        Whether the two intervals overlap, or why that cannot be said.
    """

    measured: Quantity
    modelled: Quantity
    verdict: str


def comparison_rows(results: Results) -> list[ComparisonRow]:
    """Return what the model node compared, in its order."""
    if results.comparison is None:
        return []
    given, _ = origins(results)
    rows = [_comparison_row(results, quantity) for quantity in results.comparison.quantities]
    return [replace(row, verdict=GIVEN) if row.measured.name in given else row for row in rows]


def verdict_in_words(rows: list[ComparisonRow]) -> list[tuple[str, list[str]]]:
    """Return the names of the quantities that agree, and of those that do not."""
    return [
        (verdict, [row.measured.name for row in rows if row.verdict == verdict])
        for verdict in (AGREES, DISAGREES)
    ]


def parameters_written(results: Results) -> list[Markup]:
    """Return each parameter of the walk in words; metres as millimetres.

    A parameter named ``NAME_is_measured`` says whether NAME is the trial's own; one that is 0 or 1
    and names a rule or a choice is written as such.
    """
    if results.comparison is None:
        return []
    return [
        Markup("{} = {}").format(_words(name), _with_unit(name, number))
        for name, number in results.comparison.parameters
        if not name.endswith(IS_MEASURED) and not (name.startswith("rule_") and number == 0)
    ]


def origins(results: Results) -> tuple[list[str], list[str]]:
    """Return the walk's parameters that this trial gave, and those taken from the paper."""
    given = {} if results.comparison is None else dict(results.comparison.parameters)
    flags = {
        name.removesuffix(IS_MEASURED): number
        for name, number in given.items()
        if name.endswith(IS_MEASURED)
    }
    return [name for name in flags if flags[name]], [name for name in flags if not flags[name]]


def _words(name: str) -> Markup:
    for suffix in (*SUFFIX_UNITS, ""):
        if name.endswith(suffix):
            bare = name.removesuffix(suffix)
            break
    if bare.startswith("rule_"):
        return Markup("reversal counted")
    return Markup("<i>{}</i>").format(bare) if len(bare) == 1 else escape(bare.replace("_", " "))


def _with_unit(name: str, number: float) -> str:
    if name.startswith("rule_"):
        return name.removeprefix("rule_").replace("_", " ")
    if name in CHOICES and number in (0.0, 1.0):
        return "yes" if number else "no"
    for suffix, (unit, scale) in SUFFIX_UNITS.items():
        if name.endswith(suffix):
            return f"{plain(number * scale, 4)} {unit}"
    return plain(number, 4)


def model_comparison(results: Results) -> Panel:
    """Return the panel; the table beside it is made from `comparison_rows`."""
    rows = comparison_rows(results)
    told = [row for row in rows if row.verdict in (AGREES, DISAGREES)]
    shown = [row for row in told if _ratio(row.modelled.value, row.measured.value) is not None]
    n = counted(len(shown), "quantities that the walk predicts and the trial measures")
    base: dict[str, Any] = {
        "key": "fig-model",
        "title": "The boundary walk beside the measurement",
        "paper": "",
        "label": "Model",
        "reading": _READING,
        "n": n,
    }
    if not results.chambers:
        return Panel(**base, why=NO_CHAMBER)
    if results.comparison is None:
        return Panel(**base, why="the model was not run on this trial")
    if not shown:
        return Panel(**base, why="the trial measures none of what the walk predicts")
    figure = new_figure(COLUMN_IN, 0.9 + 0.27 * len(shown))
    axes = figure.add_subplot()
    axes.axvline(1.0, color=INK, linewidth=0.5)
    for place, row in enumerate(reversed(shown)):
        _draw_comparison(axes, place, row)
    labels = [f"{plain_symbol(row.measured.name)}" for row in reversed(shown)]
    axes.set_yticks(range(len(shown)), labels)
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(-0.7, len(shown) + 0.2)
    _ratio_axis(axes)
    handles, names = axes.get_legend_handles_labels()
    by_name = dict(zip(names, handles, strict=True))
    order = [name for name in ("measured", "boundary walk", "paper") if name in by_name]
    figure.legend([by_name[name] for name in order], order, loc="outside upper center", ncols=3)
    words = "; ".join(
        f"{spoken(row.measured.name)} measured {value(row.measured)}, "
        f"modelled {value(row.modelled)}"
        for row in shown
    )
    return Panel(**base, figure=figure, alt=f"Model against measurement: {words}.")


def _comparison_row(results: Results, item: ModelQuantity) -> ComparisonRow:
    known = results.quantity(item.name)
    unit = MILLI.get(item.unit, item.unit)
    scale = 1e3 if unit != item.unit else 1.0
    why = known.why or "not measured"
    measured = _scaled(item.name, item.measured, item.measured_low, item.measured_high, scale, unit)
    measured = Quantity(
        item.name,
        measured.value,
        measured.low,
        measured.high,
        known.n,
        unit,
        known.paper,
        why if measured.value is None else "",
    )
    modelled = _scaled(item.name, item.modelled, item.modelled_low, item.modelled_high, scale, unit)
    return ComparisonRow(measured, modelled, _agrees_or_not(measured, modelled))


def _scaled(name: str, middle: float, low: float, high: float, scale: float, unit: str) -> Quantity:
    if not isfinite(middle):
        return Quantity(name, None, unit=unit, why="not modelled")
    ends = [end * scale if isfinite(end) else None for end in (low, high)]
    return Quantity(name, middle * scale, ends[0], ends[1], unit=unit)


def _agrees_or_not(measured: Quantity, modelled: Quantity) -> str:
    if measured.value is None:
        return f"not measured: {measured.why}"
    if modelled.value is None:
        return "not modelled"
    if measured.low is None or measured.high is None:
        return "no interval of the measurement"
    low = modelled.value if modelled.low is None else modelled.low
    high = modelled.value if modelled.high is None else modelled.high
    return AGREES if low <= measured.high and high >= measured.low else DISAGREES


def _ratio(number: float | None, reference: float | None) -> float | None:
    if number is None or not reference or number / reference <= 0:
        return None
    return number / reference


def _draw_comparison(axes: Any, place: int, row: ComparisonRow) -> None:
    reference = row.measured.value
    for quantity, colour, marker, shift, label in (
        (row.measured, INK, "o", 0.13, "measured"),
        (row.modelled, MODEL_COLOUR, "D", -0.13, "boundary walk"),
    ):
        middle = _ratio(quantity.value, reference)
        if middle is None:
            continue
        low = _ratio(quantity.low, reference) or middle
        high = _ratio(quantity.high, reference) or middle
        axes.errorbar(
            middle,
            place + shift,
            xerr=[[middle - low], [high - middle]],
            fmt=marker,
            color=colour,
            markersize=3.5,
            elinewidth=1.0,
            label=label,
        )
    paper = _ratio(row.measured.paper, reference)
    if paper is not None:
        axes.plot(paper, place, "x", color=PAPER_STYLE["color"], markersize=4.5, label="paper")


def _ratio_axis(axes: Any) -> None:
    """Scale the axis of ratios logarithmically, with the numbers that people expect."""
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    low, high = min(low, 0.5), max(high, 2.0)
    steps = (1, 2, 5) if np.log10(high / low) < 2.2 else (1,)
    ticks = [step * 10.0**power for power in range(-4, 5) for step in steps]
    axes.set_xlim(low, high)
    axes.set_xticks([tick for tick in ticks if low <= tick <= high])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("value / measured value")
