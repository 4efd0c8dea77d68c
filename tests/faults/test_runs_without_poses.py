"""A run that gives no poses says what to try, and one without a single pose has no status 0."""

import json

import cv2
import failing_films as films
import pytest
from picture_bags import image, write_messages
from typer.testing import CliRunner

from worm_bringup.cli import app as command
from worm_bringup.cli.app import app
from worm_bringup.trial import WithoutPose

FAINT = "where a picture is blurred"


def bag_of(path, film):
    """A real bag of a film."""
    pictures = list(films.pictures(film))
    messages = [("image_raw", stamp, image(picture, stamp)) for picture, stamp in pictures]
    return write_messages(path, messages)


def replay(tmp_path, film, *more):
    bag, out = bag_of(tmp_path / "film", film), tmp_path / "out"
    done = CliRunner().invoke(app, ["replay", str(bag), "--no-chamber", *more, "--out", str(out)])
    return done, json.loads((out / "summary.json").read_text()), (out / "report.html").read_text()


@pytest.mark.parametrize("more", [[], ["--processes"]], ids=["one process", "a process each"])
def test_a_replay_without_one_pose_keeps_its_results_and_says_why(tmp_path, more):
    done, summary, report = replay(tmp_path, films.dithered, *more)
    assert isinstance(done.exception, WithoutPose)
    assert FAINT in str(done.exception)
    assert str(tmp_path / "out") in str(done.exception)
    assert FAINT in summary["what_to_try"]
    assert summary["complete"] is True
    assert sum(summary["frames"].values()) == 2 * films.FRAMES  # read, and each status
    assert FAINT in " ".join(done.stdout.split())
    assert FAINT in report.partition("<nav")[0]


def test_poses_of_what_is_no_worm_are_told_with_status_0(tmp_path):
    done, summary, report = replay(tmp_path, films.in_an_open_well)
    assert done.exit_code == 0
    for told in (done.stdout, summary["what_to_try"], report.partition("<nav")[0]):
        assert "leave out --no-chamber" in " ".join(told.split())


def test_a_bright_worm_taken_for_a_dark_one_has_no_pose_and_the_polarity_is_named(tmp_path):
    done, summary, _ = replay(tmp_path, films.bright_on_dark)
    assert isinstance(done.exception, WithoutPose)
    assert "--polarity bright" in str(done.exception)
    assert "--polarity bright" in summary["what_to_try"]


def test_a_replay_with_poses_is_told_nothing(tmp_path):
    done, summary, _ = replay(tmp_path, films.seen_well)
    assert done.exit_code == 0
    assert summary["what_to_try"] is None
    assert summary["source_events"] == []


def test_the_status_is_1_and_the_last_line_says_why(tmp_path, monkeypatch, capsys):
    bag = bag_of(tmp_path / "film", films.dithered)
    words = ["worm", "replay", str(bag), "--no-chamber", "--out", str(tmp_path / "out")]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 1
    said = capsys.readouterr()
    last = said.err.splitlines()[-1]
    assert "The report opens without a picture: no frame has a pose" in said.out
    assert last.startswith(f"worm: not one of {films.FRAMES} frames has a pose")
    assert FAINT in last


def test_a_live_trial_without_one_pose_is_kept_and_says_why(tmp_path):
    film, out = tmp_path / "film.avi", tmp_path / "out"
    size = (films.SIDE_PX, films.SIDE_PX)
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter_fourcc(*"FFV1"), 25.0, size, False)
    assert writer.isOpened()
    for picture, _ in films.pictures(films.underexposed, 12):
        writer.write(picture)
    writer.release()
    live = ["live", "--camera", str(film), "--no-chamber", "--private", "--out", str(out)]
    done = CliRunner().invoke(app, live)
    assert isinstance(done.exception, WithoutPose)
    assert "nearly black" in str(done.exception)
    assert "nearly black" in json.loads((out / "summary.json").read_text())["what_to_try"]
