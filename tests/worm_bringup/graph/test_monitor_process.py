"""The monitor's process beside a graph: where it ends, hangs or cannot begin, the trial is safe."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from forked_commands import worm

BAG = Path(__file__).parents[3] / "bags" / "trial"
WORM = [sys.executable, "-c", "from worm_bringup.cli.app import main; main()"]


def replay(out, *more):
    command = [*WORM, "replay", str(BAG), "--out", str(out), "--playback-duration", "12", *more]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)


def end(process):
    """Return what a replay has still to say, once it has ended."""
    said = process.communicate(timeout=300)[1]
    return process.returncode, said


def monitor_of(process):
    """Return the number of the monitor's process."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return next(
        int(child)
        for child in children
        if "worm_monitor" in Path(f"/proc/{child}/cmdline").read_text()
    )


@pytest.fixture(scope="module")
def tracks(tmp_path_factory):
    """The tracks of the replay that nobody watches."""
    out = tmp_path_factory.mktemp("unwatched") / "out"
    worm("replay", BAG, "--out", out, "--playback-duration", "12").check_returncode()
    return (out / "tracks.parquet").read_bytes()


@pytest.mark.parametrize(
    ("number", "words"),
    [(signal.SIGKILL, "The monitor has ended; the trial goes on."), (signal.SIGSTOP, "")],
    ids=["killed", "stopped"],
)
def test_a_monitor_that_ends_or_hangs_changes_no_byte(tmp_path, tracks, number, words):
    process = replay(tmp_path / "out", "--monitor")
    assert "Monitor: http://127.0.0.1:" in process.stderr.readline()
    os.kill(monitor_of(process), number)
    status, said = end(process)
    assert status == 0
    assert words in said
    assert (tmp_path / "out" / "tracks.parquet").read_bytes() == tracks


def test_a_graph_of_processes_is_shown_as_well(tmp_path, tracks):
    process = replay(tmp_path / "out", "--monitor", "--processes")
    assert re.search(r"http://127\.0\.0\.1:\d+/$", process.stderr.readline().strip())
    assert end(process)[0] == 0
    assert (tmp_path / "out" / "tracks.parquet").read_bytes() == tracks


def test_a_port_that_is_taken_is_refused_in_a_line_and_nothing_is_written(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        status, said = end(replay(tmp_path / "out", "--monitor", "--monitor-port", port))
    assert status == 2
    assert f"port {port}" in said.splitlines()[-1]
    assert "--monitor-port" in said.splitlines()[-1]
    assert not list(tmp_path.iterdir())


def test_the_pages_options_need_the_page(tmp_path):
    status, said = end(replay(tmp_path / "out", "--monitor-port", "8000"))
    assert status == 2
    assert "--monitor" in said
