"""Reads one results directory: the tables and the summary that the recorder wrote."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite, isnan, nan, radians
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_analysis.results import entries
from worm_analysis.results.errors import ReportError
from worm_msgs_py import Chamber, Comparison, Correlation, ModelQuantity, Quantity
from worm_msgs_py.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.json_files import read_json
from worm_msgs_py.limits import RADIUS
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
WORDS = ("where", "status", "chamber", "kind", "record", "stroke_phase")
STAMPS = ("stamp_ns", "start_ns", "end_ns")
CHAMBERS = (CHAMBER_A, CHAMBER_B)
RULES, SPEEDS = ("per_cycle", "per_phase", "rate"), ("v_w", "v_b")
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
    except (KeyError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
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
        frames=_frames(summary["frames"]),
        provenance=_provenance(summary["provenance"]),
        depth_mm=_depth_mm(summary["geometry"]),
        source_events=read_source_events(summary.get("source_events") or ()),
        why_not_complete=str(summary.get("why_not_complete") or ""),
    )


def _frames(entry: Mapping[str, Any]) -> Mapping[str, int]:
    for key in ("read", "tracked"):
        if key not in entry:
            raise KeyError(f"frames.{key}")
    return {entries.name(label): entries.whole(count) for label, count in entry.items()}


def _provenance(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the provenance; what it says is text for the page, whatever it is."""
    source = entries.mapping(entry.get("source"))
    parameters = {
        node: entries.mapping(values)
        for node, values in entries.mapping(entry.get("parameters")).items()
    }
    told = {key: str(entry[key]) for key in ("software", "version") if entry.get(key) is not None}
    source = {key: value if value is None else str(value) for key, value in source.items()}
    return {
        **entry,
        "software": None,
        "version": None,
        **told,
        "source": source,
        "parameters": parameters,
    }


def _read_summary(path: Path) -> Mapping[str, Any]:
    try:
        summary: Any = read_json(path)
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
        return {name: _to_numpy(name, table.column(name)) for name in columns}
    except FileNotFoundError:
        raise ReportError(f"{path}: not there: {REMEDY}") from None
    except (OSError, pa.ArrowException) as error:
        raise ReportError(f"{path}: cannot be read as Parquet ({error}): {REMEDY}") from error
    except ReportError:
        raise
    except ValueError as error:
        raise ReportError(f"{path}: {error}: {REMEDY}") from None


def _to_numpy(name: str, column: Any) -> NDArray[Any]:
    """Return a column as the report needs it; ValueError where it holds something else."""
    kind = column.type
    if name in WORDS:
        if not (pa.types.is_string(kind) or pa.types.is_null(kind)):
            raise ValueError(f"column {name!r} is of type {kind}, not words")
        dictionary = column.cast(pa.string()).combine_chunks().dictionary_encode()
        known = [*map(entries.name, dictionary.dictionary.to_pylist()), None]  # each word once
        index = dictionary.indices.fill_null(-1).to_numpy(zero_copy_only=False)
        return np.asarray(np.array(known, dtype=object)[index])
    if name in STAMPS and (not pa.types.is_integer(kind) or column.null_count):
        raise ValueError(f"column {name!r} is of type {kind}, or has empty rows: not all stamps")
    if not (pa.types.is_primitive(kind) or pa.types.is_null(kind)):
        raise ValueError(f"column {name!r} is of type {kind}, not numbers")
    if pa.types.is_integer(kind) and column.null_count == 0:
        return np.asarray(column.to_numpy(), dtype=np.int64)
    if pa.types.is_boolean(kind):
        column = column.cast(pa.uint8())
    values = np.asarray(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)
    if not name.endswith("_ns") and (np.abs(values) > entries.MOST).any():
        raise ValueError(f"column {name!r} holds a number beyond all measure")
    return values


