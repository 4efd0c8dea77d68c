"""The report begins with a picture of the trial, and what was found stands where it is in it."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imsave
from report_page import figure, report_of, words
from report_trial import CHAMBER

from worm_analysis.report import theme, write_report
from worm_analysis.report.figures.trial_picture import trial_picture
from worm_analysis.results import read_results
from worm_analysis.results.picture import read_kept_picture, row_to_show
from worm_msgs_py.errors import ReportError
from worm_msgs_py.files.frame_pictures import frame_picture_path


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
