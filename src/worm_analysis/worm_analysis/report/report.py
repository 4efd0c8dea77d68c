"""Writes `report.html`: one file that shows a trial's numbers and figures without any network."""

from collections.abc import Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from worm_analysis.report import numbers, symbols
from worm_analysis.report.figure_files import FIGURES_FOLDER, Drawn, drawn_panels, source_name
from worm_analysis.report.panel import thousands
from worm_analysis.report.verdicts import REJECTED, headlines
from worm_analysis.results import Results, read_results
from worm_analysis.results.picture import TrialPicture, read_kept_picture
from worm_msgs_py import Quantity, Status
from worm_msgs_py.files.whole_files import whole_file
from worm_msgs_py.text import printable

SOURCES = {
    "bag": "Bag",
    "table": "Table of tracks",
    "sha256": "SHA-256",
    "topic": "Topic",
    "camera": "Camera",
    "start_offset_s": "Start offset (s)",
    "playback_duration_s": "Playback duration (s)",
}


def write_report(results_dir: Path) -> Path:
    """Write `report.html` and `figures/` into a results directory.

    The bytes depend on the results alone.

    Parameters
    ----------
    results_dir : Path
        What the recorder wrote: `tracks.parquet`, `contacts.parquet`, `passages.parquet` and
        `summary.json`.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    ReportError
        Where a file is missing, damaged, incomplete or lacks a column.
    """
    results = read_results(results_dir)
    html = render(results, read_kept_picture(results_dir, results), results_dir / FIGURES_FOLDER)
    path = results_dir / "report.html"
    with whole_file(path) as unfinished:
        unfinished.write_text(html, encoding="utf-8", newline="\n")
    return path


def render(results: Results, picture: TrialPicture | None, figures: Path) -> str:
    """Return the report's HTML; write its figures as SVG and PDF into a folder."""
    # Drawing is slow to import, and most users of this package draw nothing.
    from worm_analysis.report.panels import opening_panels, trial_panels
    from worm_analysis.report.theme import style

    with style():
        opening, panels = opening_panels(results, picture), trial_panels(results)
    drawn = drawn_panels([*opening, *panels], figures, _figure_provenance(results.provenance))
    own = [item for item in results.quantities if not symbols.under_rule(item.name)[1]]
    return (
        templates()
        .get_template("report.html.j2")
        .render(
            **trial_context(results),
            name=source_name(results.provenance),
            source=_source_rows(results.provenance),
            noted=_noted(results.provenance),
            parameters=results.provenance.get("parameters") or {},
            opening=drawn[: len(opening)],
            panels=drawn[len(opening) :],
            headlines=headlines(results.quantity),
            own_numbers=own,
            counted_missing=counted_missing(own),
        )
    )


def lone_column(drawn: Sequence[Drawn]) -> list[str]:
    """Return the key of the column that has none beside it: the last one of an odd number."""
    columns = [panel.key for panel, _ in drawn if panel.is_column]
    return columns[-1:] if len(columns) % 2 else []


def counted_missing(quantities: Sequence[Quantity]) -> str:
    """Say how many of the numbers have no value."""
    missing = sum(quantity.value is None for quantity in quantities)
    if not missing:
        return f"All of the {len(quantities)} numbers have a value."
    return (
        f"{missing} of {len(quantities)} numbers have no value: they are in the last lines of the "
        "table, a line a reason."
    )


def _figure_provenance(provenance: Mapping[str, Any]) -> dict[str, Any]:
    return {**provenance, "trials": [{"source": provenance.get("source")}]}


