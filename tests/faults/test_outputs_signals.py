"""A signal, a closed terminal or a report that fails never costs a result that is finished."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from forked_commands import worm
from mjpeg_server import mjpeg_server
from result_files import TABLES

from worm_msgs_py.ros.running import (
    finish_despite_signals,
    interrupted_by_signals,
    stop_on_signals,
)
from worm_tracker.sources.bags.bag_reader import BagPictures

LARVA = Path(__file__).parents[2] / "bags" / "larva"
WORM = Path(sys.executable).with_name("worm")
ENDING = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
LONG_S = 120.0
DURING_THE_REPORT = """
import os, select, sys
from functools import partial
from worm_bringup import trial
from worm_bringup.cli import main

write = trial.write_report

def write_when_told(directory):
    print("writing the report", flush=True)
    # Of two signals at once the kernel may give one to another thread, and that interrupts no read.
    while not select.select([sys.stdin], [], [], 0.05)[0]:
        pass
    if sys.stdin.readline() == "fail\\n":
        raise RuntimeError("no fonts")
    return write(directory)

def run_and_tell(run, what, out, progress, **how):
    told = []

    def tell(sent, expected):
        if sent and not told:
            told.append(print("frames are coming", flush=True))

    return run(what, out, tell, **how)

if "live" in sys.argv:
    trial.run_graph = partial(run_and_tell, trial.run_graph)
trial.write_report = write_when_told
trial.REPORT_S = float(os.environ["REPORT_S"])
main()
"""

IN_A_TERMINAL = """
import fcntl, os, sys, termios
os.setsid()
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""


@pytest.fixture(autouse=True)
def a_terminal_that_closes_is_heeded():
    """Let SIGHUP be heeded even where the tests were started by nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


def to_myself(number):
    os.kill(os.getpid(), number)


@pytest.mark.parametrize("number", ENDING)
def test_each_signal_that_ends_a_program_stops_a_run_in_good_order(number):
    with stop_on_signals() as stop, stop_on_signals() as inner:
        to_myself(number)
        assert stop.is_set()
        assert inner is stop


def test_a_terminal_that_closes_stops_once_however_often_it_says_so():
    with stop_on_signals() as stop:
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGHUP):
            to_myself(number)
        stop.clear()  # as an endless source does that now ends
        to_myself(signal.SIGHUP)
        assert not stop.is_set()
        to_myself(signal.SIGINT)
        assert stop.is_set()


def test_a_hangup_that_was_ignored_stays_so():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stop_on_signals() as stop, finish_despite_signals():
            to_myself(signal.SIGHUP)
        assert not stop.is_set()
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("number", ENDING)
def test_one_signal_lets_what_is_finished_be_written(number):
    with finish_despite_signals():
        to_myself(number)
        to_myself(signal.SIGHUP)


def test_a_second_signal_ends_what_hangs():
    with finish_despite_signals():
        to_myself(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            to_myself(signal.SIGINT)


class ForgetsWhatIsRaised:
    """Sent a signal while it is finalised, where Python drops what the handler raises."""

    def __init__(self, number):
        self.number = number

    def __del__(self):
        to_myself(self.number)


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_that_falls_into_a_finaliser_still_interrupts(capfd, number):
    with interrupted_by_signals():
        ForgetsWhatIsRaised(number)
        with pytest.raises(KeyboardInterrupt):
            threading.Event().wait(LONG_S)
    assert capfd.readouterr().err == ""  # no traceback for people


def test_the_end_of_the_time_that_a_report_is_given_is_heard_in_a_finaliser_too(capfd):
    with finish_despite_signals(LONG_S):
        to_myself(signal.SIGTERM)
        ForgetsWhatIsRaised(signal.SIGALRM)
        with pytest.raises(KeyboardInterrupt):
            threading.Event().wait(LONG_S)
    assert capfd.readouterr().err == ""


def test_other_faults_of_finalisers_are_told_as_before(capfd):
    class Fails:
        def __del__(self):
            raise ValueError("a fault of ours")

    before = sys.unraisablehook
    try:
        sys.unraisablehook = sys.__unraisablehook__
        with interrupted_by_signals():
            Fails()
    finally:
        sys.unraisablehook = before
    assert "a fault of ours" in capfd.readouterr().err


def test_an_alarm_of_another_is_left_to_it():
    heard = threading.Event()
    before = signal.signal(signal.SIGALRM, lambda number, frame: heard.set())
    timer = signal.setitimer(signal.ITIMER_REAL, 0.01)
    try:
        with interrupted_by_signals(), finish_despite_signals():
            pass
        assert heard.wait(LONG_S)
    finally:
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, before)


def replay_during_the_report(out, signals, word, report_s=600.0):
    command = [sys.executable, "-c", DURING_THE_REPORT, "replay", LARVA, "--out", out]
    with subprocess.Popen(
        [*map(str, command), "--playback-duration", "1"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"REPORT_S": str(report_s)},
    ) as process:
        assert process.stdout.readline() == "writing the report\n"
        for number in signals:
            process.send_signal(number)
        _, err = process.communicate(word) if word else (process.wait(), process.stderr.read())
        return process.returncode, err.splitlines()[-1] if err else ""


def live_until(number, out, answer):
    """End a live trial by a signal; look at what is there while its report waits to be written.

    Parameters
    ----------
    answer : callable
        Given the process, lets it go on, or not.

    Returns
    -------
    set, int, str
        The files that were there, the exit status, and what was said last.
    """
    with mjpeg_server(None, pause_s=0.02) as address:
        live = ["live", "--camera", address, "--no-chamber", "--private", "--out", str(out)]
        with subprocess.Popen(
            [sys.executable, "-c", DURING_THE_REPORT, *live],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"REPORT_S": "600"},
        ) as process:
            assert process.stdout.readline() == "frames are coming\n"
            process.send_signal(number)
            drawing = process.stdout.readline() == "writing the report\n"
            there = files_of(out)
            if drawing:
                answer(process)
            _, err = process.communicate()
            return there, process.returncode, err


def test_results_are_in_place_before_their_report_is_drawn(tmp_path):
    out = tmp_path / "out"
    there, status, said = live_until(signal.SIGINT, out, lambda p: p.stdin.write("go on\n"))
    assert there == DATA
    assert f"{out}: the results are whole; now their report" in said
    assert status == 1  # noise has no pose
    assert files_of(out) == {*DATA, *DRAWN}


def test_a_machines_signal_waits_for_no_report(tmp_path):
    out = tmp_path / "out"
    there, status, said = live_until(signal.SIGTERM, out, lambda _: pytest.fail("it is drawn"))
    assert status == 130
    assert f"`worm report {out}` writes it" in said.splitlines()[-1]
    assert there == DATA


def test_a_second_ctrl_c_leaves_the_report_out_and_says_how_to_get_it(tmp_path):
    out = tmp_path / "out"
    _, status, said = live_until(signal.SIGINT, out, lambda p: p.send_signal(signal.SIGINT))
    assert status == 130
    assert f"`worm report {out}` writes it" in said.splitlines()[-1]
    assert files_of(out) == DATA
    assert not list(tmp_path.glob(".out*"))


def files_of(out):
    """Return the names of what is there; the picture's without its number."""
    return {re.sub(r"report_frame_\d+", "frame", item.name) for item in out.iterdir()}


