"""Results that cannot be reported are refused in one line that says what to do."""

import json
import shutil

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from report_trial import record, states

from worm_analysis.report import write_report
from worm_analysis.results import contacts, passages, read_results, sums, tracks
from worm_msgs_py.errors import ReportError

FILES = ["tracks.parquet", "contacts.parquet", "passages.parquet", "summary.json"]


@pytest.fixture
def results(tmp_path):
    return record(tmp_path / "trial", states()[:60])


def refused(results, named):
    """Return the message; nothing is written that looks like a report."""
    with pytest.raises(ReportError) as caught:
        write_report(results)
    message = str(caught.value)
    assert "\n" not in message
    assert str(named) in message
    assert "worm replay" in message
    assert not list(results.glob("report*"))
    return message


def test_no_such_directory(tmp_path):
    refused(tmp_path / "nothing", tmp_path / "nothing")


@pytest.mark.parametrize("name", FILES)
def test_missing_file(results, name):
    (results / name).unlink()
    assert "not there" in refused(results, results / name)


@pytest.mark.parametrize("name", FILES)
def test_damaged_file(results, name):
    path = results / name
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert "cannot be read" in refused(results, path)


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("tracks.parquet", "psi_b_deg"),
        ("contacts.parquet", "distance_mm"),
        ("passages.parquet", "record"),
    ],
)
def test_missing_column(results, name, column):
    path = results / name
    pq.write_table(pq.read_table(path).drop_columns([column]), path)
    assert f"has no column '{column}'" in refused(results, path)


@pytest.mark.parametrize("key", ["quantities", "geometry", "frames", "provenance"])
def test_summary_without_a_part(results, key):
    path = results / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8"))
    del summary[key]
    path.write_text(json.dumps(summary), encoding="utf-8")
    assert repr(key) in refused(results, path)


@pytest.mark.parametrize(
    "change",
    [
        pytest.param({"quantities": {"d_c": 3}}, id="a number without its interval"),
        pytest.param({"quantities": {"d_c": {"low": 1}}}, id="a quantity without a value"),
        pytest.param({"geometry": {"chamber_a": {"radius_px": 3}}}, id="half a chamber"),
        pytest.param({"correlation": {"lag_s": [1, 2], "c": [1]}}, id="lags without values"),
        pytest.param({"model": {"parameters": [1]}}, id="a model without quantities"),
    ],
)
def test_summary_of_another_kind(results, change):
    path = results / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8")) | change
    path.write_text(json.dumps(summary), encoding="utf-8")
    assert "not a summary of this version" in refused(results, path)


@pytest.mark.parametrize("complete", [False, None])
def test_results_that_are_not_whole(results, complete):
    path = results / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8")) | {"complete": complete}
    path.write_text(json.dumps(summary), encoding="utf-8")
    assert "not complete" in refused(results, path)


@pytest.mark.parametrize(
    ("name", "schema"),
    [
        ("tracks.parquet", tracks.SCHEMA),
        ("contacts.parquet", contacts.SCHEMA),
        ("passages.parquet", passages.SCHEMA),
        ("sums.parquet", sums.SCHEMA),
    ],
)
def test_a_table_says_what_its_columns_are(results, name, schema):
    written = pq.read_schema(results / name)
    assert written.equals(schema)
    assert written.metadata == schema.metadata
    assert [column.metadata for column in written] == [column.metadata for column in schema]


def test_contact_is_true_false_or_null_and_is_read_as_1_0_or_nan(results):
    path = results / "tracks.parquet"
    table = pq.read_table(path)
    told = [True, False, None] * (table.num_rows // 3)
    place = table.schema.get_field_index("contact")
    table = table.slice(0, len(told)).set_column(
        place, tracks.SCHEMA.field("contact"), pa.array(told, pa.bool_())
    )
    pq.write_table(table, path)
    read = read_results(results).tracks["contact"]
    np.testing.assert_array_equal(read, [1.0, 0.0, np.nan] * (len(told) // 3))


def test_results_whose_tables_say_nothing_of_themselves_give_the_same_report(results, tmp_path):
    """So they were written by earlier versions: only names and types of columns are relied on."""
    write_report(results)
    old = tmp_path / "old"
    shutil.copytree(results, old)
    for path in old.glob("*.parquet"):
        table = pq.read_table(path)
        bare = pa.schema([(field.name, field.type) for field in table.schema])
        pq.write_table(table.cast(bare), path)
        assert pq.read_schema(path).field(0).metadata is None
    write_report(old)
    assert (old / "report.html").read_bytes() == (results / "report.html").read_bytes()
