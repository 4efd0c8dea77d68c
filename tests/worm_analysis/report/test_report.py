"""The report as a file: whole, alone, the same every time, and honest about what it lacks."""

import html
import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imsave
from report_trial import CHAMBER, record, states, telegraph_walk, without_chamber

from worm_analysis.report import theme, write_report
from worm_analysis.report.figures.trial_picture import trial_picture
from worm_analysis.results import read_results
from worm_analysis.results.picture import read_kept_picture, row_to_show
from worm_msgs_py import BodyState, Keypoint, Midline, Status
from worm_msgs_py.errors import ReportError
from worm_msgs_py.files.frame_pictures import frame_picture_path

PAPER = ["fig-1c", "fig-2", "fig-1d", "fig-1e", "fig-3", "fig-7a"]
"""As they come: the whole of a short trial against time is among what it begins with."""


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
    assert f"a pose in {summary['frames']['tracked']}" in text
    assert f"no worm{summary['frames']['no_worm']}{Status.NO_WORM.reason}" in text
    assert "residual of the circle (px)0.31" in text
    assert "worm-escape 0.1.0" in text
    assert "contact factor0.3" in text
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
        if entry["value"] is None and "_at_" not in name  # these are in the figure of sensitivity
    }
    assert {"tau_h", "success", "beta"} <= set(missing)
    for name, why in missing.items():
        assert why
        assert why in words(re.search(rf'id="q-{name}".*?</tr>', page)[0])


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


def test_a_figure_that_is_not_drawn_is_one_line_with_its_reason(page):
    empty = re.findall(r'<figure id="[\w-]+" class="none">.*?</figure>', page, flags=re.DOTALL)
    assert empty
    for line in empty:
        assert line.count("<p>") == 1
        assert re.search(r"No figure: \w+.*\.", words(line))


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


def test_a_figure_that_is_not_drawn_any_more_leaves_no_file(whole, tmp_path):
    def drop(summary):
        summary["correlation"] = None

    directory = changed_summary(whole, tmp_path / "less", drop)
    assert (directory / "figures" / "fig-7a.pdf").exists()
    (directory / "figures" / "mine.txt").write_text("not ours")
    report_of(directory)
    assert not list((directory / "figures").glob("fig-7a.*"))
    assert (directory / "figures" / "mine.txt").exists()


def with_quantity(whole, directory, **values):
    """Return a copy of a trial in which the numbers are others."""

    def change(summary):
        for name, (value, low, high) in values.items():
            summary["quantities"][name] |= {"value": value, "low": low, "high": high, "n": 99}

    return report_of(changed_summary(whole, directory, change))


def test_a_rejected_exponential_says_so(whole, tmp_path):
    said = "an exponential law is rejected (Anderson and Darling’s test, p = 0.002, n = 99)"
    bad = with_quantity(whole, tmp_path / "bad", d_c_exponential_p=(0.002, None, None))
    assert said in words(figure(bad, "fig-3"))
    assert said in words(re.search(r"numbers headline.*?</table>", bad, re.DOTALL)[0])
    good = with_quantity(whole, tmp_path / "good", d_c_exponential_p=(0.2, None, None))
    assert "⟨dc⟩: an exponential law" not in words(good)


@pytest.mark.parametrize(
    ("key", "name", "r", "said"),
    [
        ("fig-4b", "theta_dot_incidence_correlation", (0.85, 0.8, 0.9),
         "finds no correlation; here there is one, r = 0.850 [0.800 … 0.900]"),
        ("fig-4b", "theta_dot_incidence_correlation", (0.05, -0.1, 0.2), ""),
        ("fig-4a", "theta_dot_psi_b_correlation", (-0.5, -0.6, -0.4),
         "The paper finds that it grows; here it does not, r = −0.50 [−0.60 … −0.40]"),
        ("fig-4a", "theta_dot_psi_b_correlation", (0.05, -0.1, 0.2), ""),
    ],
)  # fmt: skip
def test_a_correlation_that_is_not_the_papers_says_so(whole, tmp_path, key, name, r, said):
    panel = figure(with_quantity(whole, tmp_path / "other", **{name: r}), key)
    if "<svg" not in panel:
        pytest.fail(f"{key} is not drawn")
    assert said in words(panel)
    assert ("Does not fit:" in words(panel)) == bool(said)


