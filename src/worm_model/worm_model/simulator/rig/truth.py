"""What is true of a drawn frame, with the names and units of the tracker's own table."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from math import atan2, degrees, hypot
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.drawing import Coverage, worm_coverage
from worm_model.simulator.rig.geometry import Rig
from worm_msgs_py.files.frame_columns import frame_column
from worm_msgs_py.files.table_schema import table_schema
from worm_msgs_py.files.whole_files import whole_file
from worm_msgs_py.paper import CONTACT_DISTANCE_WIDTHS
from worm_msgs_py.units import MM_PER_M

TRUE_MIDLINE_POINTS = 50
HEAD_PART = 0.1
"""The head's direction is that of the midline's first tenth."""


@dataclass(frozen=True, slots=True)
class TruthRow:
    """One frame's truth; the columns of ``tracks.parquet`` that a drawing determines.

    Pixels are picture coordinates, v down. Metric coordinates are in the frame of the nearest
    chamber. `theta_h_rad` is in (−π, π] here and unwrapped in the table. `contact` is None where
    the head is in the passage. `width_mm` is the mean over the middle half. `circle_…` and
    `exit_deg` are the circle and the exit's direction of that chamber in this frame's picture.
    """

    stamp_ns: int
    frame: int
    where: str
    chamber: str
    head_u_px: float
    head_v_px: float
    centroid_u_px: float
    centroid_v_px: float
    tail_u_px: float
    tail_v_px: float
    head_x_mm: float
    head_y_mm: float
    centroid_x_mm: float
    centroid_y_mm: float
    tail_x_mm: float
    tail_y_mm: float
    midline_u_px: list[float]
    midline_v_px: list[float]
    length_mm: float
    width_mm: float
    r_h_mm: float
    r_c_mm: float
    r_t_mm: float
    theta_h_rad: float
    psi_b_deg: float
    psi_h_deg: float
    contact: bool | None
    circle_u_px: float
    circle_v_px: float
    circle_radius_px: float
    exit_deg: float


def truth_of(
    rig: Rig, body: Body, frame: int, stamp_ns: int, coverage: Coverage | None = None
) -> TruthRow:
    """Return the truth of one frame.

    Parameters
    ----------
    rig : Rig
    body : Body
        The worm. Its tips are its midline's ends; the centroid is that of the drawn area.
    frame, stamp_ns : int
    coverage : Coverage, optional
        The body's, where it is at hand already.
    """
    midline = body.at(np.linspace(0.0, body.length_px, TRUE_MIDLINE_POINTS))
    chamber, where = rig.chamber_of(*midline[0]), rig.where(*midline[0])
    points = {
        "head": _pair(midline[0]),
        "centroid": (coverage or worm_coverage(body)).centroid_px(),
        "tail": _pair(midline[-1]),
    }
    neck = _pair(body.at(HEAD_PART * body.length_px))
    mm = {name: _mm(chamber.to_metres(*point)) for name, point in (*points.items(), ("neck", neck))}
    head = mm["head"]
    width_mm = body.mean_width_px / rig.px_per_mm
    r_h = hypot(*head)
    in_chamber = where.label == chamber.name
    return TruthRow(
        stamp_ns=stamp_ns,
        frame=frame,
        where=where.label,
        chamber=chamber.name,
        **_point_columns(points, "uv", "px"),
        **_point_columns({name: mm[name] for name in points}, "xy", "mm"),
        midline_u_px=midline[:, 0].tolist(),
        midline_v_px=midline[:, 1].tolist(),
        length_mm=body.length_px / rig.px_per_mm,
        width_mm=width_mm,
        r_h_mm=r_h,
        r_c_mm=hypot(*mm["centroid"]),
        r_t_mm=hypot(*mm["tail"]),
        theta_h_rad=atan2(head[1], head[0]),
        psi_b_deg=_angle_to_normal_deg(head, mm["centroid"]),
        psi_h_deg=_angle_to_normal_deg(head, mm["neck"]),
        contact=rig.radius_mm - r_h < CONTACT_DISTANCE_WIDTHS * width_mm if in_chamber else None,
        circle_u_px=chamber.centre_u_px,
        circle_v_px=chamber.centre_v_px,
        circle_radius_px=chamber.radius_px,
        exit_deg=degrees(chamber.exit_rad),
    )


def write_truth(rows: Iterable[TruthRow], path: Path) -> None:
    """Write the truth of a film as Parquet, whole or not at all.

    θ_h is unwrapped in time, anew each time that the head comes into the frame of another chamber.
    """
    table = [asdict(row) for row in rows]
    theta = np.array([row["theta_h_rad"] for row in table])
    frames = np.array([row["chamber"] for row in table])
    starts = 1 + np.flatnonzero(frames[1:] != frames[:-1])
    for part in np.split(np.arange(len(table)), starts):
        for index, value in zip(part, np.unwrap(theta[part]), strict=True):
            table[index]["theta_h_rad"] = float(value)
    with whole_file(path) as unfinished:
        pq.write_table(pa.Table.from_pylist(table, schema=SCHEMA), unfinished, compression="zstd")


def _truth_schema() -> pa.Schema:
    types = {
        int: pa.int64(),
        float: pa.float64(),
        str: pa.string(),
        list[float]: pa.list_(pa.float64()),
    }
    annotations = TruthRow.__annotations__
    return table_schema(
        "A row a frame of a drawn film: what is true of it.",
        (frame_column(name, types.get(kind, pa.bool_())) for name, kind in annotations.items()),
    )


SCHEMA = _truth_schema()


def _point_columns(
    points: Mapping[str, tuple[float, float]], axes: str, unit: str
) -> dict[str, float]:
    """Return points as columns of the table, such as `head_u_px`."""
    return {
        f"{name}_{axis}_{unit}": at
        for name, point in points.items()
        for axis, at in zip(axes, point, strict=True)
    }


def _pair(point: NDArray[np.float64]) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _mm(metres: tuple[float, float]) -> tuple[float, float]:
    return metres[0] * MM_PER_M, metres[1] * MM_PER_M


def _angle_to_normal_deg(head: tuple[float, float], behind: tuple[float, float]) -> float:
    """Signed angle from the normal at the head to the way to it, counter-clockwise positive."""
    n_x, n_y = head
    x, y = n_x - behind[0], n_y - behind[1]
    return degrees(atan2(n_x * y - n_y * x, n_x * x + n_y * y))
