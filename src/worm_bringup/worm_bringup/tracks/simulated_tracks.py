"""The tracks of a simulated worm without pictures: what a perfect tracker would have seen."""

from collections.abc import Iterable

import numpy as np
import pyarrow as pa

from worm_analysis.results.tracks import TRACKED_STEPS, YAW_STEPS, in_whole_steps
from worm_model.simulator.body_width import tapered
from worm_model.simulator.film import frame_stamp_ns
from worm_model.simulator.rig.truth import HEAD_PART
from worm_msgs_py.arrays import Floats


def track_table(midlines_mm: Iterable[Floats], frames_per_s: float, width_mm: float) -> pa.Table:
    """Return midlines as a table that `worm analyse` takes.

    Parameters
    ----------
    midlines_mm : iterable of ndarray, shape (n, 2)
        x, y in the frame of chamber a, head tip first.
    frames_per_s : float
    width_mm : float
        The body's full width; its ends taper as in the films.

    Returns
    -------
    pyarrow.Table
        Stamp, head, centroid of the body's area and tail in chamber a's millimetres, the head's
        direction, length and width. Where strands lie on each other the area counts twice.
    """
    rows = [_track_row(line, width_mm) for line in midlines_mm]
    values = np.array(rows).reshape(-1, len(_TRACK_COLUMNS))
    columns = dict(zip(_TRACK_COLUMNS, values.T, strict=True))
    stamps = [frame_stamp_ns(frame, frames_per_s) for frame in range(len(rows))]
    return pa.table({"stamp_ns": pa.array(stamps, pa.int64()), **columns})


_TRACK_COLUMNS = (
    "head_x_mm", "head_y_mm", "centroid_x_mm", "centroid_y_mm", "tail_x_mm", "tail_y_mm",
    "head_yaw_deg", "length_mm", "width_mm",
)  # fmt: skip


def as_a_tracker_knows(table: pa.Table) -> pa.Table:
    """Return the table with places and lengths in 256ths of a mm, directions in 8ths of a degree.

    That is a tenth of what the tracker's noise is, and the table takes an eighth of the room. The
    steps are a power of two, so that they are exact, and later bits of a number are all 0.
    """
    for index, name in enumerate(table.column_names):
        if name in _TRACK_COLUMNS and name != "width_mm":
            steps = YAW_STEPS if name.endswith("_deg") else TRACKED_STEPS
            values = in_whole_steps(table.column(name).to_numpy(), steps)
            table = table.set_column(index, name, pa.array(values))
    return table


def _track_row(line: Floats, width_mm: float) -> tuple[float, ...]:
    step = np.hypot(*np.diff(line, axis=0).T)
    s = np.r_[0.0, np.cumsum(step)]
    width = tapered(s / width_mm)
    area = 0.5 * (width[1:] + width[:-1]) * step
    x, y = area @ (0.5 * (line[1:] + line[:-1])) / area.sum()
    neck = [np.interp(HEAD_PART * s[-1], s, line[:, axis]) for axis in (0, 1)]
    ahead = line[0] - neck
    yaw = np.degrees(np.arctan2(ahead[1], ahead[0]))
    return (*line[0], x, y, *line[-1], float(yaw), float(s[-1]), width_mm)
