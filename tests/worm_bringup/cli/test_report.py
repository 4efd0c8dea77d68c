"""`worm report` pools trials into one page, figures and tables; bad trials are named."""

import csv
import json
import re
import shutil
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest
from escaped_trials import escaped_trial
from escaping_worm import Worm

from worm_analysis.report.symbols import html_symbol
from worm_bringup.cli.app import main

pytestmark = pytest.mark.xdist_group("pooled report")  # what they share is made once

FIGURES = [
    "fig-1d", "fig-1e", "fig-2", "fig-3", "fig-4a", "fig-4b", "fig-4c", "fig-5", "fig-6a",
    "fig-6b", "fig-7a", "fig-7b", "fig-8", "fig-9",
]  # fmt: skip


def run(monkeypatch, capsys, *arguments):
    """Run `worm report`; return exit status and what it printed on stderr."""
    monkeypatch.setattr(sys, "argv", ["worm", "report", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code or 0, capsys.readouterr().err


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trials")
    return [
        escaped_trial(folder / f"w{width:g}-{k}", Worm(exit_width_mm=width, seed=50 + k), 700.0)
        for k, width in enumerate((1.0, 1.0, 3.0))
    ]


@pytest.fixture(scope="module")
def pooled(trials, tmp_path_factory):
    out = tmp_path_factory.mktemp("pooled") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["worm", "report", *map(str, trials), "--out", str(out)])
        with pytest.raises(SystemExit) as ended:
            main()
    assert not ended.value.code
    return out


@pytest.fixture(scope="module")
def page(pooled):
    return (pooled / "report.html").read_text(encoding="utf-8")


def figure(page, key):
    (found,) = re.findall(rf'<figure id="{key}".*?</figure>', page, flags=re.DOTALL)
    return found


@pytest.mark.parametrize("key", FIGURES)
def test_every_figure_of_the_paper_is_in_the_page_or_says_why_not(page, key):
    found = figure(page, key)
    assert "<svg" in found or "not enough data" in found
    assert re.search(r"n\u00a0=\u00a03 trials|n\u00a0=\u00a0[\d\u2009]+ frames", found)


def test_figures_come_in_the_papers_order(page):
    assert re.findall(r'<figure id="(fig-\d\w?)"', page) == FIGURES


def test_the_page_needs_no_network_and_every_reference_is_resolved(page):
    assert "http:" not in page
    assert "https:" not in page
    assert not re.search(r"<(script|link|img|iframe|object|base)\b", page)
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r'href="#([^"]+)"', page)) <= set(ids)


def test_each_drawn_figure_is_there_as_svg_and_pdf_with_its_sources(pooled, page):
    drawn = {key for key in FIGURES if "<svg" in figure(page, key)}
    assert len(drawn) >= 12
    others = {f"fig-joint-W{width}" for width in (1, 3)} | {"fig-sensitivity"}
    assert all("<svg" in figure(page, key) for key in others)
    names = {item.name for item in (pooled / "figures").iterdir()}
    assert names == {f"{key}.{kind}" for key in drawn | others for kind in ("svg", "pdf")}
    for key in drawn:
        svg = (pooled / "figures" / f"{key}.svg").read_text(encoding="utf-8")
        assert ET.fromstring(svg).tag.endswith("svg")
        assert "w1-0.parquet (SHA-256 " in svg
        assert (pooled / "figures" / f"{key}.pdf").read_bytes().startswith(b"%PDF")


def test_each_drawn_figure_has_its_tables(pooled, page):
    names = [item.name for item in (pooled / "tables").iterdir()]
    for key in FIGURES:
        if "<svg" in figure(page, key):
            assert any(re.fullmatch(rf"{key}(-.*)?\.csv", name) for name in names), key


