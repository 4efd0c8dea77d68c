"""Reads a table of tracks made by any tracker, CSV or Parquet, some ten thousand rows at a time."""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_bringup.tracks.track_units import refuse_wrong_units
from worm_msgs_py import Status, Where
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S

WHOLE = ("stamp_ns", "frame")
TEXT = ("where", "status")
MIDLINE = ("midline_u_px", "midline_v_px", "midline_width_px")
REAL = (
    "time_s",
    "confidence",
    "head_certainty",
    "head_sd_mm",
    *(f"{point}_{axis}_px" for point in KEYPOINTS for axis in "uv"),
    *(f"{point}_{axis}_mm" for point in KEYPOINTS for axis in "xy"),
    *(f"{point}_yaw_deg" for point in KEYPOINTS),
    "length_mm",
    "width_mm",
    "length_px",
    "width_px",
)
PARQUET, CSV = (".parquet", ".pq"), (".csv", ".tsv", ".txt")
BATCH_ROWS = 1 << 16
CSV_BLOCK_BYTES = 1 << 22
_CONVERSION = re.compile(
    r"In CSV column #(\d+):(?: Row #(\d+):)? CSV conversion error to (\w+): invalid value '(.*)'"
)
_LABELS = {
    "where": {member.label: int(member) for member in Where},
    "status": {member.label: int(member) for member in Status},
}


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """Some rows of a table, in its own coordinates.

    Attributes
    ----------
    first : int
        Number of the first of them, from 0.
    stamp_ns : ndarray of int64, shape (n,)
        Ascending.
    frame : ndarray of int64, shape (n,)
        The table's, or else the number of the row.
    where, status : ndarray of int64 or None
        Values of `Where` and `Status`; None where the table does not say.
    values : dict of ndarray, shape (n,)
        The numbers that the table has, by column; NaN for an empty cell.
    midline : pyarrow.Table or None
        The midline's columns, as they are.
    """

    first: int
    stamp_ns: NDArray[np.int64]
    frame: NDArray[np.int64]
    where: NDArray[np.int64] | None
    status: NDArray[np.int64] | None
    values: dict[str, Floats]
    midline: Any = None

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def column(self, name: str) -> Floats:
        """Return a column; NaN where the table has none."""
        found = self.values.get(name)
        return np.full(len(self), np.nan) if found is None else found


