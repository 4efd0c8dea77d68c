"""The report as a file: whole, alone, the same every time, in the order of what matters."""

import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from types import SimpleNamespace

import pytest
from report_page import PAPER, figure, rows, words

from worm_analysis.report.report import frames_with_pose
from worm_msgs_py import Status


def test_report_is_one_file_in_the_results_directory(whole, page):
    assert (whole / "report.html").read_text(encoding="utf-8") == page
    assert sorted(item.name for item in whole.iterdir()) == [
        "contacts.parquet", "figures", "passages.parquet", "report.html", "summary.json",
        "sums.parquet", "tracks.parquet",
    ]  # fmt: skip


def test_report_needs_no_network_and_no_other_file(page, page_without_chamber):
    for text in (page, page_without_chamber):
        assert "http:" not in text
        assert "https:" not in text
        assert not re.search(r"<(script|link|img|iframe|object|base)\b", text)
        assert not re.search(r"\bsrc=|@import", text)
        references = re.findall(r'(?:href="|url\()([^")]+)', text)
        assert references
        assert all(reference.startswith("#") for reference in references)


def test_every_reference_in_the_page_is_resolved_once(page):
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r'(?:href="|url\()#([^")]+)', page)) <= set(ids)


def test_same_results_give_the_same_bytes(whole, page, tmp_path):
    copy = tmp_path / "elsewhere"
    shutil.copytree(whole, copy)
    code = (
        "import sys, pathlib; from worm_analysis.report import write_report; "
        "write_report(pathlib.Path(sys.argv[1]))"
    )
    subprocess.run([sys.executable, "-c", code, str(copy)], check=True)
    assert (copy / "report.html").read_text(encoding="utf-8") == page


@pytest.mark.parametrize("key", [*PAPER, "fig-model", "fig-status"])
def test_every_panel_is_drawn_says_n_and_can_be_read_without_eyes(page, key):
    panel = figure(page, key)
    assert re.search(r"n = [1-9]", words(panel).replace("\u2009", "").replace("\xa0", " "))
    svg = re.findall(r"<svg.*?</svg>", panel, flags=re.DOTALL)
    assert len(svg) == 1
    root = ET.fromstring(svg[0])
    assert root.get("role") == "img"
    assert len(root.get("aria-label")) > 20
    assert len(list(root.iter("path"))) > 10
    assert "How to read it" in panel


def test_trajectories_and_times_come_first_then_the_papers_order(page):
    assert sorted(PAPER, key=lambda key: page.index(f'<figure id="{key}"')) == PAPER


def test_header_says_what_the_trial_was(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))
    text = words(page)
    assert "<h1>walker</h1>" in page
    assert f"{summary['frames']['read']} frames over 79.92 s (12 frames/s)" in text
    with_pose = sum(summary["frames"].get(s.label, 0) for s in Status if s.has_pose)
    assert f"a pose in {with_pose}" in text
    assert f"no worm{summary['frames']['no_worm']}{Status.NO_WORM.reason}" in text
    assert "residual of the circle (px)0.31" in text
    assert "worm-escape 0.1.0" in text
    assert "contact factor0.3" in text
    assert "0" * 64 in text


def test_frames_of_a_folded_worm_have_a_pose():
    counts = {"read": 20, "tracked": 3, "folded": 5, "loop_in_doubt": 2, "bridged": 1, "coiled": 9}
    assert frames_with_pose(SimpleNamespace(frames=counts)) == 11


def test_numbers_stand_beside_the_papers_with_interval_and_n(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))
    d_c = summary["quantities"]["d_c"]
    row = re.search(r'<tr id="q-d_c".*?</tr>', page)[0]
    cells = [words(cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row)]
    assert float(cells[2]) == pytest.approx(d_c["value"], abs=0.005)
    low, high = (float(end) for end in cells[3].split(" … "))
    assert (low, high) == pytest.approx((d_c["low"], d_c["high"]), abs=0.005)
    assert cells[4:] == [str(d_c["n"]), "mm", "1.95"]