def rows(path):
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_tables_and_summary_say_the_same(pooled):
    summary = json.loads((pooled / "summary.json").read_text(encoding="utf-8"))
    told = {(row["W_mm"], row["quantity"]): row for row in rows(pooled / "tables" / "numbers.csv")}
    assert set(summary["by_width"]) == {"1", "3"}
    for width, quantities in {"all": summary["quantities"], **summary["by_width"]}.items():
        for name, quantity in quantities.items():
            row = told[width, name]
            assert int(row["n"]) == quantity["n"]
            if quantity["value"] is None:
                assert row["value"] == ""
                assert row["why"] == quantity["why"] != ""
            else:
                assert float(row["value"]) == quantity["value"]
    success = {row["W_mm"]: float(row["value"]) for row in rows(pooled / "tables" / "fig-8.csv")}
    assert success == {
        width: quantities["success"]["value"] for width, quantities in summary["by_width"].items()
    }


def test_provenance_names_each_trial_its_hash_and_every_parameter(pooled, trials, page):
    summary = json.loads((pooled / "summary.json").read_text(encoding="utf-8"))
    told = summary["provenance"]["trials"]
    for trial, entry in zip(trials, told, strict=True):
        own = json.loads((trial / "summary.json").read_text(encoding="utf-8"))["provenance"]
        assert entry["source"] == own["source"]
        assert entry["parameters"] == own["parameters"]
        assert own["source"]["sha256"][:16] in page
    assert [walk["parameters_of"] for walk in summary["walks"]] == ["this data", "the paper"]
    assert summary["walks"][1]["reversal"] == 0.45
    assert summary["walks"][0]["mean_slide_mm"] == summary["quantities"]["d_c"]["value"]


def test_the_walk_of_the_paper_takes_longer_to_find_a_narrower_exit(pooled):
    curve = rows(pooled / "tables" / "fig-6a-walk-of-the-paper.csv")
    tau = [float(row["value"]) for row in curve]
    skips = [float(row["value"]) for row in rows(pooled / "tables/fig-6b-walk-of-the-paper.csv")]
    assert all(a >= b for a, b in pairwise(tau))
    assert all(a >= b for a, b in pairwise(skips))
    assert all(float(row["low"]) < float(row["value"]) < float(row["high"]) for row in curve)


def test_a_pool_opens_with_five_numbers_their_verdicts_and_the_joint_question(pooled, page):
    glance = page[: page.index(">Figures<")]
    summary = json.loads((pooled / "summary.json").read_text(encoding="utf-8"))["quantities"]
    for name in ("d_c", "d_nc", "v_w", "t_per", "success"):
        found = summary[name]
        inside = found["low"] <= found["paper"] <= found["high"]
        (row,) = [row for row in re.findall(r"<tr>.*?</tr>", glance) if html_symbol(name) in row]
        assert ("agrees with the paper" in row) == inside
    for width in ("1", "3"):
        assert f"One boundary walk and <i>W</i> = {width} mm: reversals per cycle at" in glance


def test_what_happened_to_a_trial_is_told_by_its_pool_too(trials, tmp_path, monkeypatch, capsys):
    gappy = tmp_path / "gappy"
    shutil.copytree(trials[1], gappy)
    summary = json.loads((gappy / "summary.json").read_text())
    event = {"kind": "missing_rows", "frame": 7, "stamp_ns": 1, "duration_s": 0.0, "count": 5}
    summary["source_events"] = [event | {"why": "about 5 rows are missing from the table"}]
    (gappy / "summary.json").write_text(json.dumps(summary))
    assert run(monkeypatch, capsys, trials[0], gappy, "--out", tmp_path / "out")[0] == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<li>w1-1.parquet: about 5 rows are missing from the table</li>" in page


def test_numbers_that_a_pool_has_not_are_counted(pooled, page):
    summary = json.loads((pooled / "summary.json").read_text(encoding="utf-8"))
    own = {name: entry for name, entry in summary["quantities"].items() if "_at_" not in name}
    missing = sum(entry["value"] is None for entry in own.values())
    assert f"{missing} of {len(own)} numbers have no value" in page
    cells = [
        entry["value"] is None
        for numbers in summary["by_width"].values()
        for name, entry in numbers.items()
        if "_at_" not in name
    ]
    assert f"{sum(cells)} of {len(cells)} cells have no value (a dash)" in page


