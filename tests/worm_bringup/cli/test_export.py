"""`worm export --to mp4`: frame n of the film shows frame n of the tracks, or says why not."""

import shutil

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import worm
from picture_bags import compressed, write_bag

from worm_model.simulator.film import write_film
from worm_model.simulator.scenes import Take, at_the_wall
from worm_msgs_py.colours import HEAD_COLOUR

FRAMES = 24
pytestmark = pytest.mark.xdist_group("export")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A film, results with and without its pictures, and its truth."""
    folder = tmp_path_factory.mktemp("export")
    write_film(folder / "film", at_the_wall(Take(px_per_mm=19.95, frames=FRAMES)))
    for out, options in (("whole", ["--with-pictures"]), ("bare", [])):
        done = worm("replay", folder / "film", "--out", folder / out, *options)
        assert done.returncode == 0, done.stderr
    return folder


def frames_of(film):
    capture = cv2.VideoCapture(str(film))
    assert capture.isOpened()
    found = []
    while True:
        there, frame = capture.read()
        if not there:
            return found
        found.append(frame)


def head_of(frame):
    """Return the middle of what has the head's colour; a film's colours are not exact."""
    blue = np.array(list(bytes.fromhex(HEAD_COLOUR[1:])))[::-1]
    v, u = np.nonzero(np.abs(frame.astype(int) - blue).sum(axis=2) < 90)
    return np.array([np.median(u), np.median(v)])


def refusal(done):
    assert done.returncode == 2
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("worm: ")]
    return line


@pytest.mark.parametrize(("results", "options"), [("whole", []), ("bare", ["--bag", "film"])])
def test_every_frame_shows_the_head_where_it_truly_is(folder, tmp_path, results, options):
    options = [folder / word if word == "film" else word for word in options]
    done = worm("export", folder / results, "--to", "mp4", "--out", tmp_path / "x.mp4", *options)
    assert done.returncode == 0, done.stderr
    frames = frames_of(tmp_path / "x.mp4")
    truth = pq.read_table(folder / "film_truth.parquet").to_pylist()
    tracked = pq.read_table(folder / results / "tracks.parquet")["status"].to_pylist()
    assert len(frames) == len(truth) == FRAMES
    assert {frame.shape for frame in frames} == {(512, 512, 3)}  # of 511: a codec wants even sides
    shown = [n for n in range(FRAMES) if tracked[n] == "tracked"]
    assert len(shown) > 0.8 * FRAMES
    for n in shown:
        true = truth[n]["head_u_px"], truth[n]["head_v_px"]
        assert head_of(frames[n]) == pytest.approx(true, abs=2.0)
    steps = np.hypot(*np.diff([[row["head_u_px"], row["head_v_px"]] for row in truth], axis=0).T)
    assert np.median(steps) > 2.0  # so that a frame off would be seen


def test_without_a_name_it_lies_beside_the_results_and_is_never_replaced(folder):
    done = worm("export", folder / "whole", "--to", "mp4")
    assert done.returncode == 0, done.stderr
    film = folder / "whole.mp4"
    assert str(film) in done.stdout
    before = film.read_bytes()
    assert "exists already" in refusal(worm("export", folder / "whole", "--to", "mp4"))
    assert film.read_bytes() == before


def test_results_without_pictures_say_where_to_get_them(folder, tmp_path):
    done = worm("export", folder / "bare", "--to", "mp4", "--out", tmp_path / "x.mp4")
    assert "--bag" in refusal(done)
    assert not list(tmp_path.iterdir())


def test_the_pictures_of_another_trial_are_refused_and_leave_nothing(folder, tmp_path):
    other = write_bag(tmp_path / "other", FRAMES, topic="image_raw/compressed", make=compressed)
    out = tmp_path / "out"
    out.mkdir()
    done = worm("export", folder / "bare", "--to", "mp4", "--bag", other, "--out", out / "x.mp4")
    assert "is not the bag of these results" in refusal(done)
    assert not list(out.iterdir())


def test_what_is_no_result_is_refused(folder, tmp_path):
    assert "summary.json" in refusal(worm("export", folder / "film", "--to", "mp4"))
    shutil.copytree(folder / "whole", tmp_path / "half")
    shutil.rmtree(tmp_path / "half" / "bag")
    assert "has no bag/" in refusal(worm("export", tmp_path / "half", "--to", "mp4"))


def test_another_ending_and_a_place_in_the_results_are_refused(folder):
    whole = folder / "whole"
    assert "ends in .mp4" in refusal(worm("export", whole, "--to", "mp4", "--out", "x.avi"))
    inside = worm("export", whole, "--to", "mp4", "--out", whole / "x.mp4")
    assert "lies in the results" in refusal(inside)
    assert "avi" in refusal(worm("export", whole, "--to", "avi"))