def test_the_page_goes_from_the_trial_to_numbers_figures_details_and_definitions(page):
    order = ["At a glance", "Five numbers beside the paper’s", "Figures", "Not drawn",
             "All numbers", "The trial", "Provenance",
             "Definitions, and how to read the figures"]  # fmt: skip
    heads = re.findall(r"<h[23][^>]*>(.*?)</h[23]>", page)
    assert [head for head in heads if head in order] == order
    glance = page[: page.index(">Figures<")]
    shown = [f'<figure id="{key}"' in glance for key in ("fig-1c", "fig-2", "fig-1d")]
    assert shown == [True, True, False]


def test_every_drawn_figure_is_explained_in_the_last_section(page):
    last = page[page.index('<h2 id="definitions"') :]
    keys = re.findall(r'<figure id="([\w-]+)" class="(?:wide|column)"', page)
    assert len(keys) >= 8
    for key in keys:
        assert f'href="#read-{key}"' in figure(page, key)
        assert len(words(re.search(rf'<dt id="read-{key}".*?</dd>', last, re.DOTALL)[0])) > 100


def test_five_numbers_have_an_interval_n_and_a_verdict_or_a_reason(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))["quantities"]
    table = re.search(r'<table class="numbers headline">.*?</table>', page, re.DOTALL)[0]
    found = rows(table)
    assert [row[0] for row in found] == ["⟨dc⟩", "⟨dnc⟩", "vw", "tper", "success"]
    told = {row[0]: row for row in found}
    d_c = summary["d_c"]
    assert told["⟨dc⟩"][5] == f"{d_c['n']} complete contacts"
    is_in = d_c["low"] <= 1.95 <= d_c["high"]
    assert ("agrees with the paper" in told["⟨dc⟩"][7]) == is_in
    assert summary["success"]["why"] in " ".join(told["success"])
    assert told["success"][-1] == "no verdict"


RAW_KEY = re.compile(r"\b[a-z]+(?:_[a-z0-9.]+)+\b")


def labels(page):
    """Return all that a page says: its text, and what a screen reader reads of its figures."""
    spoken = re.findall(r'(?:aria-label|title|alt)="([^"]*)"', page)
    text = re.sub(r"<style>.*?</style>|<svg.*?</svg>", " ", page, flags=re.DOTALL)
    return " ".join([re.sub(r"<[^>]*>", " ", text), *spoken])


def test_no_raw_key_is_on_the_page(page, page_without_chamber):
    for text in (page, page_without_chamber):
        assert RAW_KEY.findall(labels(text)) == ["image_raw"]  # the name of a topic


def test_each_drawn_figure_is_there_as_svg_and_pdf_that_says_its_source(whole, page):
    drawn = set(re.findall(r'<figure id="([\w-]+)" class="(?:wide|column)"', page))
    files = {item.name for item in (whole / "figures").iterdir()}
    assert files == {f"{key}.{kind}" for key in drawn for kind in ("svg", "pdf")}
    for key in drawn:
        svg = (whole / "figures" / f"{key}.svg").read_text(encoding="utf-8")
        assert ET.fromstring(svg).tag.endswith("svg")
        assert f"walker (SHA-256 {'0' * 64})" in svg
        assert (whole / "figures" / f"{key}.pdf").read_bytes().startswith(b"%PDF")


def test_a_figure_is_on_white_in_its_file_and_on_the_pages_ground_there(whole, page):
    ground = '<rect width="100%" height="100%" fill="#ffffff"/>'
    svg = (whole / "figures" / "fig-1d.svg").read_text(encoding="utf-8")
    assert svg.count(ground) == 1
    assert svg.index(ground) < svg.index("<path")  # below all that is drawn
    assert "<title>" in svg
    drawn = figure(page, "fig-1d")
    assert "path" in drawn
    assert "100%" not in drawn
    assert "<title>" not in drawn


def test_the_report_is_imported_without_the_plotting_library():
    code = "import sys, worm_analysis.report; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
