"""A signal at any moment of a command leaves results that are whole or none, and no process."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from mjpeg_server import mjpeg_server
from result_files import TABLES
from sockets import children

from worm_tracker.sources.bags.bag_reader import BagPictures

LARVA = Path(__file__).parents[2] / "bags" / "larva"
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

AT_AN_EVENT = """
import os, signal, sys

events, at, number = 0, int(sys.argv.pop(1)), int(sys.argv.pop(1))

def count(name, arguments):  # of everything that Python does to the world: files, imports, sockets
    global events
    events += 1
    if events == at:
        os.kill(os.getpid(), number)

signal.signal(signal.SIGHUP, signal.SIG_DFL)
from worm_bringup.cli import main
sys.addaudithook(count)
try:
    main()
finally:
    print("events", events, flush=True)
"""
"""`worm`, which is sent a signal at the n-th audit event, or never; it says how many there were."""


def worm(at, number, *words):
    """Run it; return its status, what it said, and the processes that it has left behind."""
    command = [sys.executable, "-c", AT_AN_EVENT, str(at), str(int(number)), *map(str, words)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        out, err = process.communicate()
    try:
        os.killpg(process.pid, 0)
        left = True
    except ProcessLookupError:
        left = False
    return process.returncode, out + err, left


def check(folder, status, said, left):
    """Hold what was left to: whole or absent, said in a line, nobody alive."""
    assert not left
    assert "Traceback" not in said
    assert status in (0, 1, 130)
    out = folder / "out"
    if out.exists():
        names = {item.name for item in out.iterdir()}
        assert {*TABLES, "summary.json", "bag"} <= names
        assert "report.html" in names or "`worm report" in said
    else:
        assert status != 0
    if (folder / "record").exists():  # after the first picture it is a whole bag
        with BagPictures(folder / "record") as pictures:
            assert len(list(pictures)) == pictures.count > 0
    kept = {"out", "record", ".out.lock", ".out.checkpoint", "out-unfinished"}
    assert {item.name for item in folder.iterdir()} <= kept


REPLAY = ("replay", LARVA, "--playback-duration", "0.3")


@pytest.fixture(scope="module")
def events(tmp_path_factory):
    """How many events a short replay has."""
    _, said, _ = worm(-1, 2, *REPLAY, "--out", tmp_path_factory.mktemp("whole") / "out")
    return int(re.search(r"events (\d+)", said)[1])


@pytest.mark.parametrize("twelfth", range(12))
def test_a_replay_ends_in_order_whenever_it_is_told_to(tmp_path, events, twelfth):
    number = SIGNALS[twelfth % 3]
    at = 1 + round((events - 2) * twelfth / 11)
    check(tmp_path, *worm(at, number, *REPLAY, "--out", tmp_path / "out"))


@pytest.mark.parametrize("tenth", range(3, 13))
def test_a_live_trial_ends_in_order_whenever_it_is_told_to(tmp_path, events, tenth):
    """A camera that is lost ends those that have gone on before the signal comes."""
    with mjpeg_server(60, pause_s=0.01) as address:
        words = ["live", "--camera", address, "--no-chamber", "--private", "--reconnect-s", "0.1"]
        outputs = ["--out", tmp_path / "out", "--record", tmp_path / "record"]
        at, number = round(events * tenth / 10), SIGNALS[tenth % 3]
        check(tmp_path, *worm(at, number, *words, *outputs))


@pytest.mark.parametrize("number", SIGNALS)
def test_a_camera_that_does_not_answer_keeps_nobody(tmp_path, number):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}/"
        command = [sys.executable, "-c", AT_AN_EVENT, "-1", "2", "live", "--camera", address]
        with (
            subprocess.Popen(
                [*command, "--private", "--out", tmp_path / "out"],
                stderr=subprocess.PIPE,
                text=True,
            ) as process,
            silent.accept()[0],
        ):  # it is being opened
            process.send_signal(number)
            _, err = process.communicate()
    assert process.returncode == 130
    assert err.splitlines()[-1] == "worm: interrupted"
    assert {item.name for item in tmp_path.iterdir()} <= {".out.lock"}


def test_a_graph_in_processes_leaves_none_of_them(tmp_path):
    command = [sys.executable, "-c", AT_AN_EVENT, "-1", "2", *map(str, REPLAY), "--processes"]
    with subprocess.Popen(
        [*command, "--out", tmp_path / "out"], stderr=subprocess.PIPE, text=True
    ) as process:
        while len(nodes := children(process.pid)) < 5:
            assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        process.communicate()
    assert not [pid for pid in nodes if Path(f"/proc/{pid}").exists()]
    assert not (tmp_path / "out").exists()