DATA = {*TABLES, "summary.json", "bag"}
DRAWN = {"report.html", "figures"}
PICTURE = "frame.png"


def test_a_signal_while_the_report_is_written_lets_it_be_written(tmp_path):
    status, _ = replay_during_the_report(tmp_path / "out", ENDING[2:], "go on\n")
    assert status == 0
    assert files_of(tmp_path / "out") == {*DATA, *DRAWN, PICTURE}


@pytest.mark.parametrize(
    ("signals", "word", "report_s", "expected"),
    [
        pytest.param([signal.SIGTERM, signal.SIGINT], "", 600.0, 130, id="interrupted twice"),
        pytest.param([signal.SIGTERM], "", 0.01, 130, id="interrupted, and it takes too long"),
        pytest.param([], "fail\n", 600.0, 1, id="matplotlib fails"),
    ],
)
def test_finished_data_outlive_the_report(tmp_path, signals, word, report_s, expected):
    out = tmp_path / "out"
    status, line = replay_during_the_report(out, signals, word, report_s)
    assert status == expected
    assert f"the results are whole and kept in {out}" in line
    assert files_of(out) == {*DATA, PICTURE}
    worm("report", out).check_returncode()
    assert files_of(out) == {*DATA, *DRAWN, PICTURE}


def test_a_live_trial_whose_terminal_closes_ends_in_good_order(tmp_path):
    out, record = tmp_path / "out", tmp_path / "record"
    with mjpeg_server(None, pause_s=0.02) as address:
        command = ["live", "--camera", address, "--no-chamber", "--private"]
        terminal, mine = pty.openpty()
        with subprocess.Popen(
            [sys.executable, "-c", IN_A_TERMINAL, WORM, *command, "--out", out, "--record", record],
            stdin=mine,
            stdout=mine,
            stderr=mine,
        ) as process:
            os.close(mine)
            shown = b""
            while not re.search(rb"[1-9]\d*/", shown):  # frames are coming
                shown += os.read(terminal, 4096)
            os.close(terminal)
            status = process.wait()
    assert status in (1, 130)  # whole, but noise has no pose; or there was no time for the report
    assert files_of(out) in ({*DATA, *DRAWN}, DATA, {*DATA, "frame.png"})
    frames = json.loads((out / "summary.json").read_text())["frames"]["read"]
    with BagPictures(record) as pictures:
        assert pictures.count == frames > 0


@pytest.mark.parametrize("gone", ["closed pipe", "closed stderr"])
def test_a_run_that_nobody_listens_to_is_whole(tmp_path, gone):
    reader, writer = os.pipe()
    os.close(reader)
    ears = {"stdout": writer} if gone == "closed pipe" else {}
    done = subprocess.run(
        [WORM, "replay", LARVA, "--out", tmp_path / "out", "--playback-duration", "1"],
        **{"stdout": subprocess.DEVNULL, "stderr": writer, **ears},
        check=False,
    )
    os.close(writer)
    assert done.returncode == 0
    assert files_of(tmp_path / "out") == {*DATA, *DRAWN, PICTURE}