def test_no_raw_key_is_on_a_pools_page(page):
    text = re.sub(r"<style>.*?</style>|<svg.*?</svg>", " ", page, flags=re.DOTALL)
    spoken = re.findall(r'(?:aria-label|title)="([^"]*)"', page)
    said = " ".join([re.sub(r"<[^>]*>", " ", text), *spoken])
    assert re.findall(r"\b[a-z]+(?:_[a-z0-9.]+)+\b", said) == []


def test_c_theta_has_a_band_of_95_percent_intervals(pooled):
    curve = rows(pooled / "tables" / "fig-7a.csv")
    low, c, high = (
        [float(row[name] or "nan") for row in curve] for name in ("low", "C_theta", "high")
    )
    told = [(a, b, d) for a, b, d in zip(low, c, high, strict=True) if a == a]
    assert len(told) > len(curve) / 2
    assert all(a < b < d or a == b == d == 1.0 for a, b, d in told)


def test_one_trial_has_its_own_reports_content_too(trials, tmp_path, monkeypatch, capsys):
    status, _ = run(monkeypatch, capsys, trials[0], "--out", tmp_path / "one")
    assert status == 0
    page = (tmp_path / "one" / "report.html").read_text(encoding="utf-8")
    for key in ("fig-1c", "fig-model", "fig-status", "fig-8"):
        assert "<svg" in figure(page, key), key
    assert 'id="trial"' in page
    assert "visits of a chamber" in page


def test_without_out_each_trial_gets_its_own_report(trials, tmp_path, monkeypatch, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(trials[2], copy)
    status, _ = run(monkeypatch, capsys, copy)
    assert status == 0
    page = (copy / "report.html").read_text(encoding="utf-8")
    assert "<svg" in figure(page, "fig-4c")


def test_trials_that_cannot_be_pooled_are_all_named_and_nothing_is_written(
    trials, tmp_path, monkeypatch, capsys
):
    half = tmp_path / "half"
    shutil.copytree(trials[0], half)
    summary = json.loads((half / "summary.json").read_text(encoding="utf-8"))
    (half / "summary.json").write_text(json.dumps(summary | {"complete": False}))
    status, err = run(
        monkeypatch, capsys, trials[1], half, tmp_path / "gone", "--out", tmp_path / "out"
    )
    (line,) = [line for line in err.splitlines() if line.startswith("worm: ")]
    assert status == 2
    assert "2 of 3 trials cannot be pooled" in line
    assert f"{half}/summary.json: says that the results are not complete" in line
    assert f"{tmp_path / 'gone'}: no such results directory" in line
    assert not (tmp_path / "out").exists()


def test_the_same_trial_twice_is_refused(trials, tmp_path, monkeypatch, capsys):
    status, err = run(monkeypatch, capsys, trials[0], trials[0], "--out", tmp_path / "out")
    assert status == 2
    assert "is the same trial as" in err


def test_a_live_trial_which_has_no_bag_to_name_is_pooled_too(trials, tmp_path, monkeypatch, capsys):
    live = tmp_path / "live"
    shutil.copytree(trials[0], live)
    summary = json.loads((live / "summary.json").read_text())
    summary["provenance"]["source"] = {"camera": "http://camera"}
    (live / "summary.json").write_text(json.dumps(summary))
    assert run(monkeypatch, capsys, trials[1], live, "--out", tmp_path / "out")[0] == 0


def test_a_pooled_report_does_not_overwrite_a_trial(trials, monkeypatch, capsys):
    before = sorted(item.name for item in trials[1].iterdir())
    status, err = run(monkeypatch, capsys, trials[0], "--out", trials[1])
    assert status == 2
    assert "not a result of ours" in err
    assert sorted(item.name for item in trials[1].iterdir()) == before