def templates() -> Environment:
    """Return what fills in the templates; whatever comes from outside is text, not markup."""
    found = Environment(
        loader=PackageLoader("worm_analysis.report", "."),
        autoescape=True,
        finalize=_text_for_page,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    for name in ("html_symbol", "meaning"):
        found.filters[name] = _as_markup(getattr(symbols, name))
    found.filters["markup"] = Markup  # ours; what a trial is called in it is escaped
    found.filters["lone_column"] = lone_column
    found.filters["setting_in_words"] = symbols.setting_in_words
    found.filters["choice_in_words"] = symbols.choice_in_words
    found.globals["rejected"] = REJECTED
    found.globals["units"] = symbols.UNITS
    for function in (
        numbers.value,
        numbers.interval,
        numbers.plain,
        numbers.with_deviation,
        thousands,
    ):
        found.filters[function.__name__] = function
    return found


def _text_for_page(value: Any) -> Any:
    """Return text as it can stand in a page: no control characters, no halves of characters."""
    return printable(value) if type(value) is str else value


def trial_context(results: Results) -> dict[str, Any]:
    """Return what the templates say of one trial."""
    from worm_analysis.report.figures.model_comparison import (
        comparison_rows,
        origins,
        parameters_written,
        verdict_in_words,
    )

    rows = comparison_rows(results)
    own, from_paper = origins(results)
    return {
        "results": results,
        "degrees": degrees,
        "frames": frame_counts(results),
        "frames_with_pose": frames_with_pose(results),
        "seconds": float(results.t_s[-1]) if len(results.t_s) else 0.0,
        "frame_rate": _frame_rate(results),
        "events": _event_counts(results),
        "source_events": results.remarks,
        "comparison": rows,
        "own": own,
        "from_paper": from_paper,
        "verdicts": verdict_in_words(rows),
        "walk": parameters_written(results),
    }


def frames_with_pose(results: Results) -> int:
    """Return how many frames have a status with a pose: of a folded worm, too."""
    return sum(results.frames.get(status.label, 0) for status in Status if status.has_pose)


def frame_counts(results: Results) -> list[tuple[str, int, str]]:
    """Return label, number and reason of every status that occurs; `tracked` first."""
    found = []
    for label, count in results.frames.items():
        if label == "read" or (count == 0 and label != "tracked"):
            continue
        try:
            reason = Status.from_label(label).reason
        except ValueError:
            reason = ""
        found.append((label, count, reason))
    return sorted(found, key=lambda item: (item[0] != "tracked", -item[1], item[0]))


def _source_rows(provenance: Mapping[str, Any]) -> list[tuple[str, str]]:
    source = provenance.get("source") or {}
    return [
        (SOURCES.get(key) or symbols.setting_in_words(key), str(value))
        for key, value in source.items()
        if value is not None
    ]


def _noted(provenance: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what the lab has noted of a trial: label and text."""
    noted = provenance.get("trial")
    units = {"temperature_c": " °C"}
    return [
        (name.removesuffix("_c").capitalize(), f"{value}{units.get(name, '')}")
        for name, value in (noted.items() if isinstance(noted, Mapping) else ())
    ]


def _frame_rate(results: Results) -> float | None:
    frames = len(results.t_s)
    return (frames - 1) / float(results.t_s[-1]) if frames > 1 and results.t_s[-1] > 0 else None


def _event_counts(results: Results) -> list[str]:
    kind, record = results.contacts["kind"], results.passages["record"]
    return [
        _several(int((kind == "contact").sum()), "contact", "s with the wall"),
        _several(int((kind == "free").sum()), "excursion", "s from it"),
        _several(int((record == "visit").sum()), "visit", "s of a chamber"),
        _several(int((record == "attempt").sum()), "attempt", "s at the exit"),
    ]


def _several(count: int, noun: str, rest: str) -> str:
    """Return ``1 visit of a chamber`` or ``2 visits of a chamber``."""
    return f"{thousands(count)} {noun}{rest.removeprefix('s') if count == 1 else rest}"


def _as_markup(function: Any) -> Any:
    def filtered(name: str) -> Markup:
        known = symbols.is_known(name)
        return Markup(function(name)) if known else Markup.escape(function(name))

    return filtered
