"""`contacts.parquet`: a row a contact with the wall, or an excursion from it."""

from collections.abc import Iterator
from math import degrees, radians

import pyarrow as pa

from worm_analysis.results.parquet_table import Columns, Row
from worm_msgs_py import Episode, EpisodeKind
from worm_msgs_py.files.table_schema import NO_UNIT, column, table_schema
from worm_msgs_py.units import MM_PER_M

SCHEMA = table_schema(
    "A row a contact of the head with the wall, or an excursion from it, as each closed.",
    [
        column("chamber", pa.string(), NO_UNIT, "chamber_a or chamber_b."),
        column("kind", pa.string(), NO_UNIT, "contact, or free: an excursion out of contact."),
        column("start_ns", pa.int64(), "ns", "Stamp of its first frame."),
        column(
            "end_ns", pa.int64(), "ns",
            "Stamp of the first frame of what follows, or of its own last one where cut short.",
        ),
        column(
            "distance_mm", pa.float64(), "mm",
            "Arc length R·|Δθ_h|: d_c of a contact, d_nc of an excursion.",
        ),
        column(
            "delta_r_mm", pa.float64(), "mm",
            "Δr_h, max(R − r_h) of an excursion; NaN of a contact.",
        ),
        column(
            "incidence_deg", pa.float64(), "deg",
            "θ_h^i, angle between the head's displacement just before a contact and the normal, "
            "counter-clockwise positive; NaN of an excursion.",
        ),
        column(
            "complete", pa.bool_(), NO_UNIT,
            "False where the trial's start or end, a gap or the exit cut it short.",
        ),
    ],
)  # fmt: skip


def contact_row(episode: Episode) -> Row:
    """Return the row of one contact, or of one excursion from the wall."""
    return {
        "chamber": episode.chamber,
        "kind": str(episode.kind),
        "start_ns": episode.start_ns,
        "end_ns": episode.end_ns,
        "distance_mm": episode.distance_m * MM_PER_M,
        "delta_r_mm": episode.delta_r_m * MM_PER_M,
        "incidence_deg": degrees(episode.incidence_rad),
        "complete": episode.complete,
    }


def read_episodes(contacts: Columns) -> Iterator[Episode]:
    """Yield the episodes of a table in their order."""
    for row in zip(*(contacts[field.name] for field in SCHEMA), strict=True):
        chamber, kind, start_ns, end_ns, distance_mm, depth_mm, incidence_deg, complete = row
        yield Episode(
            chamber=str(chamber),
            kind=EpisodeKind(kind),
            start_ns=int(start_ns),
            end_ns=int(end_ns),
            distance_m=float(distance_mm) / MM_PER_M,
            delta_r_m=float(depth_mm) / MM_PER_M,
            incidence_rad=radians(incidence_deg),
            complete=bool(complete),
        )
