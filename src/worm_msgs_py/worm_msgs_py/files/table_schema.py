"""Schemas of Parquet tables that explain themselves: each column has a unit and a description."""

import json
from collections.abc import Iterable

import pyarrow as pa

NO_UNIT = ""
"""Words, and what is true or false."""
PLAIN = "1"
"""A plain number."""


def column(name: str, kind: pa.DataType, unit: str, description: str) -> pa.Field:
    """Return a column with what it holds in its metadata.

    Parameters
    ----------
    name : str
    kind : pyarrow.DataType
    unit : str
        As written for people: ``mm``, ``px``, ``rad/s``; `PLAIN` or `NO_UNIT`.
    description : str
        A sentence.
    """
    return pa.field(name, kind, metadata={"unit": unit, "description": description})


def table_schema(description: str, columns: Iterable[pa.Field]) -> pa.Schema:
    """Return the schema of a table.

    What is true, false or not known is read by pandas as its nullable ``boolean``, not as a column
    of objects: its own entry in the metadata says so. Other readers pass over it.

    Parameters
    ----------
    description : str
        What a row is.
    columns : iterable of pyarrow.Field
        As `column` makes them.
    """
    fields = list(columns)
    flags = [
        {"name": field.name, "field_name": field.name, "pandas_type": "bool",
         "numpy_type": "boolean", "metadata": None}
        for field in fields
        if pa.types.is_boolean(field.type)
    ]  # fmt: skip
    for_pandas = {"index_columns": [], "column_indexes": [], "columns": flags}
    return pa.schema(
        fields,
        metadata={"description": description, "pandas": json.dumps(for_pandas)},
    )
