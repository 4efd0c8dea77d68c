"""The report as a file: whole, alone, the same every time, and honest about what it lacks."""

import html
import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from report_trial import record, states, telegraph_walk, without_chamber

from worm_analysis.report import write_report
from worm_msgs_py import BodyState, Keypoint, Midline, Status

PAPER = ["fig-1c", "fig-1d", "fig-1e", "fig-2", "fig-3", "fig-7a"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A results directory of a simulated trial, with everything in it."""
    comparison, correlation = telegraph_walk(0.1)
    return record(
        tmp_path_factory.mktemp("whole") / "trial",
        states(),
        comparison=comparison,
        model_correlation=correlation,
    )


@pytest.fixture(scope="module")
def page(whole):
    return write_report(whole).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page_without_chamber(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bare") / "trial"
    return report_of(record(directory, without_chamber(states()), chamber=False))


def report_of(directory):
    return write_report(directory).read_text(encoding="utf-8")


def figure(page, key):
    """Return one figure's HTML."""
    found = re.findall(rf'<figure id="{key}".*?</figure>', page, flags=re.DOTALL)
    assert len(found) == 1, f"{key}: {len(found)} figures"
    return found[0]


def words(markup):
    """Return what a reader sees of some HTML."""
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", markup)).split())


def changed_summary(whole, directory, change):
    shutil.copytree(whole, directory)
    path = directory / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8"))
    change(summary)
    path.write_text(json.dumps(summary), encoding="utf-8")
    return directory


def test_report_is_one_file_in_the_results_directory(whole, page):
    assert (whole / "report.html").read_text(encoding="utf-8") == page
    assert sorted(item.name for item in whole.iterdir()) == [
        "contacts.parquet", "passages.parquet", "report.html", "summary.json", "sums.parquet",
        "tracks.parquet",
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


def test_panels_of_the_paper_come_in_its_order(page):
    assert sorted(PAPER, key=lambda key: page.index(f'<figure id="{key}"')) == PAPER


def test_header_says_what_the_trial_was(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))
    text = words(page)
    assert "<h1>walker</h1>" in page
    assert f"{summary['frames']['read']} frames over 79.92 s (12 frames/s)" in text
    assert f"a pose in {summary['frames']['tracked']}" in text
    assert f"no worm{summary['frames']['no_worm']}{Status.NO_WORM.reason}" in text
    assert "residual of the circle (px)0.31" in text
    assert "worm-escape 0.1.0" in text
    assert "contact_factor0.3" in text
    assert "0" * 64 in text


def test_numbers_stand_beside_the_papers_with_interval_and_n(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))
    d_c = summary["quantities"]["d_c"]
    row = re.search(r'<tr id="q-d_c".*?</tr>', page)[0]
    cells = [words(cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row)]
    assert float(cells[2]) == pytest.approx(d_c["value"], abs=0.005)
    low, high = (float(end) for end in cells[3].split(" … "))
    assert (low, high) == pytest.approx((d_c["low"], d_c["high"]), abs=0.005)
    assert cells[4:] == [str(d_c["n"]), "mm", "1.95"]


def test_a_number_that_cannot_be_had_says_why(whole, page):
    summary = json.loads((whole / "summary.json").read_text(encoding="utf-8"))
    missing = {
        name: entry["why"]
        for name, entry in summary["quantities"].items()
        if entry["value"] is None
    }
    assert {"tau_h", "success", "beta"} <= set(missing)
    for name, why in missing.items():
        assert why
        assert why in words(re.search(rf'id="q-{name}".*?</tr>', page)[0])


def test_without_a_chamber_the_picture_is_shown_and_the_rest_says_so(page_without_chamber):
    for key in ("fig-picture", "fig-motion", "fig-status"):
        assert "<svg" in figure(page_without_chamber, key)
    for key in [*PAPER, "fig-model"]:
        panel = figure(page_without_chamber, key)
        assert "<svg" not in panel
        assert "no chamber in the picture" in panel
    assert 'id="q-d_c"' in page_without_chamber


def rows(panel):
    """Return the words of each cell of each row of a figure's table."""
    return [
        [words(cell) for cell in re.findall(r"<t[hd]\b.*?</t[hd]>", row)]
        for row in re.findall(r"<tr.*?</tr>", panel)[1:]
    ]


