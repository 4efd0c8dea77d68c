"""A disk that is full, read-only or mounted in the way: one line, nothing lost, nothing left."""

import subprocess
from contextlib import suppress
from pathlib import Path

import pytest
from forked_commands import worm
from result_files import files_in, result_text, write_result

from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import Kept, results_directory
from worm_msgs_py.errors import BadInput

LARVA = Path(__file__).parents[2] / "bags" / "larva"


def mount(*args):
    done = subprocess.run(["mount", *map(str, args)], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"this machine mounts nothing here: {done.stderr.strip()}")


@pytest.fixture
def unmounted(tmp_path):
    """Give a list of what is to be unmounted at the end."""
    places = []
    yield places
    for place in reversed(places):
        subprocess.run(["umount", place], check=True)


@pytest.fixture
def disk(tmp_path, unmounted):
    """A disk of one megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    mount("-t", "tmpfs", "-o", "size=1m", "tmpfs", place)
    unmounted.append(place)
    return place


def fill(disk, leave_kb):
    """Take the room of a disk, but for a little."""
    (disk / "full").write_bytes(bytes((1024 - leave_kb) * 1024))


def check_one_line(done, *words):
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    for word in words:
        assert word in line


@pytest.mark.parametrize("way", [[], ["--processes"]], ids=["one process", "processes"])
@pytest.mark.parametrize("leave_kb", [128, 0])
def test_a_disk_that_fills_up_is_one_line_and_the_earlier_result_stays(disk, way, leave_kb):
    write_result(disk / "out", "earlier")
    fill(disk, 128)
    if leave_kb == 0:
        with (disk / "full").open("ab", buffering=0) as file, suppress(OSError):
            while file.write(bytes(4096)):
                pass
    before = files_in(disk)
    # Eight seconds fill it, and fewer leave no room for the report alone.
    done = worm("replay", LARVA, "--out", disk / "out", "--playback-duration", "12", *way)
    assert done.returncode == 2, done.stderr
    *others, line = done.stderr.splitlines()
    assert "No space left" in line
    assert "--out" in line
    assert all("checkpoint" in other for other in others), done.stderr
    assert files_in(disk) == before


def test_a_disk_that_is_full_by_the_report_keeps_the_data(disk):
    out = disk / "out"

    def run():
        with results_directory(out) as partial:
            write_result(partial, "new", report=False)
            (partial / "report.html").write_bytes(bytes(2 << 20))

    with pytest.raises(Kept, match=r"kept in .*out, but their report .*No space left"):
        run()
    assert result_text(out) == "new"


def change(attribute, place):
    """Set or clear a file's attribute; root, too, obeys it."""
    done = subprocess.run(["chattr", attribute, place], capture_output=True, check=False)
    if done.returncode:
        pytest.skip("this file system has no attributes")


def test_a_directory_in_which_nothing_can_be_renamed_any_more_keeps_the_results_there(tmp_path):
    write_result(tmp_path / "out", "earlier")

    def run():
        with results_directory(tmp_path / "out") as partial:
            write_result(partial, "new")
            change("+i", tmp_path)

    try:
        with pytest.raises(Kept, match=r"not permitted.*kept in .*out\.partial") as kept:
            run()
    finally:
        change("-i", tmp_path)
    assert result_text(kept.value.directory) == "new"
    assert result_text(tmp_path / "out") == "earlier"


def test_a_read_only_disk_is_one_line(disk):
    mount("-o", "remount,ro", disk)
    done = worm("replay", LARVA, "--out", disk / "out", "--playback-duration", "1")
    check_one_line(done, "Read-only file system", "--out")


def test_something_mounted_in_the_way_keeps_the_results_beside_it(tmp_path, unmounted):
    out = tmp_path / "out"
    write_result(out, "earlier")

    def run():
        with results_directory(out) as partial:
            write_result(partial, "new")
            mount("-t", "tmpfs", "tmpfs", out)
            unmounted.append(out)

    with pytest.raises(Kept, match=r"busy.*out-2$"):
        run()
    assert result_text(tmp_path / "out-2") == "new"


def test_a_mount_point_is_refused_at_the_start(disk):
    with pytest.raises(BadInput, match="mount point"), results_directory(disk):
        pass


def test_a_directory_that_is_mounted_twice_is_known(tmp_path, unmounted):
    for name in ("bag", "same"):
        (tmp_path / name).mkdir()
    mount("--bind", tmp_path / "bag", tmp_path / "same")
    unmounted.append(tmp_path / "same")
    with pytest.raises(BadInput, match="lies in the bag"):
        check_apart({"--out": tmp_path / "same" / "out"}, {"the bag": tmp_path / "bag"})


@pytest.mark.parametrize(
    ("command", "said"),
    [
        pytest.param(["simulate", "--minutes", "0.03", "--out"], "free", id="simulate"),
        pytest.param(["import", "FILM", "--fps", "30", "--out"], "No space left", id="import"),
        pytest.param(["model", "figure", "--out"], "No space left", id="figure"),
    ],
)
def test_other_files_are_whole_or_not_there(tmp_path, disk, command, said):
    fill(disk, 16)
    film = stills(tmp_path)
    done = worm(*(film if part == "FILM" else part for part in command), disk / "made.svg")
    check_one_line(done, said)
    assert list(files_in(disk)) == ["full"]


def stills(tmp_path):
    """Write a few pictures of noise, which nothing makes small."""
    import cv2
    import numpy as np

    folder = tmp_path / "stills"
    folder.mkdir()
    noise = np.random.default_rng(0).integers(0, 256, (4, 512, 512), np.uint8)
    for number, picture in enumerate(noise):
        cv2.imwrite(str(folder / f"{number}.png"), picture)
    return folder


@pytest.mark.parametrize(
    ("command", "taken"),
    [
        (["simulate", "--minutes", "0.02", "--out", "bag"], "bag"),
        (["simulate", "--minutes", "0.02", "--out", "bag"], "bag_truth.parquet"),
        (["model", "figure", "--out", "walk.svg"], "walk.svg"),
    ],
)
def test_a_file_that_is_there_is_not_replaced(tmp_path, monkeypatch, command, taken):
    monkeypatch.chdir(tmp_path)
    (tmp_path / taken).write_text("mine")
    done = worm(*command)
    check_one_line(done, taken, "exists already")
    assert files_in(tmp_path) == {taken: b"mine"}
