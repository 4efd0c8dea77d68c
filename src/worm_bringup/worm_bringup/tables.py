"""The rows of `tracks.parquet`, `contacts.parquet` and `passages.parquet`, and their writer.

People read these tables, so lengths are in millimetres and body angles in degrees; θ_h stays in
radians because it is unwrapped.
"""

from collections.abc import Mapping
from contextlib import suppress
from math import degrees
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pyarrow as pa
import pyarrow.parquet as pq

from worm_msgs_py import Attempt, BodyState, Episode, Keypoint, Midline, Observables, Visit
from worm_tracker.record_file import RecordFile

_POINTS = ("head", "centroid", "tail")
_REAL = pa.float64()
_COUNT = pa.int64()

TRACKS = pa.schema(
    [
        ("stamp_ns", _COUNT),
        ("frame", _COUNT),
        ("where", pa.string()),
        ("status", pa.string()),
        ("confidence", _REAL),
        ("head_certainty", _REAL),
        *((f"{point}_{axis}_px", _REAL) for point in _POINTS for axis in "uv"),
        *((f"{point}_{axis}_mm", _REAL) for point in _POINTS for axis in "xy"),
        *((f"{point}_yaw_deg", _REAL) for point in _POINTS),
        ("midline_u_px", pa.list_(pa.float32())),
        ("midline_v_px", pa.list_(pa.float32())),
        ("midline_width_px", pa.list_(pa.float32())),
        ("length_mm", _REAL),
        ("width_mm", _REAL),
        ("length_px", _REAL),
        ("width_px", _REAL),
        ("r_h_mm", _REAL),
        ("r_c_mm", _REAL),
        ("r_t_mm", _REAL),
        ("theta_h_rad", _REAL),
        ("psi_b_deg", _REAL),
        ("psi_h_deg", _REAL),
        ("theta_dot_rad_s", _REAL),
        ("v_b_mm_s", _REAL),
        ("contact", pa.bool_()),
    ]
)

CONTACTS = pa.schema(
    [
        ("chamber", pa.string()),
        ("kind", pa.string()),
        ("start_ns", _COUNT),
        ("end_ns", _COUNT),
        ("distance_mm", _REAL),
        ("delta_r_mm", _REAL),
        ("incidence_deg", _REAL),
        ("complete", pa.bool_()),
    ]
)

PASSAGES = pa.schema(
    [
        ("record", pa.string()),
        ("chamber", pa.string()),
        ("start_ns", _COUNT),
        ("end_ns", _COUNT),
        ("first_contact_ns", _COUNT),
        ("theta_h0_rad", _REAL),
        ("tau_h_s", _REAL),
        ("skips", _COUNT),
        ("penetration_mm", _REAL),
        ("success", pa.bool_()),
        ("wall_contact", pa.bool_()),
        ("stroke_phase", pa.string()),
        ("complete", pa.bool_()),
    ]
)

Row = Mapping[str, Any]


def track_row(state: BodyState, midline: Midline, observables: Observables) -> Row:
    """Return one frame's row; the three belong to the same frame."""
    points: dict[str, Keypoint] = {
        "head": state.head,
        "centroid": state.centroid,
        "tail": state.tail,
    }
    row: dict[str, Any] = {
        "stamp_ns": state.stamp_ns,
        "frame": state.frame,
        "where": state.where.label,
        "status": state.status.label,
        "confidence": state.confidence,
        "head_certainty": state.head_certainty,
        "midline_u_px": midline.u_px.astype("float32"),
        "midline_v_px": midline.v_px.astype("float32"),
        "midline_width_px": midline.width_px.astype("float32"),
        "length_mm": state.length_m * 1e3,
        "width_mm": state.width_m * 1e3,
        "length_px": state.length_px,
        "width_px": state.width_px,
        "r_h_mm": observables.r_h_m * 1e3,
        "r_c_mm": observables.r_c_m * 1e3,
        "r_t_mm": observables.r_t_m * 1e3,
        "theta_h_rad": observables.theta_h_rad,
        "psi_b_deg": degrees(observables.psi_b_rad),
        "psi_h_deg": degrees(observables.psi_h_rad),
        "theta_dot_rad_s": observables.theta_dot_rad_s,
        "v_b_mm_s": observables.v_b_m_s * 1e3,
        "contact": observables.contact,
    }
    for name, point in points.items():
        row[f"{name}_u_px"], row[f"{name}_v_px"] = point.u_px, point.v_px
        row[f"{name}_x_mm"], row[f"{name}_y_mm"] = point.x_m * 1e3, point.y_m * 1e3
        row[f"{name}_yaw_deg"] = degrees(point.yaw_rad)
    return row


def contact_row(episode: Episode) -> Row:
    """Return the row of one contact, or of one excursion from the wall."""
    return {
        "chamber": episode.chamber,
        "kind": str(episode.kind),
        "start_ns": episode.start_ns,
        "end_ns": episode.end_ns,
        "distance_mm": episode.distance_m * 1e3,
        "delta_r_mm": episode.delta_r_m * 1e3,
        "incidence_deg": degrees(episode.incidence_rad),
        "complete": episode.complete,
    }


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
        "penetration_mm": event.penetration_m * 1e3,
        "success": event.success,
        "wall_contact": event.wall_contact,
        "stroke_phase": str(event.stroke_phase),
    }


class TableWriter:
    """Writes rows as they come, a row group at a time: memory stays bounded over any trial.

    The bytes depend on the rows alone.
    """

    _GROUP_ROWS = 512

    def __init__(self, path: Path, schema: pa.Schema):
        self._schema = schema
        self._rows: list[Row] = []
        self._file = RecordFile(path)
        self._writer = pq.ParquetWriter(self._file, schema, compression="zstd")
        self._file.commit()

    @property
    def waiting(self) -> bool:
        """Whether rows are not on the disk because it is full: make room, and `commit`."""
        return self._file.waiting > 0

    def append(self, row: Row) -> None:
        """Add a row; columns that it lacks are null."""
        self._rows.append(row)
        if len(self._rows) >= self._GROUP_ROWS:
            self._flush()
            with suppress(OSError):  # it is tried again
                self._file.commit()

    def commit(self) -> None:
        """Put what waits onto the disk; OSError where it does not fit."""
        self._file.commit()

    def close(self) -> None:
        """Write what is left and the footer; OSError where they do not fit: try again."""
        if self._file.closed:
            return
        self._flush()
        self._writer.close()
        self._file.commit()
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType
    ) -> None:
        self.close()

    def _flush(self) -> None:
        if self._rows:
            columns = {name: [row.get(name) for row in self._rows] for name in self._schema.names}
            self._writer.write_table(pa.table(columns, schema=self._schema))
            self._rows.clear()
