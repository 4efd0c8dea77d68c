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
    from worm_analysis.report.theme import style

    found: list[Drawn] = []
    with style():
        for panel in panels:
            svg = Markup(_write_figure(panel, folder, provenance) if panel.figure else "")
            found.append((panel, svg))
    drawn = {panel.key for panel, svg in found if svg}
    for old in (*folder.glob("fig-*.svg"), *folder.glob("fig-*.pdf")):
        if old.stem not in drawn:
            old.unlink()
    return found


def _write_figure(panel: Any, folder: Path, provenance: Mapping[str, Any]) -> str:
    """Write a panel's figure as SVG and PDF; return it as SVG for the page."""
    from worm_analysis.report.theme import drawn_svg, for_page, on_white

    folder.mkdir(exist_ok=True)
    made_by = f"{provenance.get('software') or ''} {provenance.get('version') or ''}".strip()
    sources = "; ".join(_source_in_words(trial) for trial in provenance["trials"])
    said = printable(f"{panel.n}. {panel.alt} Trials: {sources}".replace("\u00a0", " "))
    about = {"Title": panel.title, "Creator": printable(made_by)}
    svg = drawn_svg(panel.figure, about | {"Description": said})
    with whole_file(folder / f"{panel.key}.svg") as unfinished:
        unfinished.write_text(on_white(svg), encoding="utf-8", newline="\n")
    more = {"Subject": said, "CreationDate": None}
    with whole_file(folder / f"{panel.key}.pdf") as unfinished:
        panel.figure.savefig(unfinished, format="pdf", metadata=about | more)
    return for_page(svg, panel.figure, panel.key, panel.alt)


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
            stem = "-".join(filter(None, (panel.key, name))).replace(".", "-")
            write_csv(folder / f"{stem}.csv", columns)


def write_csv(path: Path, columns: Mapping[str, Any]) -> None:
    """Write columns of equal length; what is not known is an empty cell."""
    arrays = {name: pa.array(values, from_pandas=True) for name, values in columns.items()}
    pa_csv.write_csv(pa.table(arrays), path)
