"""The simulated rig is a camera like any other: it films in real time, and its record replays."""

import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import worm

from worm_bringup import simulated_camera
from worm_bringup.simulated_camera import FRAMES_PER_S, SimulatedCapture

WORM = [sys.executable, "-c", "from worm_bringup.cli import main; main()"]


@pytest.fixture
def clock(monkeypatch):
    """A clock that only sleeping moves on."""
    now = [0.0]
    monkeypatch.setattr(simulated_camera.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(simulated_camera.time, "sleep", lambda s: now.__setitem__(0, now[0] + s))
    return now


def test_frames_come_when_they_are_due_and_a_late_machine_leaves_some_out(clock):
    lines = [np.full((2, 2), k) for k in range(100)]
    capture = SimulatedCapture(1)
    clock[0] = 0.0
    found = capture._in_time(iter(lines))
    for frame in range(10):
        assert next(found)[0, 0] == frame
        assert clock[0] == pytest.approx(frame / FRAMES_PER_S)
    clock[0] += 1.0
    assert next(found)[0, 0] == 9 + round(FRAMES_PER_S)
    assert capture.lost == round(FRAMES_PER_S) - 1


def test_the_same_seed_films_the_same_worm(clock):
    pictures = []
    for seed in (1, 1, 2):
        capture = SimulatedCapture(seed)
        assert all(capture.grab() for _ in range(5))
        pictures.append(capture.retrieve()[1])
    a, b, c = pictures
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()
    assert a.shape == (512, 512)


def test_a_live_trial_of_it_can_be_replayed(tmp_path):
    words = ["live", "--camera", "sim", "--out", "live", "--record", "bag", "--private"]
    with subprocess.Popen([*WORM, *words], cwd=tmp_path, stderr=subprocess.PIPE) as process:
        deadline = time.monotonic() + 120.0
        while not (tmp_path / "bag").is_dir() or films_so_far(tmp_path / "bag") < 200_000:
            assert process.poll() is None, process.stderr.read().decode()
            assert time.monotonic() < deadline
            time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        assert process.wait(120) == 0, process.stderr.read().decode()
    tracks = pq.read_table(tmp_path / "live" / "tracks.parquet").to_pydict()
    assert "tracked" in tracks["status"]
    worm("replay", "bag", "--out", "again", cwd=tmp_path).check_returncode()
    again = pq.read_table(tmp_path / "again" / "tracks.parquet").to_pydict()
    assert again["stamp_ns"] == tracks["stamp_ns"]
    assert again["head_u_px"] == tracks["head_u_px"]


def films_so_far(bag):
    return sum(path.stat().st_size for path in bag.rglob("*.mcap"))
