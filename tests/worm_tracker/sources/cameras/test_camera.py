"""What a camera gives is what was there, in order, and what is skipped counts."""

import math
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from mjpeg_server import jpeg_picture, mjpeg_server, number_in
from picture_bags import START_NS, TYPESTORE, image, numbered_picture, serialised, storage_file
from rosbags.rosbag2 import Reader

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.bag_repair import repair_bag
from worm_tracker.sources.bags.bag_writer import PictureRecorder
from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.cameras.waiting_frames import MOST_WAITING
from worm_tracker.sources.image_decoder import IMAGE_TYPE


def watch(address, take=True, **kwargs):
    """Capture to the end; return the frames that were taken, and the counts."""
    changed = threading.Event()
    camera = Camera(address, reconnect_delay_s=0.01, on_change=changed.set, **kwargs)
    camera.begin()
    frames = []
    while not camera.ended:
        assert changed.wait(20.0)
        changed.clear()
        frames += taken(camera) if take else []
    frames += taken(camera)
    camera.stop()
    return frames, camera.counts


def taken(camera):
    """Take all that wait."""
    return list(iter(camera.take, None))


@pytest.fixture
def video(tmp_path):
    """Thirty frames that claim to be a hundred a second."""
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 100.0, (64, 48))
    assert writer.isOpened()
    for number in range(30):
        writer.write(cv2.cvtColor(jpeg_picture(number), cv2.COLOR_GRAY2BGR))
    writer.release()
    return str(path)


def test_frames_come_in_the_order_in_which_they_were_served():
    with mjpeg_server(200) as address:
        frames, counts = watch(address, reconnect_s=0.0)
    numbers = [number_in(frame.picture) for frame in frames]
    assert counts.captured == 200
    assert counts.captured == counts.taken + counts.skipped
    assert counts.taken == len(frames) > 0
    assert (np.diff(numbers) > 0).all()
    assert numbers[-1] == 199
    assert (np.diff([frame.stamp_ns for frame in frames]) > 0).all()
    for frame, number in zip(frames, numbers, strict=True):
        assert np.abs(frame.picture.astype(int) - jpeg_picture(number)).max() < 40


def test_where_nobody_takes_them_the_newest_frame_wins():
    count = MOST_WAITING + 10
    with mjpeg_server(count) as address:
        frames, counts = watch(address, take=False, reconnect_s=0.0)
    assert [number_in(frame.picture) for frame in frames] == [count - 1]
    assert (counts.captured, counts.taken, counts.skipped) == (count, 1, count - 1)


def test_a_stream_that_stops_is_opened_anew():
    with mjpeg_server(20, 20) as address:
        _, counts = watch(address, reconnect_s=0.5)
    assert counts.captured == 40
    assert counts.reconnections == 1


def test_a_stream_that_opens_and_gives_nothing_is_given_up():
    with mjpeg_server(20, 0, 0, 0, 0, 0) as address:
        _, counts = watch(address, reconnect_s=0.5)
    assert counts.captured == 20


def test_a_video_is_played_in_real_time(video):
    began_ns = time.time_ns()
    frames, counts = watch(video)
    assert counts.captured == 30 == counts.taken + counts.skipped
    for frame in frames:
        assert frame.stamp_ns - began_ns >= number_in(frame.picture) / 100 * 1e9


def test_a_camera_can_be_stopped_at_any_time():
    with mjpeg_server(None, pause_s=0.001) as address:
        came = threading.Event()
        camera = Camera(address, on_change=came.set)
        camera.begin()
        assert came.wait(20.0)
        camera.stop()
        assert camera.ended
        counts = camera.counts
    assert counts.captured == counts.taken + counts.skipped + counts.waiting > 0
    assert not math.isnan(counts.age_s)


@pytest.mark.parametrize("address", ["/dev/video99", "99", "http://127.0.0.1:9/", "nowhere.avi"])
def test_a_camera_that_is_not_there(address, capfd):
    with pytest.raises(BadInput) as caught:
        Camera(address)
    assert str(caught.value).startswith(address)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_file_that_is_no_video(tmp_path):
    (tmp_path / "notes.avi").write_text("These are words.")
    with pytest.raises(BadInput, match="is it a video"):
        Camera(str(tmp_path / "notes.avi"))


def test_a_password_is_never_shown():
    with pytest.raises(BadInput) as caught:
        Camera("http://me:secret@127.0.0.1:9/stream")
    assert "secret" not in str(caught.value)


# The record.


def record(directory, count, shape=(48, 64)):
    recorder = PictureRecorder(directory, "/image_raw", IMAGE_TYPE)
    for number in range(count):
        stamp_ns = START_NS + number * 1000
        recorder.write(stamp_ns, serialised(image(numbered_picture(number, shape), stamp_ns)))
    return recorder


def test_a_record_is_a_bag_that_holds_what_was_written(tmp_path):
    record(tmp_path / "new" / "bag", 12).close()
    with Reader(tmp_path / "new" / "bag") as reader:
        assert reader.message_count == 12
        assert [connection.msgtype for connection in reader.connections] == [IMAGE_TYPE]
        assert reader.duration == 11 * 1000 + 1
    with BagPictures(tmp_path / "new" / "bag") as bag:
        for number, picture in enumerate(bag):
            message = TYPESTORE.deserialize_cdr(picture.raw, IMAGE_TYPE)
            assert picture.stamp_ns == START_NS + number * 1000
            np.testing.assert_array_equal(message.data.reshape(48, 64), numbered_picture(number))


def test_a_record_never_overwrites(tmp_path):
    (tmp_path / "precious.txt").touch()
    with pytest.raises(BadInput, match="holds files already"):
        PictureRecorder(tmp_path, "/image_raw", IMAGE_TYPE)
    assert [file.name for file in tmp_path.iterdir()] == ["precious.txt"]
    with pytest.raises(BadInput, match="cannot be recorded into"):
        PictureRecorder(tmp_path / "precious.txt" / "bag", "/image_raw", IMAGE_TYPE)


def in_a_process(path, body):
    """Run a test's lines where they may do harm; return its status and what it said."""
    done = subprocess.run(
        [sys.executable, "-c", f"import os, resource\nfrom pathlib import Path\n{body}", str(path)],
        capture_output=True,
        text=True,
        cwd=path,
        env={**os.environ, "PYTHONPATH": ":".join([*sys.path, str(Path(__file__).parent)])},
    )
    return done.returncode, done.stderr


def test_a_crash_costs_no_picture_that_was_written(tmp_path):
    status, said = in_a_process(
        tmp_path,
        "from test_camera import record\nrecord(Path('bag'), 10, (700, 1000))\nos._exit(9)",
    )
    assert status == 9, said
    with pytest.raises(BadInput, match=r"metadata.yaml is missing"):
        BagPictures(tmp_path / "bag")
    saved = repair_bag(storage_file(tmp_path / "bag"), tmp_path / "saved.mcap").saved
    assert saved == 10
    with BagPictures(tmp_path / "saved.mcap") as bag:
        assert [picture.stamp_ns for picture in bag] == [START_NS + k * 1000 for k in range(saved)]


def test_a_full_disk_is_an_error_that_says_so(tmp_path):
    status, said = in_a_process(
        tmp_path,
        "resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))\n"
        "from test_camera import record\n"
        "record(Path('bag'), 10, (700, 1000))",
    )
    assert status == 1
    line = said.splitlines()[-1]
    assert "BadInput" in line
    assert "cannot be written (File too large) after" in line
    assert "`worm repair" in line
