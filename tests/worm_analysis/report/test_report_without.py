"""What a trial lacks is named on the page, with its reason."""

import json
import re
from dataclasses import replace

import pytest
from report_page import PAPER, changed_summary, figure, report_of, words
from report_trial import record, states, without_chamber

from worm_msgs_py import BodyState, Keypoint, Midline, Status


def lost(frame):
    return BodyState(frame, frame * 10**8, status=Status.NO_WORM), Midline.empty()


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


def test_a_figure_that_is_not_drawn_is_one_line_with_its_reason(page):
    empty = re.findall(r'<figure id="[\w-]+" class="none">.*?</figure>', page, flags=re.DOTALL)
    assert empty
    for line in empty:
        assert line.count("<p>") == 1
        assert re.search(r"No figure: \w+.*\.", words(line))


def test_a_figure_that_is_not_drawn_any_more_leaves_no_file(whole, tmp_path):
    def drop(summary):
        summary["correlation"] = None

    report_of(whole)
    directory = changed_summary(whole, tmp_path / "less", drop)
    assert (directory / "figures" / "fig-7a.pdf").exists()
    (directory / "figures" / "mine.txt").write_text("not ours")
    report_of(directory)
    assert not list((directory / "figures").glob("fig-7a.*"))
    assert (directory / "figures" / "mine.txt").exists()


def test_without_a_chamber_the_picture_is_shown_and_the_rest_says_so(page_without_chamber):
    for key in ("fig-picture", "fig-motion", "fig-status"):
        assert "<svg" in figure(page_without_chamber, key)
    for key in [*PAPER, "fig-model"]:
        panel = figure(page_without_chamber, key)
        assert "<svg" not in panel
        assert "no chamber in the picture" in panel
    assert 'id="q-d_c"' in page_without_chamber


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


@pytest.mark.parametrize(
    "trial_of",
    [
        pytest.param(list, id="no frame"),
        pytest.param(lambda: states()[:1], id="one frame"),
        pytest.param(lambda: [lost(frame) for frame in range(300)], id="never tracked"),
        pytest.param(lambda: states()[:40], id="three seconds"),
    ],
)
@pytest.mark.parametrize("chamber", [True, False])
def test_too_little_data_gives_reasons_instead_of_plots(tmp_path, trial_of, chamber):
    trial = trial_of() if chamber else without_chamber(trial_of())
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
