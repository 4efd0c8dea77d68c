"""`passages.parquet`: a row a visit of a chamber, or an attempt at its exit."""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import pyarrow as pa

from worm_analysis.results.parquet_table import Columns, Row
from worm_msgs_py import Attempt, StrokePhase, Visit
from worm_msgs_py.files.table_schema import NO_UNIT, PLAIN, column, table_schema
from worm_msgs_py.units import MM_PER_M

SCHEMA = table_schema(
    "A row a visit of a chamber, and a row an attempt at its exit, as each closed. What only the "
    "other kind has is null.",
    [
        column("record", pa.string(), NO_UNIT, "visit or attempt: which of the two the row is."),
        column("chamber", pa.string(), NO_UNIT, "chamber_a or chamber_b, whose exit it is."),
        column(
            "start_ns", pa.int64(), "ns",
            "Stamp of the entry into the chamber; of an attempt, of the head's entering the exit.",
        ),
        column(
            "end_ns", pa.int64(), "ns",
            "Stamp of the head's entering the exit, or of the last frame; of an attempt, of the "
            "head's withdrawal or of the centroid's entering.",
        ),
        column(
            "first_contact_ns", pa.int64(), "ns",
            "Stamp of a visit's first contact with the wall; τ_h counts from here.",
        ),
        column(
            "theta_h0_rad", pa.float64(), "rad",
            "θ_h⁰, polar angle of the head at a visit's first contact, in (−π, π]; null where the "
            "head may have touched the wall before, elsewhere and too shortly to be sure.",
        ),
        column(
            "tau_h_s", pa.float64(), "s",
            "τ_h, time from a visit's first contact until the head enters the exit.",
        ),
        column(
            "skips", pa.int64(), PLAIN,
            "Times that the head passed the exit's arc out of contact and did not enter.",
        ),
        column("penetration_mm", pa.float64(), "mm", "x_p, how far the head got into the passage."),
        column(
            "success", pa.bool_(), NO_UNIT,
            "Whether the centroid followed into the passage; null where nobody saw it.",
        ),
        column(
            "wall_contact", pa.bool_(), NO_UNIT,
            "Whether the head touched the passage's walls; null where it cannot be told.",
        ),
        column(
            "stroke_phase", pa.string(), NO_UNIT,
            "Phase of the peristaltic stroke at withdrawal: elongation, contraction, unknown.",
        ),
        column(
            "complete", pa.bool_(), NO_UNIT,
            "False where the start or end of a visit was not seen, or an attempt was not decided.",
        ),
    ],
)  # fmt: skip


def passage_row(event: Visit | Attempt) -> Row:
    """Return the row of one visit of a chamber, or of one attempt at its exit."""
    row: dict[str, Any] = {
        "chamber": event.chamber,
        "start_ns": event.start_ns,
        "end_ns": event.end_ns,
        "complete": event.complete,
    }
    if isinstance(event, Visit):
        return row | {
            "record": "visit",
            "first_contact_ns": event.first_contact_ns,
            "theta_h0_rad": event.theta_h0_rad,
            "tau_h_s": event.tau_h_s,
            "skips": event.skips,
        }
    return row | {
        "record": "attempt",
        "penetration_mm": event.penetration_m * MM_PER_M,
        "success": event.success,
        "wall_contact": event.wall_contact,
        "stroke_phase": str(event.stroke_phase),
    }


def read_passages(passages: Columns) -> Iterator[Visit | Attempt]:
    """Yield visits and attempts in the order in which they closed.

    An attempt of which nobody saw whether the body followed is left out.
    """
    for number, record in enumerate(passages["record"]):
        row = {field.name: passages[field.name][number] for field in SCHEMA}
        common = str(row["chamber"]), int(row["start_ns"]), int(row["end_ns"])
        complete = bool(row["complete"])
        if record == "visit":
            first_ns = row["first_contact_ns"]
            yield Visit(
                *common,
                first_contact_ns=int(first_ns) if isfinite(first_ns) else None,
                theta_h0_rad=float(row["theta_h0_rad"]),
                tau_h_s=float(row["tau_h_s"]),
                skips=int(row["skips"]),
                complete=complete,
            )
        elif isfinite(row["success"]):
            touched = row["wall_contact"]
            yield Attempt(
                *common,
                penetration_m=float(row["penetration_mm"]) / MM_PER_M,
                success=bool(row["success"]),
                wall_contact=bool(touched) if isfinite(touched) else None,
                stroke_phase=StrokePhase(row["stroke_phase"]),
                complete=complete,
            )