def test_model_stands_beside_the_measurement_with_a_verdict(page):
    found = rows(figure(page, "fig-model"))
    assert found[0][:6] == ["⟨τh⟩", "–", "–", "50.0", "49.0 … 51.0", "s"]
    assert found[0][7].startswith("not measured: not enough data")
    assert found[1] == [
        "ns",
        "10.0",
        "5.0 … 20.0",
        "12.0",
        "11.0 … 13.0",
        "per 30 min",
        "",
        "agrees",
    ]
    assert found[2] == [
        "⟨dc⟩", "2.00", "1.60 … 2.50", "2.00", "–", "mm", "1.95", "given to the walk",
    ]  # fmt: skip
    assert found[3] == ["tper", "8.0", "5.0 … 12.0", "5.00", "–", "s", "27", "agrees"]


def test_report_says_with_which_parameters_the_model_was_run(page):
    panel = words(figure(page, "fig-model"))
    assert (
        "The walk was run with R = 10 mm, v = 2.02 mm/s, mean slide = 2 mm, reversal = 0.3, "
        "reversal counted = per cycle, hop may land = no, walks = 2000." in panel
    )
    assert "From this trial: ⟨dc⟩. From the paper, as this trial has none: reversal." in panel


def test_a_model_outside_the_measured_interval_does_not_agree(whole, tmp_path):
    def slow(summary):
        summary["model"]["quantities"]["t_per"]["modelled"] = 0.9

    panel = figure(report_of(changed_summary(whole, tmp_path / "slow", slow)), "fig-model")
    assert "It agrees with the measurement in ns." in words(panel)
    assert "It does not agree with the measurement in tper." in words(panel)


@pytest.mark.parametrize(
    ("key", "panel", "why"),
    [
        ("model", "fig-model", "the model was not run on this trial"),
        ("correlation", "fig-7a", "the summary has no correlation function"),
    ],
)
@pytest.mark.parametrize("how", ["null", "absent"])
def test_a_part_that_is_missing_is_named(whole, tmp_path, key, panel, why, how):
    def drop(summary):
        summary[key] = None
        if how == "absent":
            del summary[key]

    page = report_of(changed_summary(whole, tmp_path / "less", drop))
    assert why in words(figure(page, panel))
    assert "<svg" not in figure(page, panel)
    assert "<svg" in figure(page, "fig-1c")


def test_names_from_outside_are_text_not_markup(whole, tmp_path):
    def rename(summary):
        summary["provenance"]["source"]["bag"] = "<script>alert('w & m')</script>"
        summary["quantities"]["evil"] = {
            "value": None, "low": None, "high": None, "n": 0, "unit": "<b>", "paper": None,
            "why": "<u>",
        }  # fmt: skip

    page = report_of(changed_summary(whole, tmp_path / "odd", rename))
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert not re.search(r"<b>\s*</td>|<u>", page)


def lost(frame):
    return BodyState(frame, frame * 10**8, status=Status.NO_WORM), Midline.empty()


@pytest.mark.parametrize(
    "trial",
    [
        pytest.param([], id="no frame"),
        pytest.param(states()[:1], id="one frame"),
        pytest.param([lost(frame) for frame in range(300)], id="never tracked"),
        pytest.param(states()[:40], id="three seconds"),
    ],
)
@pytest.mark.parametrize("chamber", [True, False])
def test_too_little_data_gives_reasons_instead_of_plots(tmp_path, trial, chamber):
    trial = trial if chamber else without_chamber(trial)
    page = report_of(record(tmp_path / "trial", trial, chamber=chamber))
    for key in ["fig-3", "fig-7a", *(PAPER if len(trial) < 2 else [])]:
        panel = figure(page, key)
        assert "<svg" not in panel
        assert re.search(r"No figure: \w+", panel)


def test_frames_with_a_centroid_alone_are_shown(tmp_path):
    nowhere = Keypoint()
    trial = [
        (replace(state, status=Status.COILED, head=nowhere, tail=nowhere), Midline.empty())
        for state, _ in without_chamber(states())
    ]
    page = report_of(record(tmp_path / "trial", trial, chamber=False))
    assert "<svg" in figure(page, "fig-picture")


def test_the_report_is_imported_without_the_plotting_library():
    code = "import sys, worm_analysis.report; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