def test_a_decay_that_is_no_exponential_is_told_with_the_time_to_one_e(whole, tmp_path):
    page = with_quantity(
        whole, tmp_path / "beetle", t_per=(9.5, 8.0, 11.0), t_1e=(19.9, 15.0, 26.0),
        t_1e_over_t_per=(2.09, 1.6, 2.7), c_theta_tail=(0.2, 0.15, 0.25),
    )  # fmt: skip
    for place in (figure(page, "fig-7a"), re.search(r"headline.*?</table>", page, re.DOTALL)[0]):
        said = words(place)
        assert (
            "fit decays in 9.5 [8.0 … 11.0] s but the curve falls to 1/e at 19.9 [15.0 … 26.0] s"
            in said
        )
        assert "from 1.5 to 4 tper the curve lies above the fit, by 0.200 [0.150 … 0.250]" in said
    page = with_quantity(
        whole, tmp_path / "one", t_1e_over_t_per=(1.1, 0.9, 1.3), c_theta_tail=(0.0, -0.1, 0.1)
    )
    assert "is not one exponential" not in words(page)


@pytest.fixture(scope="module")
def pictured(whole, tmp_path_factory):
    """The same trial with one of its pictures kept."""
    directory = tmp_path_factory.mktemp("pictured") / "trial"
    shutil.copytree(whole, directory)
    results = read_results(directory)
    row = row_to_show(results)
    grey = np.random.default_rng(0).integers(0, 255, (1024, 1024), dtype=np.uint8)
    imsave(frame_picture_path(directory, int(results.tracks["frame"][row])), grey, cmap="gray")
    return directory, row


def test_the_report_opens_with_a_picture_of_the_trial(pictured):
    directory, row = pictured
    page = report_of(directory)
    keys = re.findall(r'<figure id="([\w-]+)"', page)
    assert keys[:3] == ["fig-frame", "fig-1c", "fig-2"]
    panel = figure(page, "fig-frame")
    assert panel.count("data:image/png;base64,") == 2, "the chamber, and the worm enlarged"
    assert f"Frame {row}, at " in words(panel).replace("\xa0", " ")
    outside = [ref for ref in re.findall(r'href="([^"]+)', page) if not ref.startswith("#")]
    assert all(ref.startswith("data:image/png;base64,") for ref in outside)


def test_the_picture_has_wall_exit_midline_and_the_three_points_where_they_were_found(pictured):
    directory, row = pictured
    results = read_results(directory)
    with theme.style():
        whole_view, close = trial_picture(
            results, read_kept_picture(directory, results)
        ).figure.axes[:2]
    for axes in (whole_view, close):
        (wall,) = axes.patches
        assert wall.width == pytest.approx(2 * CHAMBER.radius_px)
        assert wall.center == pytest.approx((CHAMBER.centre_u_px, CHAMBER.centre_v_px))
        assert wall.angle == pytest.approx(-147.0)
        points = {
            line.get_color(): (line.get_xdata()[0], line.get_ydata()[0])
            for line in axes.lines
            if len(line.get_xdata()) == 1
        }
        for point, colour in theme.COLOURS.items():
            place = [results.tracks[f"{point}_{axis}_px"][row] for axis in "uv"]
            assert points[colour] == pytest.approx(place)
        (midline,) = [line for line in axes.lines if len(line.get_xdata()) > 2]
        head = [results.tracks[f"head_{axis}_px"][row] for axis in "uv"]
        assert (midline.get_xdata()[0], midline.get_ydata()[0]) == pytest.approx(head, abs=0.01)


def test_the_frame_shown_is_at_the_wall_with_a_certain_head_and_a_whole_body(whole):
    results = read_results(whole)
    row = row_to_show(results)
    tracks = results.tracks
    assert tracks["contact"][row] == 1.0
    trusted = np.where(tracks["contact"] == 1.0, tracks["confidence"], 0.0)
    trusted[::2] = 0.5
    doubtful = tracks["head_certainty"].copy()
    doubtful[: len(doubtful) // 2] = 0.6
    other = replace(results, tracks=tracks | {"confidence": trusted, "head_certainty": doubtful})
    chosen = row_to_show(other)
    assert chosen % 2 == 1
    assert chosen >= len(doubtful) // 2
    nothing = replace(
        results, tracks=tracks | {"status": np.full(len(doubtful), "no_worm", dtype=object)}
    )
    assert row_to_show(nothing) is None


def test_without_a_picture_one_line_says_why(page):
    panel = figure(page, "fig-frame")
    assert "<svg" not in panel
    assert "no picture is kept beside these tracks" in words(panel)


def test_a_picture_of_another_trial_is_refused(pictured, tmp_path):
    directory = tmp_path / "other"
    shutil.copytree(pictured[0], directory)
    next(directory.glob("report_frame_*.png")).rename(directory / "report_frame_999999.png")
    with pytest.raises(ReportError, match="is no picture of this trial"):
        write_report(directory)


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
