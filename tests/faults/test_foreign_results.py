"""Results that others wrote are read with care: refused in one line, or shown as text."""

import json
import re
import shutil
from functools import cache

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from report_trial import record, states, telegraph_walk

from worm_analysis.report import write_report
from worm_analysis.results import read_results, results
from worm_analysis.results.parquet_table import read_table
from worm_analysis.results.sums import read_sums
from worm_msgs_py.errors import ReportError

MARKUP = "<script>alert(1)</script>"
NASTY = [
    MARKUP,
    r"$\frac{",
    "\x1b[2J",
    "\udcff",
    "a\nb",
    [],
    {},
    [[1]],
    -1,
    1e300,
    True,
    "9" * 3000,
]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    comparison, correlation = telegraph_walk(0.05)
    directory = tmp_path_factory.mktemp("results") / "trial"
    return record(directory, states()[:60], comparison=comparison, model_correlation=correlation)


@pytest.fixture
def trial(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "trial")


def summary_of(trial):
    return json.loads((trial / "summary.json").read_text(encoding="utf-8"))


def put(trial, summary):
    (trial / "summary.json").write_text(json.dumps(summary), encoding="utf-8")


def places(entry, path=()):
    """Yield the way to every entry of a document; of a list, to its first."""
    items = entry.items() if isinstance(entry, dict) else enumerate(entry[:1])
    for key, part in items:
        yield (*path, key)
        if isinstance(part, dict | list):
            yield from places(part, (*path, key))


def changed(summary, path, value):
    document = json.loads(json.dumps(summary))
    part = document
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return document


@pytest.fixture
def tables_read_once(monkeypatch):
    """Let what no test changes, the tables beside a summary, be read once and not 2700 times."""
    monkeypatch.setattr(results, "read_sums", cache(read_sums))
    once = cache(read_table)
    monkeypatch.setattr(results, "read_table", lambda path, names: once(path, tuple(names)))


def test_whatever_stands_in_a_summary_it_is_read_or_refused_in_one_line(trial, tables_read_once):
    summary = summary_of(trial)
    ways = list(places(summary))
    assert len(ways) > 150
    refused = []
    for number, path in enumerate(ways):
        for value in NASTY[number % 3 :: 3]:
            put(trial, changed(summary, path, value))
            try:
                read_results(trial)
            except ReportError as error:
                refused.append(str(error))
    assert len(refused) > 150
    assert all("\n" not in line and str(trial) in line for line in refused)


def test_names_of_a_walks_parameters_are_no_markup(trial):
    summary = summary_of(trial)
    summary["model"]["parameters"] = {MARKUP: 1.0, **summary["model"]["parameters"]}
    put(trial, summary)
    with pytest.raises(ReportError, match="is no name"):
        write_report(trial)


@pytest.mark.parametrize("text", [MARKUP + "\x1b[2J\x07\u202e[/x]", r"$\frac{$ & \"" + "\udcff"])
def test_text_of_others_is_text_in_the_page(trial, text):
    summary = summary_of(trial)
    source = {"bag": text, "sha256": text, text: text}
    node = {text: text, "nested": {text: [text]}}
    summary["provenance"] = {
        "software": text, "version": text, "source": source, "parameters": {text: node}
    }  # fmt: skip
    for quantity in summary["quantities"].values():
        if quantity["value"] is None and "$" not in text:
            quantity["why"] = text
    put(trial, summary)
    page = write_report(trial).read_text(encoding="utf-8")
    assert "<script" not in page
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", page)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"complete": NaN}', "holds NaN"),
        ('{"complete": 1e999}', "holds 1e999"),
        ("[" * 100_000, "nested too deeply"),
        (b"\xff\xfe", "utf-8"),
        ("[]", "lacks"),
    ],
)
def test_a_summary_that_is_no_json_of_ours_is_refused(trial, text, said):
    raw = text if isinstance(text, bytes) else text.encode()
    (trial / "summary.json").write_bytes(raw)
    with pytest.raises(ReportError, match=said):
        read_results(trial)


def test_a_summary_of_many_megabytes_is_not_read(trial):
    with (trial / "summary.json").open("wb") as stream:
        stream.truncate(1 << 33)  # a file with a hole: no disk is used
    with pytest.raises(ReportError, match="larger than 64 MB"):
        read_results(trial)


@pytest.mark.parametrize(
    ("column", "values"),
    [
        ("where", lambda n: [MARKUP] * n),
        ("status", lambda n: ["$x"] * n),
        ("head_x_mm", lambda n: [np.inf] * n),
        ("head_x_mm", lambda n: ["9"] * n),
        ("head_x_mm", lambda n: [[1.0]] * n),
        ("stamp_ns", lambda n: [None] * n),
        ("stamp_ns", lambda n: np.linspace(0.0, 1.0, n)),
    ],
)
def test_a_column_of_another_kind_is_refused(trial, column, values):
    path = trial / "tracks.parquet"
    table = pq.read_table(path)
    place = table.column_names.index(column)
    other = pa.array(values(table.num_rows))
    pq.write_table(table.set_column(place, column, other), path)
    with pytest.raises(ReportError, match=r"tracks\.parquet") as refused:
        read_results(trial)
    assert "\n" not in str(refused.value)
