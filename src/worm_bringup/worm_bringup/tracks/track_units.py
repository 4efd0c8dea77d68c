"""Refuses a table of tracks whose numbers are in other units than its columns say."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats
from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S

SHORTEST_STEP_S, LONGEST_STEP_S = 1e-4, 10.0
"""Between two rows: 10,000 frames a second, and a picture in ten seconds."""
FASTEST_MM_S = 1000.0
FEWEST_YAWS = 50


def refuse_wrong_units(
    path: Path, time_column: str, stamp_ns: NDArray[np.int64], values: dict[str, Floats]
) -> None:
    """Look at the first rows of a table.

    Parameters
    ----------
    path : Path
        For the message.
    time_column : str
        ``stamp_ns`` or ``time_s``, from which the stamps are.
    stamp_ns : ndarray of int64, shape (n,)
        Ascending.
    values : dict of ndarray, shape (n,)
        The table's numbers by column.

    Raises
    ------
    BadInput
        Names the column, a value and the unit that it may be in.
    """
    if len(stamp_ns) < 2:
        return
    step_s = np.diff(stamp_ns) / NS_PER_S
    _refuse_times(path, time_column, float(np.median(step_s)))
    _refuse_speed(path, values, step_s)
    _refuse_radians(path, values)


def _refuse_times(path: Path, column: str, step_s: float) -> None:
    if SHORTEST_STEP_S <= step_s <= LONGEST_STEP_S:
        return
    written = step_s if column == "time_s" else step_s * NS_PER_S
    unit, size = ("s", 1.0) if column == "time_s" else ("ns", 1e-9)
    others = (("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9), ("s", 1.0))
    meant = [
        (name, other / size)
        for name, other in others
        if other != size and 1e-3 <= written * other <= LONGEST_STEP_S
    ]
    cure = "give the time of each frame"
    if meant:
        cure = f"if they are {meant[0][0]}, multiply them by {meant[0][1]:g}"
    raise BadInput(
        f"{path}: column {column!r}: from row to row it is {written:g} {unit} in the median, which "
        f"no camera takes: {cure}"
    )


def _refuse_speed(path: Path, values: dict[str, Floats], step_s: Floats) -> None:
    if not {"head_x_mm", "head_y_mm"} <= values.keys():
        return
    way_mm = np.hypot(np.diff(values["head_x_mm"]), np.diff(values["head_y_mm"]))
    speed = way_mm / step_s
    if not np.isfinite(speed).any():
        return
    median = float(np.nanmedian(speed))
    if median > FASTEST_MM_S:
        raise BadInput(
            f"{path}: columns 'head_x_mm' and 'head_y_mm': the head moves at {median:g} mm/s in "
            "the median, which no worm does: are they in pixels or micrometres, or the times wrong?"
        )


def _refuse_radians(path: Path, values: dict[str, Floats]) -> None:
    """Refuse headings that stay within 2 pi while the body turns by over a right angle."""
    needed = ("head_yaw_deg", "head_x_mm", "head_y_mm", "centroid_x_mm", "centroid_y_mm")
    if not set(needed) <= values.keys():
        return
    yaw, x, y, u, v = (values[name] for name in needed)
    known = np.isfinite(yaw + x + y + u + v)
    if np.count_nonzero(known) < FEWEST_YAWS or np.abs(yaw[known]).max() > 2 * np.pi:
        return
    towards = np.degrees(np.arctan2((y - v)[known], (x - u)[known]))
    if np.percentile(towards, 90) - np.percentile(towards, 10) > 90.0:
        largest = np.abs(yaw[known]).max()
        raise BadInput(
            f"{path}: column 'head_yaw_deg' is at most {largest:g} while the body turns round: it "
            f"may be in radians: multiply it by {180 / np.pi:.4f}"
        )
