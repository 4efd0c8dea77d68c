"""`worm live` as a user runs it: a real MJPEG server on the loopback films the larva bag."""

import itertools
import re
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import worm
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage

from worm_tracker.sources.bags.bag_reader import BagPictures

BAGS = Path(__file__).parents[2] / "bags"
FRAMES = 120
pytestmark = pytest.mark.xdist_group("main job")


@contextmanager
def camera_of(bag, frames):
    """Serve a bag's own JPEG pictures at 50 frames/s, once."""
    with BagPictures(bag) as pictures:
        jpegs = [
            bytes(deserialize_message(picture.raw, CompressedImage).data)
            for picture in itertools.islice(pictures, frames)
        ]
    closing = threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            for jpeg in jpegs:
                head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                self.wfile.write(head.encode() + jpeg + b"\r\n")
                if closing.wait(0.02):
                    return

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        closing.set()
        server.shutdown()
        server.server_close()


def said_by(*words, status=0):
    """Run the command, and return what it prints."""
    done = worm(*words)
    assert done.returncode == status, done.stderr
    return done.stdout


def test_a_replay_of_what_was_recorded_live_gives_the_same_tracks(tmp_path):
    with camera_of(BAGS / "larva", FRAMES) as address:
        said = said_by(
            "live", "--camera", address, "--reconnect-s", "0", "--private",
            "--out", tmp_path / "live", "--record", tmp_path / "record",
            status=1,  # the camera was lost at the end
        )  # fmt: skip
    said_by("replay", tmp_path / "record", "--out", tmp_path / "again")
    tables = ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet")
    for name in tables:
        live, again = ((tmp_path / run / name).read_bytes() for run in ("live", "again"))
        assert live == again, name
    live, again = (next((tmp_path / run).glob("report_frame_*.png")) for run in ("live", "again"))
    assert (live.name, live.read_bytes()) == (again.name, again.read_bytes())
    tracks = pq.read_table(tmp_path / "live" / "tracks.parquet")
    captured, skipped = map(int, re.search(r"(\d+) captured, (\d+) skipped", said).groups())
    assert tracks.num_rows == captured - skipped
    settled = tracks["status"].to_pylist()[tracks.num_rows // 2 :]  # a busy machine skips a second
    assert settled.count("tracked") >= 0.95 * len(settled)
    stamps = tracks["stamp_ns"].to_pylist()
    assert all(a < b for a, b in itertools.pairwise(stamps))


def test_a_live_trial_that_records_nothing_opens_its_report_with_a_picture_too(tmp_path):
    out = tmp_path / "out"
    with camera_of(BAGS / "larva", FRAMES) as address:
        said_by(
            "live", "--camera", address, "--reconnect-s", "0", "--private", "--out", out,
            status=1,  # the camera was lost at the end
        )  # fmt: skip
    (picture,) = out.glob("report_frame_*.png")
    frame = int(picture.stem.removeprefix("report_frame_"))
    table = pq.read_table(out / "tracks.parquet").to_pydict()
    row = table["frame"].index(frame)
    grey = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE)
    u, v = (np.rint(table[f"midline_{axis}_px"][row][5:-5]).astype(int) for axis in "uv")
    assert np.mean(grey[v, u] < 100) > 0.95
    assert table["status"][row] == "tracked"
    assert '<figure id="fig-frame" class="wide">' in (out / "report.html").read_text()
