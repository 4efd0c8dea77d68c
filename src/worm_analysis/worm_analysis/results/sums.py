"""`sums.parquet`: what a trial's numbers rest on, so that trials can be added up.

A row a sum and block of time: `name`, `block`, `values`. SI units; the number of items comes first.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from worm_analysis.results import entries
from worm_analysis.results.parquet_table import damage_reported
from worm_msgs_py.arrays import Floats
from worm_msgs_py.files.table_schema import NO_UNIT, PLAIN, column, table_schema

SCHEMA = table_schema(
    "What a trial's numbers rest on, so that trials add up: a row a sum and block of time.",
    [
        column("name", pa.string(), NO_UNIT, "Which sum: mostly the number that rests on it."),
        column("block", pa.int64(), PLAIN, "Number of the block of time, from 0; at most 64."),
        column(
            "values", pa.list_(pa.float64()), "SI",
            "Number of items, then sums of values, of squares …, or counts of a histogram.",
        ),
    ],
)  # fmt: skip


def write_sums(path: Path, sums: Mapping[str, Floats]) -> None:
    """Write the sums; the bytes depend on them alone.

    Parameters
    ----------
    sums : mapping of str to ndarray, each of shape (blocks, k)
        By name; one without blocks is left out.
    """
    rows = [(name, block, values) for name in sums for block, values in enumerate(sums[name])]
    names, blocks, values = ([row[column] for row in rows] for column in range(3))
    arrays = [pa.array(column, field.type) for column, field in
              zip((names, blocks, values), SCHEMA, strict=True)]  # fmt: skip
    pq.write_table(pa.table(arrays, schema=SCHEMA), path, compression="zstd")


def read_sums(path: Path) -> dict[str, Floats]:
    """Read the sums.

    Raises
    ------
    ReportError
        Where the file is missing (results of a version that did not save them) or damaged.
    """
    with damage_reported(path):
        return _by_name(pq.read_table(path, schema=SCHEMA))


def _by_name(table: Any) -> dict[str, Floats]:
    """Return the sums; ValueError where they are none."""
    names = [entries.name(name) for name in table.column("name").to_pylist()]
    lists = table.column("values").combine_chunks()
    flat, ends = lists.values.to_numpy(zero_copy_only=False), lists.offsets.to_numpy()
    if lists.null_count or not np.isfinite(flat).all():
        raise ValueError("holds what is no sum")
    found: dict[str, list[Floats]] = {}
    for row, name in enumerate(names):
        found.setdefault(name, []).append(flat[ends[row] : ends[row + 1]])
    return {name: np.array(rows) for name, rows in found.items()}
