"""Writes the report of several trials: one HTML file, each figure as SVG and PDF, tables as CSV."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv as pa_csv
from markupsafe import Markup

from worm_analysis.pooling import Pool, Pooled, WalkPrediction, pooled_trial
from worm_analysis.report.examples import Indices, candidates
from worm_analysis.report.report import source_name, templates, trial_context
from worm_analysis.report.symbols import under_rule
from worm_analysis.results import Results, read_results
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.files.whole_files import whole_file

EXAMPLES = 3
BESIDE_IN_POOL = ("fig-1c", "fig-4c", "fig-8", "fig-model")
Walks = Callable[[Pool], tuple[WalkPrediction, ...]]
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
    walks : callable
        Gives what the boundary walk predicts for the pool.
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
    pool, shown = _read(directories, progress)
    # Drawing is slow to import, and most users of this package draw nothing.
    from worm_analysis.report.report_data import of_pool

    data = of_pool(pool, walks(pool))
    single = read_results(directories[0]) if len(directories) == 1 else None
    document = _document(data, software or {})
    drawn = [
        _write_panel(panel, out, document["provenance"]) for panel in _panels(data, shown, single)
    ]
    _write_numbers(data, out / "tables")
    path = out / "report.html"
    path.write_text(_render(data, drawn, single, document), encoding="utf-8", newline="\n")
    text = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    with whole_file(out / "summary.json") as unfinished:  # last: where it is, all is
        unfinished.write_text(text + "\n", encoding="utf-8")
    return path


def _panels(data: Any, shown: list[_Candidate], single: Results | None) -> list[Any]:
    from worm_analysis.report.panels import pooled_panels, single_panels
    from worm_analysis.report.theme import style

    with style():
        panels = pooled_panels(data, _examples(shown))
        return panels if single is None else panels + single_panels(single)


def _write_panel(panel: Any, out: Path, provenance: Mapping[str, Any]) -> tuple[Any, str, str]:
    """Write a panel's figure and tables; return it with its figure as SVG."""
    from worm_analysis.report.theme import style, to_svg

    with style():
        svg = Markup(to_svg(panel.figure, panel.key, panel.alt)) if panel.figure else ""
        if panel.figure:  # it has found its layout, which takes longer than drawing it again
            panel.figure.set_layout_engine("none")
        _write_figure(panel, out / "figures", provenance)
    _write_tables(panel, out / "tables")
    return panel, svg, Markup(panel.reading)


def _read(
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
    places = sorted({round(k * (len(ranked) - 1) / (EXAMPLES - 1)) for k in range(EXAMPLES)})
    found = []
    for item in [ranked[place] for place in places] if ranked else []:
        results = read_results(item.directory)
        found.append(Example.of(results, item.rows, source_name(results.provenance)))
    return found


def _document(data: Any, software: Mapping[str, str]) -> dict[str, Any]:
    """Return `summary.json`: the numbers, all trials, what the walks were run with."""
    pool = data.pool
    document = {
        "quantities": {name: _entry(found) for name, found in pool.numbers.items()},
        "by_width": {
            f"{part.width_mm:g}": {name: _entry(found) for name, found in numbers.items()}
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
                    "W_mm": _finite(width_mm),
                    "measured_W_mm": _finite(trial.exit_width_mm),
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


def _entry(pooled: Pooled) -> dict[str, Any]:
    quantity = pooled.quantity
    entry = {
        "value": quantity.value, "low": quantity.low, "high": quantity.high, "n": quantity.n,
        "trials": pooled.trials, "interval_by": pooled.by, "unit": quantity.unit,
        "paper": quantity.paper,
    }  # fmt: skip
    return entry if quantity.value is not None else {**entry, "why": quantity.why}


def _finite(value: float) -> float | None:
    return value if value == value else None


def _write_figure(panel: Any, folder: Path, provenance: Mapping[str, Any]) -> None:
    """Write a figure as SVG and PDF, each with its sources; the bytes depend on the data alone."""
    if panel.figure is None:
        return
    folder.mkdir(exist_ok=True)
    made_by = f"{provenance.get('software', '')} {provenance.get('version', '')}".strip()
    sources = "; ".join(_source(trial) for trial in provenance["trials"])
    said = f"{panel.n}. {panel.alt} Trials: {sources}".replace("\u00a0", " ")
    panel.figure.savefig(
        folder / f"{panel.key}.svg",
        metadata={"Title": panel.title, "Description": said, "Creator": made_by, "Date": None},
    )
    panel.figure.savefig(
        folder / f"{panel.key}.pdf",
        metadata={
            "Title": panel.title, "Subject": said, "Creator": made_by, "CreationDate": None,
        },
    )  # fmt: skip


def _source(trial: Mapping[str, Any]) -> str:
    source = trial["source"] or {}
    name = source_name({"source": source})
    return f"{name} (SHA-256 {source['sha256']})" if source.get("sha256") else name


def _write_tables(panel: Any, folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    for name, columns in panel.tables.items():
        if columns:
            write_csv(folder / f"{'-'.join(filter(None, (panel.key, name)))}.csv", columns)


def write_csv(path: Path, columns: Mapping[str, Any]) -> None:
    """Write columns of equal length; what is not known is an empty cell."""
    arrays = {name: pa.array(values, from_pandas=True) for name, values in columns.items()}
    pa_csv.write_csv(pa.table(arrays), path)


def _write_numbers(data: Any, folder: Path) -> None:
    """Write every number of every W, and the list of trials."""
    rows = [("all", found) for found in data.pool.numbers.values()]
    for part, numbers in data.by_width:
        rows += [(f"{part.width_mm:g}", found) for found in numbers.values()]
    entries = [{"W_mm": w, "quantity": p.quantity.name, **_entry(p)} for w, p in rows]
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
    data: Any, panels: list[Any], single: Results | None, document: Mapping[str, Any]
) -> str:
    pool = data.pool
    names = list(pool.numbers)
    context = {} if single is None else trial_context(single)
    return templates().get_template("pooled.html.j2").render(
        **{"units": {"1": "", "deg": "°"}, **context},
        single=single,
        title=_title(pool),
        pool=pool,
        widths=[part.width_mm for part, _ in data.by_width],
        everything=list(pool.numbers.values()),
        by_width=[
            [numbers[name] for _, numbers in data.by_width]
            for name in names
            if not under_rule(name)[1]
        ],
        walks=data.walks,
        interval_text=data.interval_text,
        settings=differing_settings(pool),
        grouped=list(zip(pool.trials, pool.widths_mm, strict=True)),
        panels=panels,
        beside=BESIDE_IN_POOL,
        provenance=document["provenance"],
        hours=sum(trial.seconds for trial in pool.trials) / 3600,
        frames_in_all=sum(trial.frames for trial in pool.trials),
    )  # fmt: skip


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