class TrackTable:
    """A table of tracks: its columns at once, its rows as they are asked for.

    Parameters
    ----------
    path : Path
        A CSV file (comma, semicolon or tab; a header; points in numbers) or a Parquet file.
    in_pixels : bool or None
        Whether the head is wanted in pixels, `head_u_px` and `head_v_px`, rather than in
        millimetres; None: only where the table has no millimetres.

    Raises
    ------
    BadInput
        No such file, an unknown type, a damaged file, or a column that is missing. Reading the
        rows raises it for text among numbers, unknown words, stamps that do not grow, no rows.
    """

    def __init__(self, path: Path, *, in_pixels: bool | None = False):
        self.path = path
        if not path.is_file():
            raise BadInput(f"{path}: no such table of tracks: name a .csv or .parquet file")
        if path.suffix.lower() not in (*PARQUET, *CSV):
            raise BadInput(
                f"{path}: is neither CSV nor Parquet by its name: write the tracks to a .csv or "
                ".parquet file"
            )
        self._is_parquet = path.suffix.lower() in PARQUET
        self._delimiter = ","
        names = self._names()
        self.columns = frozenset(names) & {*WHOLE, *TEXT, *REAL, *(MIDLINE if self._lists else ())}
        self._order = [name for name in names if name in self.columns]
        if len(self._order) != len(self.columns):
            twice = next(name for name in self._order if self._order.count(name) > 1)
            raise BadInput(f"{path}: has the column {twice!r} twice: leave one out")
        if in_pixels is None:
            in_pixels = "head_x_mm" not in self.columns and "head_u_px" in self.columns
        self.in_pixels = in_pixels
        self._require(in_pixels)

    @property
    def _lists(self) -> bool:
        return self._is_parquet

    @property
    def _time_column(self) -> str:
        return "stamp_ns" if "stamp_ns" in self.columns else "time_s"

    def has_point(self, point: str) -> bool:
        """Whether there are columns for a point of the body, in millimetres or in pixels."""
        return any({f"{point}_{a}", f"{point}_{b}"} <= self.columns for a, b in _PAIRS)

    def rows(self) -> Iterator[Rows]:
        """Yield all rows in order, at most some ten thousand at a time."""
        first, last_ns = 0, None
        for table in self._tables():
            if not table.num_rows:
                continue
            rows = self._to_rows(table, first)
            last_ns = self._check_stamps(rows, last_ns)
            if first == 0:
                refuse_wrong_units(self.path, self._time_column, rows.stamp_ns, rows.values)
            first += len(rows)
            yield rows
        if first == 0:
            raise BadInput(f"{self.path}: holds no rows: write one row for each frame")

    def _names(self) -> list[str]:
        try:
            if self._is_parquet:
                return list(pq.read_schema(self.path).names)
            with self.path.open(encoding="utf-8-sig", newline="") as stream:
                header = stream.readline()
        except (OSError, ValueError, pa.ArrowException) as error:
            raise BadInput(
                f"{self.path}: cannot be read ({_first_line(error)}): write the table again"
            ) from None
        if not header.strip():
            raise BadInput(f"{self.path}: is empty: write a header and one row for each frame")
        self._delimiter = max(",;\t", key=header.count)
        return [name.strip() for name in next(csv.reader([header], delimiter=self._delimiter))]

    def _require(self, in_pixels: bool) -> None:
        unit = ("u_px", "v_px") if in_pixels else ("x_mm", "y_mm")
        missing = [f"head_{axis}" for axis in unit if f"head_{axis}" not in self.columns]
        if not {"stamp_ns", "time_s"} & self.columns:
            missing.insert(0, "stamp_ns or time_s")
        if not missing:
            return
        remedy = "name the columns so"
        if not in_pixels and {"head_u_px", "head_v_px"} <= self.columns:
            remedy = "or give --circle-px U V RADIUS, for a head in pixels"
        raise BadInput(f"{self.path}: has no column {' and no column '.join(missing)}: {remedy}")

    def _tables(self) -> Iterator[Any]:
        try:
            if self._is_parquet:
                file = pq.ParquetFile(self.path)
                for batch in file.iter_batches(BATCH_ROWS, columns=self._order):
                    yield pa.table(batch)
                return
            yield from self._csv_tables()
        except pa.ArrowException as error:
            raise BadInput(f"{self.path}: {self._explain(str(error))}") from None
        except OSError as error:
            raise BadInput(
                f"{self.path}: cannot be read ({_first_line(error)}): write the table again"
            ) from None

    def _csv_tables(self) -> Iterator[Any]:
        types = {name: pa.float64() for name in REAL}
        types |= {name: pa.int64() for name in WHOLE} | {name: pa.string() for name in TEXT}
        reader = pa_csv.open_csv(
            self.path,
            read_options=pa_csv.ReadOptions(block_size=CSV_BLOCK_BYTES, use_threads=False),
            parse_options=pa_csv.ParseOptions(delimiter=self._delimiter),
            convert_options=pa_csv.ConvertOptions(column_types=types, strings_can_be_null=True),
        )
        with reader:
            for batch in reader:
                table = pa.table(batch)
                table = table.rename_columns([name.strip() for name in table.column_names])
                yield table.select(self._order)

    def _explain(self, message: str) -> str:
        found = _CONVERSION.search(message)
        if found is None:
            return f"cannot be read ({_first_line(message)}): write the table again"
        column, row, _, text = found.groups()
        name = self._names()[int(column)]
        line = f" in line {row}" if row else ""
        kind = "a whole number" if name in WHOLE else "a number"
        remedy = "leave the cell empty where there is none"
        return f"column {name!r} holds {text!r}{line}, which is not {kind}: {remedy}"

    def _to_rows(self, table: Any, first: int) -> Rows:
        values = {name: self._numbers(table, name, first) for name in REAL if name in self.columns}
        if "stamp_ns" in self.columns:
            stamp_ns = self._whole(table, "stamp_ns", first)
        else:
            stamp_ns = self._from_seconds(values.pop("time_s"), first)
        frame = (
            self._whole(table, "frame", first)
            if "frame" in self.columns
            else np.arange(first, first + len(stamp_ns))
        )
        codes = {name: self._codes(table, name, first) for name in TEXT if name in self.columns}
        lists = [name for name in MIDLINE if name in self.columns]
        return Rows(
            first,
            stamp_ns,
            frame,
            codes.get("where"),
            codes.get("status"),
            values,
            table.select(lists) if lists else None,
        )

    def _numbers(self, table: Any, name: str, first: int) -> Floats:
        values = self._cast(table, name, pa.float64()).to_numpy()
        if np.isinf(values).any():
            row = first + int(np.argmax(np.isinf(values))) + 1
            raise BadInput(
                f"{self.path}: column {name!r} holds an infinite number in row {row}: leave the "
                "cell empty where there is none"
            )
        return np.asarray(values, dtype=np.float64)

    def _whole(self, table: Any, name: str, first: int) -> NDArray[np.int64]:
        column = self._cast(table, name, pa.int64())
        if column.null_count:
            row = first + int(np.argmax(column.is_null().to_numpy())) + 1
            raise BadInput(
                f"{self.path}: column {name!r} is empty in row {row}: give every row one"
            )
        return np.asarray(column.to_numpy(), dtype=np.int64)

    def _from_seconds(self, time_s: Floats, first: int) -> NDArray[np.int64]:
        unknown = ~np.isfinite(time_s)
        if unknown.any():
            row = first + int(np.argmax(unknown)) + 1
            raise BadInput(
                f"{self.path}: column 'time_s' is empty in row {row}: give every row one"
            )
        return np.rint(time_s * NS_PER_S).astype(np.int64)

    def _cast(self, table: Any, name: str, kind: Any) -> Any:
        column = table.column(name)
        if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
            raise BadInput(f"{self.path}: column {name!r} holds text: write numbers")
        try:
            return column.cast(kind)
        except pa.ArrowException:
            raise BadInput(
                f"{self.path}: column {name!r} is of type {column.type}: write numbers"
            ) from None

    def _codes(self, table: Any, name: str, first: int) -> NDArray[np.int64]:
        """Return the values of the words in a column; an empty cell is the first of them all."""
        known = _LABELS[name]
        column = table.column(name)
        try:
            words = column.cast(pa.string()).combine_chunks().dictionary_encode()
        except pa.ArrowException:
            raise BadInput(
                f"{self.path}: column {name!r} is of type {column.type}: write words"
            ) from None
        entries = words.dictionary.to_pylist()
        strange = [word for word in entries if word not in known]
        if strange:
            row = first + table.column(name).to_pylist().index(strange[0]) + 1
            raise BadInput(
                f"{self.path}: column {name!r} holds {strange[0]!r} in row {row}: known are "
                f"{', '.join(known)}"
            )
        codes = np.array([known[word] for word in entries] or [0], dtype=np.int64)
        index = words.indices.fill_null(0).to_numpy(zero_copy_only=False)
        given = words.is_valid().to_numpy(zero_copy_only=False)
        empty = int(Where.UNKNOWN) if name == "where" else int(Status.NO_WORM)
        return np.where(given, codes[index], empty)

    def _check_stamps(self, rows: Rows, last_ns: int | None) -> int:
        stamps = rows.stamp_ns if last_ns is None else np.r_[last_ns, rows.stamp_ns]
        stuck = np.flatnonzero(np.diff(stamps) <= 0)
        if len(stuck):
            row = rows.first + int(stuck[0]) + (2 if last_ns is None else 1)
            same = stamps[stuck[0]] == stamps[stuck[0] + 1]
            name = self._time_column
            what = "repeats the stamp of the row before" if same else "goes back in time"
            remedy = "keep one row for each frame" if same else "sort the rows by time"
            raise BadInput(f"{self.path}: column {name!r} {what} in row {row}: {remedy}")
        return int(rows.stamp_ns[-1])


_PAIRS = (("x_mm", "y_mm"), ("u_px", "v_px"))


def _first_line(error: object) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
