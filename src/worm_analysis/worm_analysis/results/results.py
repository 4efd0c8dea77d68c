"""One results directory, read and checked: the tables, the sums and the summary."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import Any

from worm_analysis.results import contacts, entries, passages, tracks
from worm_analysis.results.parquet_table import Columns, read_table
from worm_analysis.results.summary import (
    chamber_of,
    comparison_of,
    correlation_of,
    depth_mm_of,
    frames_of,
    provenance_of,
    quantity_of,
    read_summary,
)
from worm_analysis.results.sums import read_sums
from worm_msgs_py import Chamber, Comparison, Correlation, Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.source_events import SourceEvent, in_words, read_source_events
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.files.corrections import (
    Correction,
    corrections_in_words,
    corrections_of,
)
from worm_msgs_py.units import MM_PER_M, NS_PER_S


@dataclass(frozen=True, eq=False)
class Results:
    """One trial, as read from its results directory.

    Attributes
    ----------
    tracks, contacts, passages : mapping of column name to ndarray
        The columns that the report needs; numbers are float64 with NaN for null (stamps are int64),
        `contact` is 1, 0 or NaN.
    quantities : tuple of Quantity
        In the order of the summary.
    chambers : tuple of Chamber
        Empty where there is no chamber in the picture.
    correlation, model_correlation : Correlation or None
        C_θ(t), and the boundary walk's (only its `lag_s` and `c` are known).
    comparison : Comparison or None
        Model against measurement.
    frames, provenance : mapping
        As in the summary.
    source_events : tuple of SourceEvent
        What happened to the pictures.
    why_not_complete : str
        Why the source ended before its time; empty where the trial is whole.
    depth_mm : float
        h; NaN where the summary does not have it.
    sums : mapping of str to ndarray
        What the numbers rest on, by blocks of time.
    corrections : tuple of Correction
        What people have set right, as far as these results have it.
    frames_swapped : int
        Frames whose head and tail were exchanged by the corrections of ranges.
    """

    tracks: Columns
    contacts: Columns
    passages: Columns
    quantities: tuple[Quantity, ...]
    chambers: tuple[Chamber, ...]
    correlation: Correlation | None
    model_correlation: Correlation | None
    comparison: Comparison | None
    frames: Mapping[str, int]
    provenance: Mapping[str, Any]
    depth_mm: float = nan
    source_events: tuple[SourceEvent, ...] = ()
    why_not_complete: str = ""
    sums: Mapping[str, Floats] = field(default_factory=dict)
    corrections: tuple[Correction, ...] = ()
    frames_swapped: int = 0

    @property
    def t_s(self) -> Floats:
        """Time of each frame since the first one, s."""
        stamps = self.tracks["stamp_ns"]
        start = stamps[0] if len(stamps) else 0
        seconds: Floats = (stamps - start) / NS_PER_S
        return seconds

    @property
    def remarks(self) -> list[str]:
        """What happened to the pictures and what was set right by hand, a line each."""
        corrected = corrections_in_words(self.corrections, self.frames_swapped)
        return in_words(self.source_events) + corrected

    @property
    def radius_mm(self) -> float:
        """R of the first chamber; NaN where there is none."""
        return self.chambers[0].radius_m * MM_PER_M if self.chambers else nan

    def quantity(self, name: str) -> Quantity:
        """Return a number of the summary; one that it lacks has no value and says so."""
        for quantity in self.quantities:
            if quantity.name == name:
                return quantity
        return Quantity(name, None, why="not a measured quantity of this trial")


def read_results(directory: Path) -> Results:
    """Read a results directory.

    Raises
    ------
    ReportError
        Where a file is missing, damaged, incomplete or lacks a column.
    """
    if not directory.is_dir():
        raise ReportError(f"{directory}: no such results directory: {RUN_AGAIN}")
    summary_path = directory / "summary.json"
    summary = read_summary(summary_path)
    tables = [
        read_table(directory / "tracks.parquet", tracks.READ),
        read_table(directory / "contacts.parquet", contacts.SCHEMA.names),
        read_table(directory / "passages.parquet", passages.SCHEMA.names),
    ]
    try:
        return _assemble(tables, summary, read_sums(directory / "sums.parquet"))
    except (KeyError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise ReportError(
            f"{summary_path}: not a summary of this version ({error!r}): {RUN_AGAIN}"
        ) from error


def _assemble(
    tables: list[Columns], summary: Mapping[str, Any], sums: Mapping[str, Floats]
) -> Results:
    model = summary.get("model") or {}
    correlation = summary.get("correlation")
    walk = model.get("correlation")
    corrected = summary.get("corrections") or {}
    return Results(
        tracks=tables[0],
        contacts=tables[1],
        passages=tables[2],
        quantities=tuple(quantity_of(name, entry) for name, entry in summary["quantities"].items()),
        chambers=tuple(chamber_of(name, entry) for name, entry in summary["geometry"].items()),
        correlation=correlation_of(correlation) if correlation else None,
        model_correlation=correlation_of(walk) if walk else None,
        comparison=comparison_of(model) if model else None,
        frames=frames_of(summary["frames"]),
        provenance=provenance_of(summary["provenance"]),
        depth_mm=depth_mm_of(summary["geometry"]),
        source_events=read_source_events(summary.get("source_events") or ()),
        why_not_complete=str(summary.get("why_not_complete") or ""),
        sums=sums,
        corrections=corrections_of(corrected.get("applied") or ()),
        frames_swapped=entries.as_count(corrected.get("frames_swapped")),
    )
