"""Results that cannot be reported are refused in one line that says what to do."""

import json

import pyarrow.parquet as pq
import pytest
from report_trial import record, states

from worm_analysis.report import write_report
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
