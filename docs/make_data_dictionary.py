"""Write docs/data_dictionary.md: every column of every table, from what the tables say themselves.

python docs/make_data_dictionary.py
"""

from pathlib import Path

import pyarrow as pa

from worm_analysis.results import contacts, passages, sums, tracks
from worm_model.simulator.rig import truth

TABLES = {
    "tracks.parquet": tracks.SCHEMA,
    "contacts.parquet": contacts.SCHEMA,
    "passages.parquet": passages.SCHEMA,
    "sums.parquet": sums.SCHEMA,
    "BAG_truth.parquet": truth.SCHEMA,
}
HEAD = """# Data dictionary

Every table that the `worm` command writes. `worm replay`, `worm live` and `worm analyse` write the
first four into OUT, `worm simulate` writes the truth beside its bag. The files say the same: each
column has `unit` and `description` in its Parquet field metadata, and each table has its
`description`:

```python
import pyarrow.parquet as pq

for column in pq.read_schema("bags/larva_truth.parquet"):
    told = {key.decode(): text.decode() for key, text in column.metadata.items()}
    print(column.name, column.type, told["unit"], told["description"])
```

Units: `1` is a plain number, – stands for words and for what is true or false. A `bool` may be
null, which is not false: it cannot be told. pandas reads these columns as its nullable `boolean`.
Symbols are those of [science.md](science.md). Results of earlier versions have no
descriptions, and may lack `head_sd_mm`; every command reads them all the same.

This page is made from the tables' schemas by `python docs/make_data_dictionary.py`.
"""


def data_dictionary() -> str:
    """Return the page."""
    return "\n".join([HEAD, *(_table(name, schema) for name, schema in TABLES.items())])


def _table(name: str, schema: pa.Schema) -> str:
    rows = [
        f"| `{field.name}` | {_kind(field.type)} | {_told(field, 'unit') or '–'} "
        f"| {_told(field, 'description')} |"
        for field in schema
    ]
    head = [f"## {name}", "", _told(schema, "description"), ""]
    return "\n".join(
        [*head, "| column | type | unit | what it holds |", "|---|---|---|---|", *rows, ""]
    )


def _kind(kind: pa.DataType) -> str:
    if pa.types.is_list(kind):
        return f"list of {_kind(kind.value_type)}"
    return {"double": "float64", "float": "float32"}.get(str(kind), str(kind))


def _told(what: pa.Field | pa.Schema, key: str) -> str:
    """Return an entry of the metadata; a bar would end the cell of the page's table."""
    return str(what.metadata[key.encode()].decode()).replace("|", "\\|")


if __name__ == "__main__":
    Path(__file__).with_name("data_dictionary.md").write_text(data_dictionary(), encoding="utf-8")
