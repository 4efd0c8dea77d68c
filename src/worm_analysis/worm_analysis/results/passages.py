"""`passages.parquet`: a row a visit of a chamber, or an attempt at its exit."""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import pyarrow as pa

from worm_analysis.results.parquet_table import Columns, Row
from worm_msgs_py import Attempt, StrokePhase, Visit
from worm_msgs_py.units import MM_PER_M

SCHEMA = pa.schema(
    [
        ("record", pa.string()),
        ("chamber", pa.string()),
        ("start_ns", pa.int64()),
        ("end_ns", pa.int64()),
        ("first_contact_ns", pa.int64()),
        ("theta_h0_rad", pa.float64()),
        ("tau_h_s", pa.float64()),
        ("skips", pa.int64()),
        ("penetration_mm", pa.float64()),
        ("success", pa.bool_()),
        ("wall_contact", pa.bool_()),
        ("stroke_phase", pa.string()),
        ("complete", pa.bool_()),
    ]
)


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
