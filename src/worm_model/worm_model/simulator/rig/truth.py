"""What is true of a drawn frame, with the names and units of the tracker's own table."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import atan2, degrees, hypot
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.drawing import Coverage, worm_coverage
from worm_model.simulator.rig.geometry import Rig

CONTACT_FACTOR = 0.3
"""Contact: R − r_h < 0.3·d_w (SCIENCE.md)."""
MIDLINE_POINTS = 50
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
        The rig that the worm is in.
    body : Body
        The worm. Head and tail tip are its midline's ends, which are the outline's outermost
        points there; the centroid is that of the drawn area, before blur.
    frame, stamp_ns : int
        Number and stamp.
    coverage : Coverage, optional
        The body's, where it is at hand already.
    """
    midline = body.at(np.linspace(0.0, body.length_px, MIDLINE_POINTS))
    head, tail = midline[0], midline[-1]
    centroid = (coverage or worm_coverage(body)).centroid_px()
    neck = body.at(HEAD_PART * body.length_px)
    chamber = rig.chamber_of(*head)
    where = rig.where(*head)
    x_h, y_h = _mm(chamber.to_metres(*map(float, head)))
    x_c, y_c = _mm(chamber.to_metres(*centroid))
    x_t, y_t = _mm(chamber.to_metres(*map(float, tail)))
    x_n, y_n = _mm(chamber.to_metres(*map(float, neck)))
    width_mm = body.mean_width_px / rig.px_per_mm
    r_h = hypot(x_h, y_h)
    in_chamber = where.label == chamber.name
    return TruthRow(
        stamp_ns=stamp_ns,
        frame=frame,
        where=where.label,
        chamber=chamber.name,
        head_u_px=float(head[0]),
        head_v_px=float(head[1]),
        centroid_u_px=centroid[0],
        centroid_v_px=centroid[1],
        tail_u_px=float(tail[0]),
        tail_v_px=float(tail[1]),
        head_x_mm=x_h,
        head_y_mm=y_h,
        centroid_x_mm=x_c,
        centroid_y_mm=y_c,
        tail_x_mm=x_t,
        tail_y_mm=y_t,
        midline_u_px=midline[:, 0].tolist(),
        midline_v_px=midline[:, 1].tolist(),
        length_mm=body.length_px / rig.px_per_mm,
        width_mm=width_mm,
        r_h_mm=r_h,
        r_c_mm=hypot(x_c, y_c),
        r_t_mm=hypot(x_t, y_t),
        theta_h_rad=atan2(y_h, x_h),
        psi_b_deg=_angle_to_normal_deg(x_h, y_h, x_h - x_c, y_h - y_c),
        psi_h_deg=_angle_to_normal_deg(x_h, y_h, x_h - x_n, y_h - y_n),
        contact=rig.radius_mm - r_h < CONTACT_FACTOR * width_mm if in_chamber else None,
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
    unfinished = path.with_name(path.name + ".part")
    pq.write_table(pa.Table.from_pylist(table, schema=SCHEMA), unfinished, compression="zstd")
    unfinished.replace(path)


def _schema() -> pa.Schema:
    types = {
        int: pa.int64(),
        float: pa.float64(),
        str: pa.string(),
        list[float]: pa.list_(pa.float64()),
    }
    annotations = TruthRow.__annotations__
    return pa.schema([(name, types.get(kind, pa.bool_())) for name, kind in annotations.items()])


SCHEMA = _schema()


def _mm(metres: tuple[float, float]) -> tuple[float, float]:
    return metres[0] * 1e3, metres[1] * 1e3


def _angle_to_normal_deg(n_x: float, n_y: float, x: float, y: float) -> float:
    """Signed angle from (n_x, n_y) to (x, y), counter-clockwise positive."""
    return degrees(atan2(n_x * y - n_y * x, n_x * x + n_y * y))
