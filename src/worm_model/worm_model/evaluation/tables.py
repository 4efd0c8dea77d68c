"""Reads tracks and truth from Parquet tables, and the calibration from the summary beside them."""

from collections.abc import Mapping
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_model.evaluation.frame_table import ChamberCircle, FrameTable
from worm_msgs_py import Status
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.errors import EvaluationError
from worm_msgs_py.files.json_files import read_json

TRACKS_FILE, SUMMARY_FILE = "tracks.parquet", "summary.json"
_WANTED = "a table such as `worm replay` and `worm simulate` write"
_KEYPOINT_COLUMNS = tuple(f"{point}_{axis}_px" for point in KEYPOINTS for axis in "uv")
_CIRCLE_COLUMNS = ("circle_u_px", "circle_v_px", "circle_radius_px", "exit_deg")


def read_tracks(path: Path) -> FrameTable:
    """Read what the tracker said.

    Parameters
    ----------
    path : Path
        A results directory, or its ``tracks.parquet``. The calibration is taken from the
        ``summary.json`` beside it, where there is one, else from the table's own columns.

    Raises
    ------
    EvaluationError
        Where it cannot be read, or lacks columns.
    """
    file = path / TRACKS_FILE if path.is_dir() else path
    summary = file.with_name(SUMMARY_FILE)
    return frame_table_of(str(file), _read_columns(file), _circles_of_summary(summary))


def read_truth(path: Path) -> FrameTable:
    """Read what is true of a trial: a table as beside the bags of `worm simulate`.

    Raises
    ------
    EvaluationError
        Where it cannot be read, or lacks columns.
    """
    return frame_table_of(str(path), _read_columns(path))


def frame_table_of(
    name: str, columns: Mapping[str, list[Any]], circles: Mapping[str, ChamberCircle] | None = None
) -> FrameTable:
    """Turn a table's columns into a record.

    Parameters
    ----------
    name : str
        What errors call the table.
    columns : mapping of str to list
        One value a row; None stands for unknown. ``head_u_px`` … ``tail_v_px`` and ``stamp_ns`` or
        ``frame`` must be there.
    circles : mapping, optional
        The chambers; by default the last ones in the columns ``circle_u_px``, ``circle_v_px``,
        ``circle_radius_px``, ``exit_deg``, by ``chamber``.

    Raises
    ------
    EvaluationError
        Where columns are missing.
    """
    missing = [column for column in _KEYPOINT_COLUMNS if column not in columns]
    if "stamp_ns" not in columns and "frame" not in columns:
        missing.append("stamp_ns (or frame)")
    if missing:
        raise EvaluationError(
            f"{name}: no column {', '.join(missing)}; its columns must be those of tracks.parquet"
        )
    head, centroid, tail = (
        np.stack([_reals(columns[f"{point}_{axis}_px"]) for axis in "uv"], axis=1)
        for point in KEYPOINTS
    )
    tracked = np.isfinite(head[:, 0] + head[:, 1])
    if "status" in columns:
        tracked &= np.isin(columns["status"], [each.label for each in Status if each.has_pose])
    return FrameTable(
        name=name,
        head_px=head,
        centroid_px=centroid,
        tail_px=tail,
        tracked=tracked,
        stamp_ns=_integers(name, columns, "stamp_ns"),
        frame=_integers(name, columns, "frame"),
        midline_px=_midlines_px(columns),
        head_certainty=_optional(columns, "head_certainty"),
        r_h_mm=_optional(columns, "r_h_mm"),
        contact=_optional(columns, "contact"),
        where=np.array(columns["where"], dtype=np.str_) if "where" in columns else None,
        circles=_circles_of_rows(columns) if circles is None else dict(circles),
    )


def _read_columns(file: Path) -> dict[str, list[Any]]:
    try:
        table = pq.read_table(file)
    except FileNotFoundError:
        raise EvaluationError(f"{file}: there is no such file; give {_WANTED}") from None
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0]
        raise EvaluationError(
            f"{file}: cannot be read as Parquet ({reason}); give {_WANTED}"
        ) from None
    return {name: table[name].to_pylist() for name in table.column_names}


def _circles_of_summary(file: Path) -> dict[str, ChamberCircle] | None:
    try:
        geometry = read_json(file).get("geometry", {})
        return {
            name: ChamberCircle(
                chamber["centre_u_px"],
                chamber["centre_v_px"],
                chamber["radius_px"],
                nan if chamber["exit_deg"] is None else chamber["exit_deg"],
            )
            for name, chamber in geometry.items()
        }
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, AttributeError, TypeError) as error:
        raise EvaluationError(f"{file}: not a summary of results: {error!r}") from None


def _circles_of_rows(columns: Mapping[str, list[Any]]) -> dict[str, ChamberCircle]:
    if any(column not in columns for column in ("chamber", *_CIRCLE_COLUMNS)):
        return {}
    rows = zip(*(columns[column] for column in _CIRCLE_COLUMNS), strict=True)
    return {
        name: ChamberCircle(*row)
        for name, row in zip(columns["chamber"], rows, strict=True)
        if name and None not in row
    }


def _reals(values: list[Any]) -> Floats:
    return np.array([nan if value is None else float(value) for value in values], dtype=np.float64)


def _optional(columns: Mapping[str, list[Any]], name: str) -> Floats | None:
    return _reals(columns[name]) if name in columns else None


def _integers(table: str, columns: Mapping[str, list[Any]], name: str) -> NDArray[np.int64] | None:
    if name not in columns:
        return None
    if None in columns[name]:
        raise EvaluationError(f"{table}: the column {name} has empty rows")
    return np.array(columns[name], dtype=np.int64)


def _midlines_px(columns: Mapping[str, list[Any]]) -> list[Floats] | None:
    if "midline_u_px" not in columns or "midline_v_px" not in columns:
        return None
    return [
        np.empty((0, 2))
        if u is None or v is None
        else np.stack([_reals(list(u)), _reals(list(v))], axis=1)
        for u, v in zip(columns["midline_u_px"], columns["midline_v_px"], strict=True)
    ]
