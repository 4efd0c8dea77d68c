"""Tables explain themselves: the files have units and descriptions, and the page says the same."""

import importlib.util
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

DOCS = Path(__file__).parents[1] / "docs"
SPEC = importlib.util.spec_from_file_location("dictionary", DOCS / "make_data_dictionary.py")
DICTIONARY = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(DICTIONARY)

UNITS = {"_ns": "ns", "_px": "px", "_mm": "mm", "_deg": "deg", "_rad": "rad", "_rad_s": "rad/s",
         "_mm_s": "mm/s", "_h_s": "s"}  # fmt: skip
COLUMNS = [
    pytest.param(column, id=f"{table}-{column.name}")
    for table, schema in DICTIONARY.TABLES.items()
    for column in schema
]


def test_the_page_is_what_the_tables_say():
    page = (DOCS / "data_dictionary.md").read_text(encoding="utf-8")
    assert page == DICTIONARY.data_dictionary(), "run python docs/make_data_dictionary.py"


@pytest.mark.parametrize("column", COLUMNS)
def test_a_column_has_a_sentence_and_the_unit_that_its_name_ends_in(column):
    unit, told = (column.metadata[key].decode() for key in (b"unit", b"description"))
    assert told.endswith(".")
    assert len(told) > 10
    endings = [ending for ending in UNITS if column.name.endswith(ending)]
    if endings:
        assert unit == UNITS[max(endings, key=len)]
    elif pa.types.is_string(column.type) or pa.types.is_boolean(column.type):
        assert unit == ""
    else:
        assert unit in ("1", "SI")


def test_what_is_true_false_or_unknown_is_a_boolean_that_may_be_null():
    for name in ("tracks.parquet", "BAG_truth.parquet"):
        contact = DICTIONARY.TABLES[name].field("contact")
        assert contact.type == pa.bool_()
        assert contact.nullable


def test_the_example_truth_says_what_its_columns_are():
    told = pq.read_schema(DOCS.parent / "bags" / "larva_truth.parquet")
    written_now = DICTIONARY.TABLES["BAG_truth.parquet"]
    assert told.equals(written_now)
    for column in told:
        assert column.metadata[b"unit"] == written_now.field(column.name).metadata[b"unit"]
        assert column.metadata[b"description"]
