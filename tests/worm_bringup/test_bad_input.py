"""Bad input as a user meets it: one line with file, cause and remedy; status 2; no output."""

import cv2
import numpy as np
import pytest
from forked_commands import worm
from picture_bags import image, stamps, write_bag, write_messages
from result_files import result_text, write_result
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_bringup.outputs.results_directory import results_directory
from worm_msgs_py.errors import BadInput

SIZE = (256, 256)


def films(picture_of, encoding="mono8"):
    """Return a maker of bags whose pictures are `picture_of(frame)`."""

    def make(folder):
        messages = [
            ("/image_raw", t, image(picture_of(i), t, encoding)) for i, t in enumerate(stamps(30))
        ]
        return write_messages(folder / "bag", messages)

    return make


def no_such_bag(folder):
    return folder / "bag"


def not_a_bag(folder):
    (folder / "notes.txt").write_text("not a bag")
    return folder / "notes.txt"


def half_a_bag(folder):
    bag = write_bag(folder / "bag", 200)
    file = next(bag.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    return file


def no_pictures(folder):
    return write_messages(folder / "bag", [("/chatter", 0, "std_msgs/msg/String")])


def two_topics(folder):
    blank = np.zeros(SIZE, np.uint8)
    return write_messages(
        folder / "bag", [(topic, 0, image(blank, 1)) for topic in ("/left", "/right")]
    )


def no_messages(folder):
    return write_messages(folder / "bag", [("/image_raw", 0, "sensor_msgs/msg/Image")])


def noise(frame):
    return np.random.default_rng(frame).integers(0, 256, SIZE, np.uint8)


CASES = [
    pytest.param(no_such_bag, ["no such"], id="no such bag"),
    pytest.param(not_a_bag, ["notes.txt"], id="not a bag"),
    pytest.param(half_a_bag, ["bag"], id="half a bag"),
    pytest.param(no_pictures, ["/chatter"], id="no image topic"),
    pytest.param(two_topics, ["/left", "/right", "topic"], id="several topics, none chosen"),
    pytest.param(no_messages, ["bag"], id="empty bag"),
    pytest.param(
        films(lambda i: np.zeros(SIZE, np.uint8), "bayer_rggb8"),
        ["bayer_rggb8", "mono8"],
        id="an encoding that is not read",
    ),
    pytest.param(films(lambda i: np.zeros(SIZE, np.uint8)), ["chamber"], id="black pictures"),
    pytest.param(films(lambda i: np.full(SIZE, 200, np.uint8)), ["chamber"], id="bright pictures"),
    pytest.param(films(noise), ["chamber", "--no-chamber"], id="noise: no chamber is found"),
]


def replay(bag, out, *options):
    return worm("replay", bag, "--out", out, *options)


def check(done, out, words):
    assert done.returncode == 2, done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert not out.exists()
    assert not list(out.parent.glob(".*partial*"))


@pytest.mark.parametrize(("make", "words"), CASES)
def test_bad_input_is_one_line_and_no_output(tmp_path, make, words):
    out = tmp_path / "results" / "out"
    out.parent.mkdir()
    check(replay(make(tmp_path), out), out, words)


def test_a_process_for_each_node_says_the_same(tmp_path):
    out = tmp_path / "results" / "out"
    out.parent.mkdir()
    bag = films(noise)(tmp_path)
    check(replay(bag, out, "--processes"), out, ["chamber", "--no-chamber"])


def test_a_camera_whose_pictures_show_no_chamber_is_named(tmp_path):
    film, out = tmp_path / "film.avi", tmp_path / "out"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter_fourcc(*"MJPG"), 25.0, SIZE, False)
    for _ in range(12):
        writer.write(np.zeros(SIZE, np.uint8))
    writer.release()
    live = ["live", "--camera", str(film), "--private", "--out", str(out)]
    done = CliRunner().invoke(app, live)
    assert isinstance(done.exception, BadInput)
    assert str(done.exception).startswith(f"{film}: no chamber found")
    assert not out.exists()


def test_an_earlier_result_survives_bad_input(tmp_path):
    out = tmp_path / "out"
    with results_directory(out) as partial:
        write_result(partial, "earlier")
    assert replay(films(noise)(tmp_path), out).returncode == 2
    assert result_text(out) == "earlier"


def test_a_folder_of_the_users_is_not_written_into(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    done = replay(write_bag(tmp_path / "bag"), tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "--out" in done.stderr


def test_a_message_of_another_kind_is_not_taken_for_a_picture(tmp_path):
    bag = write_messages(tmp_path / "bag", [("/image_raw", 0, "std_msgs/msg/String")])
    done = replay(bag, tmp_path / "out")
    assert done.returncode == 2
