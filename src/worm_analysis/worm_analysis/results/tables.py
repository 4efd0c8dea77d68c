"""Reads one results directory: the tables and the summary that the recorder wrote."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite, nan, radians
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_analysis.results.errors import ReportError
from worm_msgs_py import Chamber, Comparison, Correlation, ModelQuantity, Quantity
from worm_msgs_py.model import NeededReversal
from worm_msgs_py.source_events import SourceEvent, read_source_events

Floats = NDArray[np.float64]
Columns = Mapping[str, NDArray[Any]]

POINTS = ("head", "centroid", "tail")
TRACKS = (
    "stamp_ns",
    "frame",
    "where",
    "status",
    *(f"{point}_{axis}_px" for point in POINTS for axis in "uv"),
    *(f"{point}_{axis}_mm" for point in POINTS for axis in "xy"),
    "length_mm",
    "length_px",
    "r_h_mm",
    "r_c_mm",
    "r_t_mm",
    "theta_h_rad",
    "psi_b_deg",
    "psi_h_deg",
    "theta_dot_rad_s",
    "v_b_mm_s",
    "contact",
)
CONTACTS = (
    "chamber",
    "kind",
    "start_ns",
    "end_ns",
    "distance_mm",
    "delta_r_mm",
    "incidence_deg",
    "complete",
)
PASSAGES = (
    "record",
    "chamber",
    "start_ns",
    "end_ns",
    "first_contact_ns",
    "theta_h0_rad",
    "tau_h_s",
    "skips",
    "penetration_mm",
    "success",
    "wall_contact",
    "stroke_phase",
    "complete",
)
REMEDY = "run `worm replay` or `worm analyse` again"


@dataclass(frozen=True, eq=False)
class Results:
    """One trial, as read from its results directory.

    Attributes
    ----------
    tracks, contacts, passages : mapping of column name to ndarray
        The columns that the report needs; numbers are float64 with NaN for null (stamps are int64),
        `contact` is 1, 0 or NaN.
    quantities : tuple of Quantity
        In the order of the summary.
    chambers : tuple of Chamber
        Empty where there is no chamber in the picture.
    correlation, model_correlation : Correlation or None
        C_θ(t), and the boundary walk's (only its `lag_s` and `c` are known).
    comparison : Comparison or None
        Model against measurement.
    frames, provenance : mapping
        As in the summary.
    source_events : tuple of SourceEvent
        What happened to the pictures.
    why_not_complete : str
        Why the source ended before its time; empty where the trial is whole.
    depth_mm : float
        h; NaN where the summary does not have it.
    """

    tracks: Columns
    contacts: Columns
    passages: Columns
    quantities: tuple[Quantity, ...]
    chambers: tuple[Chamber, ...]
    correlation: Correlation | None
    model_correlation: Correlation | None
    comparison: Comparison | None
    frames: Mapping[str, int]
    provenance: Mapping[str, Any]
    depth_mm: float = nan
    source_events: tuple[SourceEvent, ...] = ()
    why_not_complete: str = ""

    @property
    def t_s(self) -> Floats:
        """Time of each frame since the first one, s."""
        stamps = self.tracks["stamp_ns"]
        start = stamps[0] if len(stamps) else 0
        seconds: Floats = (stamps - start) * 1e-9
        return seconds

    @property
    def radius_mm(self) -> float:
        """R of the first chamber; NaN where there is none."""
        return self.chambers[0].radius_m * 1e3 if self.chambers else nan

    def quantity(self, name: str) -> Quantity:
        """Return a number of the summary; one that it lacks has no value and says so."""
        for quantity in self.quantities:
            if quantity.name == name:
                return quantity
        return Quantity(name, None, why="not a measured quantity of this trial")


def read_results(directory: Path) -> Results:
    """Read a results directory.

    Raises
    ------
    ReportError
        Where a file is missing, damaged, incomplete or lacks a column.
    """
    if not directory.is_dir():
        raise ReportError(f"{directory}: no such results directory: {REMEDY}")
    summary_path = directory / "summary.json"
    summary = _read_summary(summary_path)
    tables = [
        _read_table(directory / name, columns)
        for name, columns in (
            ("tracks.parquet", TRACKS),
            ("contacts.parquet", CONTACTS),
            ("passages.parquet", PASSAGES),
        )
    ]
    try:
        return _assemble(tables, summary)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ReportError(
            f"{summary_path}: not a summary of this version ({error!r}): {REMEDY}"
        ) from error


def _assemble(tables: list[Columns], summary: Mapping[str, Any]) -> Results:
    model = summary.get("model") or {}
    correlation = summary.get("correlation")
    walk = model.get("correlation")
    return Results(
        tracks=tables[0],
        contacts=tables[1],
        passages=tables[2],
        quantities=tuple(_quantity(name, entry) for name, entry in summary["quantities"].items()),
        chambers=tuple(chamber_of(name, entry) for name, entry in summary["geometry"].items()),
        correlation=_correlation(correlation) if correlation else None,
        model_correlation=_correlation(walk) if walk else None,
        comparison=_comparison(model) if model else None,
        frames=summary["frames"],
        provenance=summary["provenance"],
        depth_mm=_depth_mm(summary["geometry"]),
        source_events=read_source_events(summary.get("source_events") or ()),
        why_not_complete=str(summary.get("why_not_complete") or ""),
    )


def _read_summary(path: Path) -> Mapping[str, Any]:
    try:
        summary: Any = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ReportError(f"{path}: not there, so this is no result of a trial: {REMEDY}") from None
    except (OSError, ValueError) as error:
        raise ReportError(f"{path}: cannot be read ({error}): {REMEDY}") from error
    missing = [
        key
        for key in ("quantities", "geometry", "frames", "provenance")
        if not isinstance(summary, dict) or not isinstance(summary.get(key), dict)
    ]
    if missing:
        raise ReportError(f"{path}: lacks {missing[0]!r}: {REMEDY}")
    if summary.get("complete") is not True and not summary.get("why_not_complete"):
        raise ReportError(f"{path}: says that the results are not complete: {REMEDY}")
    return dict(summary)


def _read_table(path: Path, columns: Iterable[str]) -> Columns:
    try:
        known = set(pq.read_schema(path).names)
        missing = [name for name in columns if name not in known]
        if missing:
            raise ReportError(f"{path}: has no column {', '.join(map(repr, missing))}: {REMEDY}")
        table = pq.read_table(path, columns=list(columns))
    except FileNotFoundError:
        raise ReportError(f"{path}: not there: {REMEDY}") from None
    except (OSError, pa.ArrowException) as error:
        raise ReportError(f"{path}: cannot be read as Parquet ({error}): {REMEDY}") from error
    return {name: _to_numpy(table.column(name)) for name in columns}


def _to_numpy(column: Any) -> NDArray[Any]:
    if pa.types.is_string(column.type):
        words = column.combine_chunks().dictionary_encode()  # a word once, however often it is
        known = np.array([*words.dictionary.to_pylist(), None], dtype=object)
        return np.asarray(known[words.indices.fill_null(-1).to_numpy(zero_copy_only=False)])
    if pa.types.is_integer(column.type) and column.null_count == 0:
        return np.asarray(column.to_numpy(), dtype=np.int64)
    if pa.types.is_boolean(column.type):
        column = column.cast(pa.uint8())
    return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)


def _number(value: Any) -> float:
    return nan if value is None else float(value)


def _floats(values: Any) -> Floats:
    return np.array([_number(value) for value in values or ()], dtype=np.float64)


def _quantity(name: str, entry: Mapping[str, Any]) -> Quantity:
    return Quantity(
        name,
        entry["value"],
        entry.get("low"),
        entry.get("high"),
        int(entry.get("n") or 0),
        entry.get("unit") or "1",
        entry.get("paper"),
        entry.get("why") or "",
    )


def chamber_of(name: str, entry: Mapping[str, Any]) -> Chamber:
    """Return a chamber from its entry in `summary.json`; KeyError where its circle is missing."""
    return Chamber(
        name=name,
        centre_u_px=_number(entry["centre_u_px"]),
        centre_v_px=_number(entry["centre_v_px"]),
        radius_px=_number(entry["radius_px"]),
        exit_rad=radians(_number(entry["exit_deg"])),
        radius_m=_radius_mm(entry) / 1e3,
        exit_width_m=_number(entry.get("exit_width_mm")) / 1e3,
        residual_px=_number(entry.get("residual_px")),
        centre_sd_px=_number(entry.get("centre_sd_px")),
        radius_sd_px=_number(entry.get("radius_sd_px")),
        exit_sd_rad=radians(_number(entry.get("exit_sd_deg"))),
        exit_width_sd_m=_number(entry.get("exit_width_sd_mm")) / 1e3,
    )


def _depth_mm(geometry: Mapping[str, Any]) -> float:
    entry: Mapping[str, Any] = next(iter(geometry.values()), {})
    return _number(entry.get("depth_mm"))


def _radius_mm(entry: Mapping[str, Any]) -> float:
    """Return R: of tracks that came without a picture it is all that is known of the circle."""
    if entry.get("radius_mm") is not None:
        return float(entry["radius_mm"])
    return _number(entry["radius_px"]) / _number(entry["px_per_mm"])


def _correlation(entry: Mapping[str, Any]) -> Correlation:
    lag_s, c = _floats(entry["lag_s"]), _floats(entry["c"])
    unknown = np.full(len(lag_s), nan)
    if len(c) != len(lag_s):
        raise ValueError(f"{len(lag_s)} lags of the correlation but {len(c)} values")
    return Correlation(
        lag_s=lag_s,
        c=c,
        error=_floats(entry["error"]) if "error" in entry else unknown,
        pairs=np.asarray(entry.get("pairs") or np.zeros(len(lag_s)), dtype=np.int64),
        model=_floats(entry["fit"]) if "fit" in entry else unknown,
    )


def _comparison(entry: Mapping[str, Any]) -> Comparison:
    fields = (
        "measured",
        "measured_low",
        "measured_high",
        "modelled",
        "modelled_low",
        "modelled_high",
    )
    return Comparison(
        stamp_ns=0,
        parameters=tuple((name, _number(value)) for name, value in entry["parameters"].items()),
        quantities=tuple(
            ModelQuantity(name, item["unit"], **{key: _number(item.get(key)) for key in fields})
            for name, item in entry["quantities"].items()
        ),
        needs=tuple(_need(item) for item in entry.get("needed_reversals") or ()),
        scores=tuple(
            (name, _number(value)) for name, value in (entry.get("forecasts") or {}).items()
        ),
    )


def _need(entry: Mapping[str, Any]) -> NeededReversal:
    low, high = _number(entry["low"]), _number(entry["high"])
    return NeededReversal(
        rule=entry["rule"],
        speed=entry["speed"],
        observation=entry["observation"],
        value=_number(entry["value"]),
        low=low,
        high=inf if isfinite(low) and not isfinite(high) else high,  # JSON has no infinity
        is_measured=bool(entry["is_measured"]),
    )
