"""`contacts.parquet`: a row a contact with the wall, or an excursion from it."""

from collections.abc import Iterator
from math import degrees, radians

import pyarrow as pa

from worm_analysis.results.parquet_table import Columns, Row
from worm_msgs_py import Episode, EpisodeKind
from worm_msgs_py.units import MM_PER_M

SCHEMA = pa.schema(
    [
        ("chamber", pa.string()),
        ("kind", pa.string()),
        ("start_ns", pa.int64()),
        ("end_ns", pa.int64()),
        ("distance_mm", pa.float64()),
        ("delta_r_mm", pa.float64()),
        ("incidence_deg", pa.float64()),
        ("complete", pa.bool_()),
    ]
)


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
