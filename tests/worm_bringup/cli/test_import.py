"""`worm import` makes a bag that `worm replay` reads, or says in one line why it cannot."""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_tracker.sources.bags.bag_reader import BagPictures


def run(*arguments):
    return CliRunner().invoke(app, ["import", *map(str, arguments)], catch_exceptions=False)


def stills(folder, count):
    folder.mkdir()
    for number in range(count):
        cv2.imwrite(str(folder / f"{number}.png"), np.full((32, 48), 10 * number, np.uint8))
    return folder


def test_a_folder_of_pictures_becomes_a_bag(tmp_path):
    source = stills(tmp_path / "stills", 5)
    done = run(source, "--out", tmp_path / "bag", "--fps", 2, "--start", "2026-03-01T12:00:00")
    assert done.exit_code == 0
    assert "5 pictures, 2.000 s" in done.stdout
    with BagPictures(tmp_path / "bag") as pictures:
        stamps = [picture.stamp_ns for picture in pictures]
    assert np.diff(stamps).tolist() == [500_000_000] * 4
    assert stamps[0] > 1.7e18


def test_a_film_that_cannot_be_read_is_one_line_and_status_2(tmp_path):
    (tmp_path / "film.avi").write_text("no film")
    command = [str(Path(sys.executable).with_name("worm")), "import", str(tmp_path / "film.avi")]
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "bag")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.startswith("worm: ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "bag").exists()
