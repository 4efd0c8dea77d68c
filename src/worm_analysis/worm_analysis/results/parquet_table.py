"""Parquet tables: rows written as they come in bounded memory, columns read as arrays."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_analysis.results import entries
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.files.record_file import RecordFile

WORDS = ("where", "status", "chamber", "kind", "record", "stroke_phase")
STAMPS = ("stamp_ns", "start_ns", "end_ns")

Row = Mapping[str, Any]
Columns = Mapping[str, NDArray[Any]]


class TableWriter:
    """Writes rows as they come, a row group at a time: memory stays bounded over any trial.

    Rows wait as Arrow batches until a row group is full: batches are small since a row as a dict
    takes ten times the memory, row groups are large since Parquet keeps 36 KiB of metadata for
    each until the end. The bytes depend on the rows alone.
    """

    _BATCH_ROWS = 256
    _GROUP_ROWS = 8 * _BATCH_ROWS

    def __init__(self, path: Path, schema: pa.Schema):
        self._schema = schema
        self._rows: list[Row] = []
        self._batches: list[pa.RecordBatch] = []
        self._file = RecordFile(path)
        self._writer = table_writer(self._file, schema)
        self._file.commit()

    @property
    def waiting(self) -> bool:
        """Whether rows are not on the disk because it is full: make room, and `commit`."""
        return self._file.waiting > 0

    def append(self, row: Row) -> None:
        """Add a row; columns that it lacks are null."""
        self._rows.append(row)
        if len(self._rows) >= self._BATCH_ROWS:
            self._batch()
        if len(self._batches) * self._BATCH_ROWS >= self._GROUP_ROWS:
            self._write()
            with suppress(OSError):  # it is tried again
                self._file.commit()

    def commit(self) -> None:
        """Put what waits onto the disk; OSError where it does not fit."""
        self._file.commit()

    def close(self) -> None:
        """Write what is left and the footer; OSError where they do not fit: try again."""
        if self._file.closed:
            return
        self._batch()
        self._write()
        self._writer.close()
        self._file.commit()
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType
    ) -> None:
        self.close()

    def _batch(self) -> None:
        columns = {name: [row.get(name) for row in self._rows] for name in self._schema.names}
        self._batches.append(pa.RecordBatch.from_pydict(columns, schema=self._schema))
        self._rows.clear()

    def _write(self) -> None:
        group = pa.Table.from_batches(self._batches, schema=self._schema)
        if group.num_rows:
            self._writer.write_table(group.combine_chunks())
        self._batches.clear()


def table_writer(where: Any, schema: pa.Schema, *, compression_level: int = 1) -> pq.ParquetWriter:
    """Return a writer into a file or path that makes the same bytes of the same rows.

    Only words are written by a dictionary: numbers that hardly repeat take more room by one, and
    tens of MiB of memory while it is made. Nothing is lost by the encodings: whole numbers are
    written as steps, and of the others all first bytes come first, then all second ones, and so on,
    as they repeat from row to row and the last ones do not. A higher level takes longer, and less
    room where values are rounded.
    """
    words = [field.name for field in schema if pa.types.is_string(field.type)]
    return pq.ParquetWriter(
        where,
        schema,
        compression="zstd",
        compression_level=compression_level,
        use_dictionary=words,
        column_encoding={
            field.name: "DELTA_BINARY_PACKED"
            if pa.types.is_integer(field.type)
            else "BYTE_STREAM_SPLIT"
            for field in schema
            if pa.types.is_integer(field.type) or pa.types.is_floating(field.type)
        },
    )


def read_table(path: Path, columns: Iterable[str]) -> Columns:
    """Read columns: numbers as float64 with NaN for null (without nulls int64), words as str.

    Raises
    ------
    ReportError
        Where the file is missing or damaged, lacks a column, or one holds something else.
    """
    wanted = list(columns)
    with damage_reported(path):
        known = set(pq.read_schema(path).names)
        missing = [name for name in wanted if name not in known]
        if missing:
            raise ReportError(f"{path}: has no column {', '.join(map(repr, missing))}: {RUN_AGAIN}")
        table = pq.read_table(path, columns=wanted)
        return {name: _to_numpy(name, table.column(name)) for name in wanted}


@contextmanager
def damage_reported(path: Path) -> Iterator[None]:
    """Let whatever is wrong with a Parquet file be a ReportError that names it."""
    try:
        yield
    except FileNotFoundError:
        raise ReportError(f"{path}: not there: {RUN_AGAIN}") from None
    except (OSError, pa.ArrowException) as error:
        raise ReportError(f"{path}: cannot be read as Parquet ({error}): {RUN_AGAIN}") from error
    except ReportError:
        raise
    except ValueError as error:
        raise ReportError(f"{path}: {error}: {RUN_AGAIN}") from None


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
    if not name.endswith("_ns") and (np.abs(values) > entries.LARGEST_NUMBER).any():
        raise ValueError(f"column {name!r} holds a number beyond all measure")
    return values
