"""`tracks.parquet`: a row a frame. For people: lengths in mm, body angles in degrees.

θ_h stays in radians, because it is unwrapped.
"""

from collections.abc import Sequence
from math import degrees
from typing import Any

import numpy as np
import pyarrow as pa

from worm_analysis.results.parquet_table import Row
from worm_msgs_py import BodyState, Keypoint, Midline, Observables
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.files.frame_columns import frame_column
from worm_msgs_py.files.table_schema import table_schema
from worm_msgs_py.units import MM_PER_M

_FLOAT64 = pa.float64()
_DEGREES = degrees(1.0)
_OBSERVED = {
    "r_h_mm": ("r_h_m", MM_PER_M),
    "r_c_mm": ("r_c_m", MM_PER_M),
    "r_t_mm": ("r_t_m", MM_PER_M),
    "theta_h_rad": ("theta_h_rad", 1.0),
    "psi_b_deg": ("psi_b_rad", _DEGREES),
    "psi_h_deg": ("psi_h_rad", _DEGREES),
    "theta_dot_rad_s": ("theta_dot_rad_s", 1.0),
    "v_b_mm_s": ("v_b_m_s", MM_PER_M),
}
"""Columns of the observables, from which field and by which factor."""

TRACKED_STEPS, YAW_STEPS = 2.0**8, 2.0**3
"""Parts of a mm, and of a degree of the head's direction, that a rounded table of tracks counts in:
it errs by 2 µm and 0.06° at most, where the tracker's noise is 20 µm and half a degree or more."""
_OBSERVED_STEPS = {
    "_mm": 2.0**5,
    "_mm_s": 2.0**5,
    "_deg": 2.0**2,
    "_rad": 2.0**8,
    "_rad_s": 2.0**6,
}
"""The same for the observables, by their units: they follow from the places, which are finer, and
what is counted and fitted is not rounded."""

_KINDS = {
    "stamp_ns": pa.int64(),
    "frame": pa.int64(),
    "where": pa.string(),
    "status": pa.string(),
    "confidence": _FLOAT64,
    "head_certainty": _FLOAT64,
    "head_sd_mm": _FLOAT64,
    **{f"{point}_{axis}_px": _FLOAT64 for point in KEYPOINTS for axis in "uv"},
    **{f"{point}_{axis}_mm": _FLOAT64 for point in KEYPOINTS for axis in "xy"},
    **{f"{point}_yaw_deg": _FLOAT64 for point in KEYPOINTS},
    "midline_u_px": pa.list_(pa.float32()),
    "midline_v_px": pa.list_(pa.float32()),
    "midline_width_px": pa.list_(pa.float32()),
    "length_mm": _FLOAT64,
    "width_mm": _FLOAT64,
    "length_px": _FLOAT64,
    "width_px": _FLOAT64,
    **dict.fromkeys(_OBSERVED, _FLOAT64),
    "contact": pa.bool_(),
}
SCHEMA = table_schema(
    "A row a frame, in the order of time, as it was tracked. What is not known is NaN or null. x "
    "and y of a head in the passage are in the frame of the chamber that it came from; where no "
    "chamber is in view they are those of the picture, y down.",
    (frame_column(name, kind) for name, kind in _KINDS.items()),
)
READ = [
    field.name
    for field in SCHEMA
    if not pa.types.is_list(field.type) and field.name != "head_sd_mm"
]
"""The columns that are read: all but the midlines, and what earlier results do not have."""


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
        "head_sd_mm": MM_PER_M * state.head_sd_m,
        "midline_u_px": midline.u_px.astype("float32"),
        "midline_v_px": midline.v_px.astype("float32"),
        "midline_width_px": midline.width_px.astype("float32"),
        "length_mm": state.length_m * MM_PER_M,
        "width_mm": state.width_m * MM_PER_M,
        "length_px": state.length_px,
        "width_px": state.width_px,
        **{name: getattr(observables, of) * by for name, (of, by) in _OBSERVED.items()},
        "contact": observables.contact,
    }
    for name, point in points.items():
        row[f"{name}_u_px"], row[f"{name}_v_px"] = point.u_px, point.v_px
        row[f"{name}_x_mm"], row[f"{name}_y_mm"] = point.x_m * MM_PER_M, point.y_m * MM_PER_M
        row[f"{name}_yaw_deg"] = degrees(point.yaw_rad)
    return row


def observed_columns(found: Sequence[Observables], *, rounded: bool = False) -> dict[str, Any]:
    """Return the columns of the observables of many frames, in whole steps where asked for."""
    columns: dict[str, Any] = {
        name: np.array([getattr(item, of) for item in found]) * by
        for name, (of, by) in _OBSERVED.items()
    }
    if rounded:
        for name, values in columns.items():
            unit = max((end for end in _OBSERVED_STEPS if name.endswith(end)), key=len)
            columns[name] = in_whole_steps(values, _OBSERVED_STEPS[unit])
    return columns | {"contact": [item.contact for item in found]}


def in_whole_steps(values: Floats, steps: float) -> Floats:
    """Return the values, rounded to whole parts of the unit: `steps` of them make one."""
    return np.asarray(np.rint(values * steps) / steps)
