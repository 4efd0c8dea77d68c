"""Cameras of others: FFmpeg serves MJPEG, GStreamer's server RTSP; both die and return."""

import shutil
import socket
import subprocess
import threading
from contextlib import ExitStack, contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from mjpeg_server import jpeg_picture, number_in

from worm_tracker.sources.cameras.camera import Camera

SUPPORT = Path(__file__).parents[1] / "support"
DEBIANS = "/usr/bin/python3"
FPS, PICTURES = 50, 40


def has_gstreamer():
    if not Path(DEBIANS).exists():
        return False
    asked = "import gi; gi.require_version('GstRtspServer', '1.0')"
    return not subprocess.run([DEBIANS, "-c", asked], capture_output=True, check=False).returncode


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """JPEG files that show their numbers, as a camera makes them: in colour."""
    folder = tmp_path_factory.mktemp("pictures")
    for number in range(PICTURES):
        colour = cv2.cvtColor(jpeg_picture(number), cv2.COLOR_GRAY2BGR)
        cv2.imwrite(str(folder / f"{number:03}.jpg"), colour)
    return folder / "%03d.jpg"


@contextmanager
def ffmpeg(port, pictures):
    """FFmpeg as the server of an MJPEG camera, which serves one caller."""
    words = ["-loglevel", "error", "-re", "-framerate", str(FPS), "-loop", "1", "-i", pictures]
    out = ["-c", "copy", "-f", "mpjpeg", "-listen", "1", f"http://127.0.0.1:{port}/"]
    with subprocess.Popen(["ffmpeg", *map(str, words), *out], stdin=subprocess.DEVNULL) as process:
        while f":{port:04X} " not in Path("/proc/net/tcp").read_text():
            assert process.poll() is None
        try:
            yield f"http://127.0.0.1:{port}/"
        finally:
            process.kill()


@contextmanager
def gstreamer(port, pictures):
    """GStreamer's RTSP server, which knows how to stream a camera to several."""
    command = [DEBIANS, SUPPORT / "rtsp_server.py", str(port), pictures, str(FPS)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout.readline() == "going\n"
        try:
            yield f"rtsp://127.0.0.1:{port}/film"
        finally:
            process.kill()


SERVERS = [
    pytest.param(
        ffmpeg,
        id="MJPEG",
        marks=pytest.mark.skipif(not shutil.which("ffmpeg"), reason="no ffmpeg"),
    ),
    pytest.param(
        gstreamer,
        id="RTSP",
        marks=pytest.mark.skipif(
            not has_gstreamer(),
            reason="no gir1.2-gst-rtsp-server-1.0, python3-gi and gstreamer1.0-plugins-good",
        ),
    ),
]


def take(camera, changed, enough):
    """Take frames until there are enough."""
    frames = []
    while not enough(frames):
        assert not camera.ended, camera.why_lost
        changed.wait(0.1)
        changed.clear()
        frames += iter(camera.take, None)
    return frames


def sixty(frames):
    return len(frames) >= 60


def check(frames):
    """Each picture shows the number after the one before; a server may repeat its first one."""
    numbers = [number_in(frame.picture) for frame in frames]
    steps = np.diff(numbers) % PICTURES
    steps = steps[np.flatnonzero(steps)[0] :]
    assert (steps == 1).all(), str(numbers)
    assert (np.diff([frame.stamp_ns for frame in frames]) > 0).all()


@pytest.mark.parametrize("server", SERVERS)
def test_a_server_that_dies_and_returns_is_an_outage_of_known_length(pictures, server):
    port = free_port()
    with ExitStack() as stack:
        with server(port, pictures) as address:
            changed = threading.Event()
            patience = {"stall_s": 1.0, "reconnect_delay_s": 0.1, "reconnect_s": 120.0}
            camera = Camera(address, on_change=changed.set, **patience)
            stack.callback(camera.stop)
            camera.start()
            camera.begin()
            before = take(camera, changed, sixty)
            camera.take_outages()  # until it had begun
        # What was on the way still comes.
        before += take(camera, changed, lambda _: camera.outage is not None)
        stack.enter_context(server(port, pictures))
        after = take(camera, changed, sixty)
        outage, *_ = camera.take_outages()
        counts = camera.counts
    check(before)
    check(after)
    assert outage.since_ns == before[-1].stamp_ns
    gap_s = (after[0].stamp_ns - before[-1].stamp_ns) / 1e9
    assert outage.duration_s == pytest.approx(gap_s)
    assert outage.reconnections >= 1
    assert counts.reconnections >= 1
    assert counts.skipped == 0
