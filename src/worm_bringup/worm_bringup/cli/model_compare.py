"""`worm model compare`: trials beside the exact walk, and what one walk can hold together."""

import json
import sys
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from worm_analysis.report.numbers import interval, value
from worm_bringup.cli import options
from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.terminal import Terminal
from worm_bringup.cli.usage_errors import option_name
from worm_bringup.model_comparisons import Case, compare_trials
from worm_model.boundary_walk.parameters import ReversalRule
from worm_model.inference.comparison import ModelParameters
from worm_model.inference.fit import Speed
from worm_model.inference.required_reversal import paper_needs
from worm_msgs_py import Comparison, ModelQuantity, NeededReversal, Quantity
from worm_msgs_py.contract.agreement import agreements
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.whole_files import new_file
from worm_msgs_py.intervals import Interval, intervals_overlap

_MILLI = {"m": "mm", "m/s": "mm/s"}
PAPER = "the paper's own numbers"
PRINTED_WIDTH = 110
"""Of tables that go into a file: wide enough for every number."""


def compare(
    results: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Directories made by worm replay or analyse; without any, the paper's numbers."
        ),
    ] = None,
    rule: Annotated[
        ReversalRule | None,
        typer.Option(help="What a reversal counts, for the predictions; per_cycle if not given."),
    ] = None,
    speed: Annotated[
        Speed | None,
        typer.Option(help="The walk's speed: v_b, the mean one along the wall, or v_w."),
    ] = None,
    hop_may_land: Annotated[
        bool | None, typer.Option(help="A hop that ends above the exit finds it, as by default.")
    ] = None,
    effective_width: Annotated[
        bool | None,
        typer.Option(help="Take the exit as √(W² + h²) wide, as by default, or as W."),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(help="Draw the joint question of the last table: .svg, .png or .pdf."),
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Hold trials against the exact walk, and ask which observations one walk can hold together.

    Each trial by itself, then all trials of one W together. The second table says which reversal
    each observation alone would need, under every rule and at either speed: where the intervals do
    not meet, no walk gives both.

    Try it: `worm model compare` for the paper's numbers, or `worm model compare out/walk-results`.
    """
    given = {
        "rule": rule,
        "speed": speed,
        "hop_may_land": hop_may_land,
        "effective_width": effective_width,
    }
    told: dict[str, Any] = {
        name: getattr(value, "value", value) for name, value in given.items() if value is not None
    }
    if told and not results:
        raise BadInput(
            f"{option_name(next(iter(told)))} is for predictions: name the results to predict, or "
            "leave it out"
        )
    parameters = ModelParameters(**told)
    if figure is not None:
        _refuse_figure(figure)
    if results:
        with progress_bar("trials") as progress:
            cases = compare_trials(results, parameters, progress)
    else:
        cases = [Case(PAPER, 0, Comparison(0, needs=paper_needs()))]
    if figure is not None:
        _draw_file(cases[-1], figure)
    if as_json:
        document = [_as_json(case) for case in cases]
        typer.echo(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))
        return
    console = Terminal(width=None if sys.stdout.isatty() else PRINTED_WIDTH)
    for case in cases:
        _print(console, case)


def _refuse_figure(figure: Path) -> None:
    """Refuse a figure that could not be written, before the work is done."""
    if figure.suffix not in (".svg", ".png", ".pdf"):
        raise BadInput(f"{figure}: a figure ends in .svg, .png or .pdf: rename it")
    if not figure.parent.is_dir():
        raise BadInput(f"{figure}: there is no directory {figure.parent}: make it first")


def _draw_file(case: Case, path: Path) -> None:
    """Draw the joint question into a file that is there whole or not at all."""
    # Drawing is slow to import, and mostly not asked for.
    from worm_analysis.report.figures.joint_question import joint_figure
    from worm_analysis.report.theme import style

    if case.comparison is None or not case.comparison.needs:
        raise BadInput(f"{case.name}: no observation to draw: {case.why or 'nothing was measured'}")
    with new_file(path) as unfinished, style():
        figure = joint_figure(case.comparison.needs)
        figure.savefig(unfinished, format=path.suffix[1:], dpi=200)


def _print(console: Console, case: Case) -> None:
    if case.comparison is None:
        console.print(f"{case.name}: {case.why}")
        return
    if case.comparison.quantities:
        console.print(_measured_table(case.name, case.comparison))
    if case.comparison.scores:
        console.print(_scores_line(dict(case.comparison.scores)))
    needs = case.comparison.needs
    for speed in dict.fromkeys(need.speed for need in needs):
        console.print(_needs_table(case.name, [n for n in needs if n.speed == speed], speed))
    for agreement in agreements(needs):
        console.print(agreement.in_words() + ".")


def _measured_table(name: str, comparison: Comparison) -> Table:
    table = _empty_table(name, "", "measured", "95 %", "walk", "95 %", "unit", "")
    own = dict(comparison.parameters)
    for item in comparison.quantities:
        measured, modelled = _of_people(item)
        verdict = "given to the walk" if own.get(f"{item.name}_is_measured") else _verdict_of(item)
        unit = _MILLI.get(item.unit, item.unit)
        table.add_row(
            item.name, value(measured), interval(measured), value(modelled), interval(modelled),
            "" if unit == "1" else unit, verdict,
        )  # fmt: skip
    return table


def _needs_table(name: str, needs: list[NeededReversal], speed: str) -> Table:
    rules = list(dict.fromkeys(need.rule for need in needs))
    heads = [f"{rule}, 1/s" if rule == ReversalRule.RATE else rule for rule in rules]
    table = _empty_table(f"{name}: reversal needed at {speed}", "for", *heads)
    for observation in dict.fromkeys(need.observation for need in needs):
        found = {n.rule: n for n in needs if n.observation == observation}
        table.add_row(observation, *(_needed(found.get(rule)) for rule in rules))
    return table


def _empty_table(title: str, *heads: str) -> Table:
    first, *others = heads
    return Table(Column(first, no_wrap=True), *others, title=title, box=SIMPLE_HEAD)


def _needed(need: NeededReversal | None) -> str:
    if need is None:
        return "not measured"
    if not isfinite(need.low):
        return "none gives it"
    low, high = (f"{end:.3g}" if isfinite(end) else "∞" for end in (need.low, need.high))
    middle = f"{need.value:.3g} " if isfinite(need.value) else ""
    return f"{middle}[{low} … {high}]"


def _scores_line(scores: dict[str, float]) -> str:
    return (
        f"{scores['passages']:.0f} passages forecast: CRPS {scores['crps_s']:.3g} s, of a "
        f"memoryless forecast {scores['crps_memoryless_s']:.3g} s; probability integral transform "
        f"uniform with p = {scores['pit_p']:.2g}."
    )


def _of_people(item: ModelQuantity) -> tuple[Quantity, Quantity]:
    return (
        _as_quantity(item, item.measured, item.measured_low, item.measured_high),
        _as_quantity(item, item.modelled, item.modelled_low, item.modelled_high),
    )


def _as_quantity(item: ModelQuantity, *numbers: float) -> Quantity:
    scale = 1e3 if item.unit in _MILLI else 1.0
    middle, low, high = (end * scale if isfinite(end) else None for end in numbers)
    return Quantity(item.name, middle, low, high)


def _verdict_of(item: ModelQuantity) -> str:
    measured: Interval = (item.measured, item.measured_low, item.measured_high)
    if not isfinite(item.measured):
        return "not measured"
    if not (isfinite(item.measured_low) and isfinite(item.measured_high)):
        return "no interval measured"
    low = item.modelled if item.modelled_low != item.modelled_low else item.modelled_low
    high = item.modelled if item.modelled_high != item.modelled_high else item.modelled_high
    return "agrees" if intervals_overlap(measured, (item.modelled, low, high)) else "does not agree"


def _as_json(case: Case) -> dict[str, Any]:
    document: dict[str, Any] = {"name": case.name, "trials": case.trials}
    if case.comparison is None:
        return document | {"why": case.why}
    found = case.comparison
    document |= {
        "parameters": dict(found.parameters),
        "quantities": {item.name: asdict(item) for item in found.quantities},
        "forecasts": dict(found.scores),
        "needed_reversals": [asdict(need) for need in found.needs],
        "agreements": [
            asdict(item) | {"answer": item.in_words()} for item in agreements(found.needs)
        ],
    }
    finite: dict[str, Any] = _nan_to_none(document)
    return finite


def _nan_to_none(item: Any) -> Any:
    if isinstance(item, dict):
        return {key: _nan_to_none(part) for key, part in item.items()}
    if isinstance(item, list | tuple):
        return [_nan_to_none(part) for part in item]
    if isinstance(item, float) and not isfinite(item):
        return "inf" if item > 0.0 else None
    return item
