"""Writes the report of several trials: one HTML file, each figure as SVG and PDF, tables as CSV."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from worm_analysis.pooling import Pool, Pooled, WalkPrediction, pooled_trial
from worm_analysis.report.examples import Indices, candidates
from worm_analysis.report.figure_files import (
    FIGURES_FOLDER,
    Drawn,
    drawn_panels,
    source_name,
    write_csv,
    write_tables,
)
from worm_analysis.report.report import counted_missing, templates, trial_context
from worm_analysis.report.symbols import under_rule
from worm_analysis.report.verdicts import headlines, trials_differ
from worm_analysis.results import Results, read_results
from worm_analysis.results.picture import read_kept_picture
from worm_msgs_py import Comparison
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.files.whole_files import whole_file

EXAMPLE_TRIALS = 3
Walks = Callable[[Pool], tuple[WalkPrediction, ...]]
Compare = Callable[[Pool, Sequence[Path]], Mapping[float, Comparison]]
"""From the pool and its trials' directories to the walk beside the trials of each W."""
POOL_REMEDY = "run those trials again, or leave them out of the list"


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A stretch of a trial that could be shown, by its number of reversals."""

    reversals: int
    directory: Path
    rows: Indices


def write_pooled_report(
    directories: Sequence[Path],
    out: Path,
    walks: Walks = lambda pool: (),
    compare: Compare = lambda pool, directories: {},
    software: Mapping[str, str] | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Path:
    """Pool trials and write their report into a directory that is there.

    One trial at a time is read, and reduced to its sums and events.

    Parameters
    ----------
    directories : sequence of Path
        Results directories, one or more.
    out : Path
        Where ``report.html``, ``summary.json``, ``figures/`` and ``tables/`` are written.
    walks, compare : callable
        Give what the boundary walk predicts for the pool, and the walk beside the trials of each W.
    software, progress : mapping, callable
        Name and version, for the provenance; given the trials that were read and how many.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    ReportError
        Where a trial is incomplete, damaged, without a chamber, or there twice; all of them are
        named. A pool that leaves some out unasked would not be what it says.
    """
    pool, shown = _read_trials(directories, progress)
    # Drawing is slow to import, and most users of this package draw nothing.
    from worm_analysis.report.report_data import of_pool

    data = of_pool(pool, walks(pool), compare(pool, directories))
    single = read_results(directories[0]) if len(directories) == 1 else None
    document = _summary_of(data, software or {})
    opening, panels = _panels(data, shown, single, directories[0])
    drawn = drawn_panels([*opening, *panels], out / FIGURES_FOLDER, document["provenance"])
    _write_pool_tables(data, drawn, out / "tables")
    page, path = _render(data, drawn, len(opening), single, document), out / "report.html"
    path.write_text(page, encoding="utf-8", newline="\n")
    text = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    with whole_file(out / "summary.json") as unfinished:  # last: where it is, all is
        unfinished.write_text(text + "\n", encoding="utf-8")
    return path


def _panels(
    data: Any, shown: list[_Candidate], single: Results | None, directory: Path
) -> tuple[list[Any], list[Any]]:
    """Return the panels that open the page, and the others."""
    from worm_analysis.report.panels import opening_panels, pooled_panels, single_panels
    from worm_analysis.report.theme import style

    with style():
        panels = pooled_panels(data, _examples(shown))
        if single is None:
            return [], panels
        opening = opening_panels(single, read_kept_picture(directory, single))
        there = {panel.key for panel in opening}
        others = [panel for panel in panels + single_panels(single) if panel.key not in there]
        return opening, others


def _read_trials(
    directories: Sequence[Path], progress: Callable[[int, int], None]
) -> tuple[Pool, list[_Candidate]]:
    trials, shown, bad = [], [], []
    for number, directory in enumerate(directories):
        try:
            results = read_results(directory)
        except ReportError as error:
            bad.append(str(error).removesuffix(f": {RUN_AGAIN}"))
            continue
        if not results.chambers:
            bad.append(f"{directory}: no chamber in the picture")
            continue
        name = source_name(results.provenance)
        if results.why_not_complete:
            name += " (ended before its time)"
        trials.append(pooled_trial(results, name, directory.name))
        shown += [_Candidate(turns, directory, rows) for turns, rows in candidates(results)]
        shown = _few(shown)
        progress(number + 1, len(directories))
    if bad:
        raise ReportError(
            f"{len(bad)} of {len(directories)} trials cannot be pooled "
            f"({'; '.join(bad)}): {POOL_REMEDY}"
        )
    return Pool.of(trials), shown


def _few(shown: list[_Candidate], most: int = 600) -> list[_Candidate]:
    """Keep memory bounded over any number of trials: thin the candidates evenly by rank."""
    if len(shown) <= most:
        return shown
    ranked = sorted(shown, key=lambda item: item.reversals)
    return [*ranked[::2], ranked[-1]]


def _examples(shown: list[_Candidate]) -> list[Any]:
    """Return the stretches with the fewest, the median and the most reversals, read again."""
    from worm_analysis.report.figures.time_traces import Example

    ranked = sorted(shown, key=lambda item: item.reversals)
    places = sorted(
        {round(k * (len(ranked) - 1) / (EXAMPLE_TRIALS - 1)) for k in range(EXAMPLE_TRIALS)}
    )
    found = []
    for item in [ranked[place] for place in places] if ranked else []:
        results = read_results(item.directory)
        found.append(Example.of(results, item.rows, source_name(results.provenance)))
    return found


def _summary_of(data: Any, software: Mapping[str, str]) -> dict[str, Any]:
    """Return `summary.json`: the numbers, all trials, what the walks were run with."""
    pool = data.pool
    document = {
        "quantities": {name: _number_as_json(found) for name, found in pool.numbers.items()},
        "by_width": {
            f"{part.width_mm:g}": {name: _number_as_json(found) for name, found in numbers.items()}
            for part, numbers in data.by_width
        },
        "walks": [
            {"parameters_of": "this data" if walk.is_own else "the paper", **walk.parameters}
            for walk in data.walks
        ],
        "provenance": {
            **software,
            "trials": [
                {
                    "directory": trial.directory,
                    "source": trial.provenance.get("source"),
                    "version": trial.provenance.get("version"),
                    "parameters": trial.provenance.get("parameters"),
                    "W_mm": _number_or_none(width_mm),
                    "measured_W_mm": _number_or_none(trial.exit_width_mm),
                    "R_mm": trial.radius_mm,
                    "frames": trial.frames,
                    "seconds": trial.seconds,
                }
                for trial, width_mm in zip(pool.trials, pool.widths_mm, strict=True)
            ],
        },
        "complete": True,
    }
    return document


def _number_as_json(pooled: Pooled) -> dict[str, Any]:
    quantity = pooled.quantity
    entry = {
        "value": quantity.value, "low": quantity.low, "high": quantity.high, "n": quantity.n,
        "trials": pooled.trials, "interval_by": pooled.by, "unit": quantity.unit,
        "paper": quantity.paper,
    }  # fmt: skip
    return entry if quantity.value is not None else {**entry, "why": quantity.why}


def _number_or_none(value: float) -> float | None:
    return value if value == value else None


def _write_pool_tables(data: Any, drawn: list[Drawn], folder: Path) -> None:
    """Write what each figure shows, every number of every W, and the list of trials."""
    for panel, _ in drawn:
        write_tables(panel, folder)
    rows = [("all", found) for found in data.pool.numbers.values()]
    for part, numbers in data.by_width:
        rows += [(f"{part.width_mm:g}", found) for found in numbers.values()]
    entries = [{"W_mm": w, "quantity": p.quantity.name, **_number_as_json(p)} for w, p in rows]
    names = ("W_mm", "quantity", "value", "low", "high", "unit", "n", "trials", "interval_by",
             "paper", "why")  # fmt: skip
    write_csv(folder / "numbers.csv", {n: [e.get(n) for e in entries] for n in names})
    trials = data.pool.trials
    write_csv(
        folder / "trials.csv",
        {
            "trial": [trial.name for trial in trials],
            "directory": [trial.directory for trial in trials],
            "sha256": [(trial.provenance.get("source") or {}).get("sha256") for trial in trials],
            "version": [trial.provenance.get("version") for trial in trials],
            "W_mm": data.pool.widths_mm,
            "measured_W_mm": [trial.exit_width_mm for trial in trials],
            "frames": [trial.frames for trial in trials],
            "seconds": [trial.seconds for trial in trials],
        },
    )


def _render(
    data: Any, drawn: list[Drawn], opening: int, single: Results | None, document: Mapping[str, Any]
) -> str:
    from worm_analysis.report.figures.joint_question import answers_in_words

    pool = data.pool
    shown = {name: item for name, item in pool.numbers.items() if not under_rule(name)[1]}
    rows = [[numbers[name] for _, numbers in data.by_width] for name in shown]
    context = {} if single is None else trial_context(single)
    return templates().get_template("pooled.html.j2").render(
        **context,
        single=single,
        title=_title(pool),
        pool=pool,
        widths=[part.width_mm for part, _ in data.by_width],
        everything=list(shown.values()),
        headlines=headlines(data.quantity, partial(trials_differ, pool)),
        counted_missing=counted_missing([found.quantity for found in shown.values()]),
        joint=answers_in_words(data),
        by_width=rows,
        missing_by_width=_missing(rows),
        walks=data.walks,
        interval_text=data.interval_text,
        settings=differing_settings(pool),
        grouped=list(zip(pool.trials, pool.widths_mm, strict=True)),
        opening=drawn[:opening],
        panels=drawn[opening:],
        provenance=document["provenance"],
        hours=sum(trial.seconds for trial in pool.trials) / 3600,
        frames_in_all=sum(trial.frames for trial in pool.trials),
    )  # fmt: skip


def _missing(rows: Sequence[Sequence[Pooled]]) -> str:
    """Say how many cells of the table by width have no value."""
    cells = [found.quantity.value is None for row in rows for found in row]
    if not any(cells):
        return "Every cell has a value."
    return (
        f"{sum(cells)} of {len(cells)} cells have no value (a dash); tables/numbers.csv has each "
        "with its reason."
    )


def _title(pool: Pool) -> str:
    if len(pool.trials) == 1:
        return pool.trials[0].name
    return f"{len(pool.trials)} trials"


def differing_settings(pool: Pool) -> list[tuple[str, list[tuple[str, int]]]]:
    """Return the settings of the analysis in which trials differ: each value and its trials."""
    counts: dict[str, dict[str, int]] = {}
    for trial in pool.trials:
        settings = (trial.provenance.get("parameters") or {}).get("analysis") or {}
        for name, value in settings.items():
            values = counts.setdefault(name, {})
            values[str(value)] = values.get(str(value), 0) + 1
    return [
        (name, sorted(values.items()))
        for name, values in counts.items()
        if len(values) > 1 or sum(values.values()) < len(pool.trials)
    ]
