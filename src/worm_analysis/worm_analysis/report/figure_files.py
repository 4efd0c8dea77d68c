"""Draws panels for a page, and writes each figure as SVG and PDF, what it shows as CSV."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv as pa_csv
from markupsafe import Markup

from worm_msgs_py.files.whole_files import whole_file
from worm_msgs_py.text import printable

FIGURES_FOLDER = "figures"
Drawn = tuple[Any, str]
"""A panel, and its figure as SVG for the page."""


def drawn_panels(panels: Iterable[Any], folder: Path, provenance: Mapping[str, Any]) -> list[Drawn]:
    """Return panels with their figures as SVG, and write those into a folder.

    Parameters
    ----------
    panels : iterable of Panel
        Made within `theme.style`.
    folder : Path
        The figures' folder; figures of ours that are not drawn any more are removed from it.
    provenance : mapping
        ``software``, ``version`` and ``trials``, each with its ``source``: told in each file, whose
        bytes depend on the data alone.
    """
    from worm_analysis.report.theme import style, to_svg

    found = []
    with style():
        for panel in panels:
            svg = Markup(to_svg(panel.figure, panel.key, panel.alt)) if panel.figure else ""
            if panel.figure is not None:
                # It has found its layout: with an engine it would be drawn once more for each file.
                panel.figure.set_layout_engine(None)
                _write_formats(panel, folder, provenance)
            found.append((panel, svg))
    drawn = {panel.key for panel, svg in found if svg}
    for old in (*folder.glob("fig-*.svg"), *folder.glob("fig-*.pdf")):
        if old.stem not in drawn:
            old.unlink()
    return found


def _write_formats(panel: Any, folder: Path, provenance: Mapping[str, Any]) -> None:
    folder.mkdir(exist_ok=True)
    made_by = f"{provenance.get('software') or ''} {provenance.get('version') or ''}".strip()
    sources = "; ".join(_source_in_words(trial) for trial in provenance["trials"])
    said = f"{panel.n}. {panel.alt} Trials: {sources}".replace("\u00a0", " ")
    about = {"Title": panel.title, "Creator": printable(made_by)}
    for kind, more in (
        ("svg", {"Description": printable(said), "Date": None}),
        ("pdf", {"Subject": printable(said), "CreationDate": None}),
    ):
        with whole_file(folder / f"{panel.key}.{kind}") as unfinished:
            panel.figure.savefig(unfinished, format=kind, metadata=about | more)


def _source_in_words(trial: Mapping[str, Any]) -> str:
    source = trial["source"] or {}
    name = source_name({"source": source})
    return f"{name} (SHA-256 {source['sha256']})" if source.get("sha256") else name


def source_name(provenance: Mapping[str, Any]) -> str:
    """Return what a trial is called: the name of its bag or camera."""
    source = provenance.get("source") or {}
    for key in ("bag", "table", "camera", "name"):
        if source.get(key):
            return printable(source[key])
    return "unnamed trial"


def write_tables(panel: Any, folder: Path) -> None:
    """Write what a panel shows."""
    folder.mkdir(exist_ok=True)
    for name, columns in panel.tables.items():
        if columns:
            write_csv(folder / f"{'-'.join(filter(None, (panel.key, name)))}.csv", columns)


def write_csv(path: Path, columns: Mapping[str, Any]) -> None:
    """Write columns of equal length; what is not known is an empty cell."""
    arrays = {name: pa.array(values, from_pandas=True) for name, values in columns.items()}
    pa_csv.write_csv(pa.table(arrays), path)