def _quantity(name: str, entry: Mapping[str, Any]) -> Quantity:
    return Quantity(
        entries.name(name),
        entries.number_or_none(entry["value"]),
        entries.number_or_none(entry.get("low")),
        entries.number_or_none(entry.get("high")),
        entries.whole(entry.get("n")),
        entries.words(entry.get("unit")) or "1",
        entries.number_or_none(entry.get("paper")),
        entries.words(entry.get("why")),
    )


def chamber_of(name: str, entry: Mapping[str, Any]) -> Chamber:
    """Return a chamber from its entry in `summary.json`; KeyError where its circle is missing."""
    return Chamber(
        name=entries.one_of(name, CHAMBERS),
        centre_u_px=entries.number(entry["centre_u_px"]),
        centre_v_px=entries.number(entry["centre_v_px"]),
        radius_px=entries.number(entry["radius_px"]),
        exit_rad=radians(entries.number(entry["exit_deg"])),
        radius_m=_radius_mm(entry) / 1e3,
        exit_width_m=entries.number(entry.get("exit_width_mm")) / 1e3,
        residual_px=entries.number(entry.get("residual_px")),
        centre_sd_px=entries.number(entry.get("centre_sd_px")),
        radius_sd_px=entries.number(entry.get("radius_sd_px")),
        exit_sd_rad=radians(entries.number(entry.get("exit_sd_deg"))),
        exit_width_sd_m=entries.number(entry.get("exit_width_sd_mm")) / 1e3,
    )


def _depth_mm(geometry: Mapping[str, Any]) -> float:
    entry: Mapping[str, Any] = next(iter(geometry.values()), {})
    return entries.number(entry.get("depth_mm"))


def _radius_mm(entry: Mapping[str, Any]) -> float:
    """Return R: of tracks that came without a picture it is all that is known of the circle."""
    if entry.get("radius_mm") is not None:
        radius_mm = entries.number(entry["radius_mm"])
    else:
        radius_mm = entries.number(entry["radius_px"]) / entries.number(entry["px_per_mm"])
    wrong = "" if isnan(radius_mm) else RADIUS.to("mm").refusal(radius_mm)
    if wrong:
        raise ValueError(f"the radius of a chamber {wrong}")
    return radius_mm


def _correlation(entry: Mapping[str, Any]) -> Correlation:
    lag_s = entries.numbers(entry["lag_s"])
    unknown = [None] * len(lag_s)
    found = {key: entries.numbers(entry.get(key) or unknown) for key in ("c", "error", "fit")}
    pairs = entry.get("pairs") or [0] * len(lag_s)
    for key, values in (*found.items(), ("pairs", pairs)):
        if len(values) != len(lag_s):
            raise ValueError(f"{len(lag_s)} lags of the correlation but {len(values)} of {key}")
    return Correlation(
        lag_s=lag_s,
        c=found["c"],
        error=found["error"],
        pairs=np.array([entries.whole(count) for count in pairs], dtype=np.int64),
        model=found["fit"],
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
        parameters=tuple(
            (entries.name(name), entries.number(value))
            for name, value in entry["parameters"].items()
        ),
        quantities=tuple(
            ModelQuantity(
                entries.name(name),
                entries.words(item["unit"]),
                **{key: entries.number(item.get(key)) for key in fields},
            )
            for name, item in entry["quantities"].items()
        ),
        needs=tuple(_need(item) for item in entry.get("needed_reversals") or ()),
        scores=tuple(
            (entries.name(name), entries.number(value))
            for name, value in entries.mapping(entry.get("forecasts")).items()
        ),
    )


def _need(entry: Mapping[str, Any]) -> NeededReversal:
    low, high = entries.number(entry["low"]), entries.number(entry["high"])
    return NeededReversal(
        rule=entries.one_of(entry["rule"], RULES),
        speed=entries.one_of(entry["speed"], SPEEDS),
        observation=entries.name(entry["observation"]),
        value=entries.number(entry["value"]),
        low=low,
        high=inf if isfinite(low) and not isfinite(high) else high,  # JSON has no infinity
        is_measured=bool(entry["is_measured"]),
    )
