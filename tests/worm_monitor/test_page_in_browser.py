"""The page as people see it, in a real Chromium, while `worm replay --monitor` runs."""

import re
import signal
import socket
import subprocess
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from browser_tab import NEEDS_CHROMIUM, WINDOWS, WORM, Tab, page_of, running_chromium
from forked_commands import worm

from worm_tracker.sources.bags.bag_reader import BagPictures

pytestmark = NEEDS_CHROMIUM
BAG = Path(__file__).parents[2] / "bags" / "trial"
PLAYED_S = 30
FRAMES = 300


def replay_to(out):
    """Return the words of a replay of the first seconds of a trial."""
    return ("replay", BAG, "--out", out, "--playback-duration", PLAYED_S)


def monitored(out, *more):
    """Give the address of a replay's page, and see the replay to its end."""
    words = (*replay_to(out), "--monitor", "--monitor-port", "0", *more)
    return page_of(words, "stderr", ends_by_itself=True)


@pytest.fixture(scope="module")
def chromium():
    with running_chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def unwatched(tmp_path_factory):
    """The results of the same replay that nobody watched."""
    out = tmp_path_factory.mktemp("unwatched") / "out"
    done = worm(*replay_to(out))
    assert done.returncode == 0, done.stderr
    return out


class TrialTab(Tab):
    """The page of a trial that runs."""

    def until_log_has(self, words):
        self.until("words => document.getElementById('events').innerText.includes(words)", words)

    def until_frame_is_after(self, frame):
        self.until(
            "frame => Number(document.getElementById('stamp').innerText.split('frame')[1]) > frame",
            frame,
        )

    def until_frame_is(self, frame):
        self.until(
            "frame => Number(document.getElementById('stamp').innerText.split('frame')[1])"
            " === frame",
            frame,
        )

    def until_it_may_play(self):
        self.until("() => document.getElementById('pause').innerText === 'Play'")

    def until_clock_is_at(self, frame):
        """Wait until the trial is said to be at a frame: its picture may come before."""
        self.until(
            "frame => Math.round(10 * Number(document.getElementById('clock').innerText"
            ".split(':').pop())) === frame",
            frame,
        )

    @property
    def clock_frame(self):
        """The frame that the trial is at, of ten a second."""
        return round(10 * float(self.text("clock").rpartition(":")[2]))

    def move_timeline(self, second):
        """Drag the timeline's knob, and let it go."""
        self.page.evaluate(
            """second => {
                const line = document.getElementById("timeline");
                line.value = String(second);
                for (const what of ["input", "change"]) line.dispatchEvent(new Event(what));
            }""",
            second,
        )

    @property
    def frame(self):
        """The frame whose picture is shown."""
        return int(self.text("stamp").partition("frame")[2])

    def drawn(self, name):
        """What a canvas shows."""
        return self.page.evaluate("name => document.getElementById(name).toDataURL()", name)


def test_a_trial_is_watched_and_led_from_the_page(chromium, unwatched, tmp_path):
    with monitored(tmp_path / "out", "--start-paused") as address:
        tab = TrialTab(chromium, address)
        tab.until("() => document.getElementById('kind').innerText === 'REPLAY'")
        tab.page.select_option("#rate", "2")
        tab.until_log_has("rate 2")
        assert tab.text("pause") == "Play"
        tab.page.click("#pause")

        tab.until_frame_is_after(10)  # the picture moves, and the plots grow
        first, plot, picture = tab.frame, tab.drawn("radii"), tab.drawn("picture")
        tab.until_frame_is_after(first + 10)
        tab.until("before => document.getElementById('radii').toDataURL() !== before", plot)
        assert tab.drawn("picture") != picture

        tab.page.click("#pause")
        tab.until_it_may_play()
        assert not tab.page.is_visible("#note")  # what a recording is called is not for the page
        tab.page.click("#swap")
        tab.until_log_has("exchanged by an operator from frame")
        it_is_stepped(tab)
        tab.page.click("#events li")
        tab.until("() => document.getElementById('cursor').innerText.includes('mm')")
        it_is_sought_in(tab)

        not_the_page_is_refused(chromium, address)
        for size in WINDOWS:
            for scheme in ("light", "dark"):
                fits(TrialTab(chromium, address, size, scheme))

        assert tab.wrong == []
        assert all(url.startswith((address, address.replace("http", "ws"))) for url in tab.asked)
        tab.page.select_option("#rate", "0")
        tab.page.click("#pause")
        tab.until("() => document.getElementById('kind').innerText === 'ENDED'")
        exchanged = int(
            re.search(r"exchanged by an operator from frame (\d+)", tab.text("events")).group(1)
        )
        tab.page.close()
    head_and_tail_are_exchanged(tmp_path / "out", unwatched, exchanged)


def it_is_stepped(tab):
    """One frame on from one that was sought: after a pause, others may still be on their way."""
    sought = tab.clock_frame + 20
    tab.move_timeline(sought / 10)
    tab.until_frame_is(sought)
    tab.until_clock_is_at(sought)
    tab.until_it_may_play()
    tab.page.click("#step")
    tab.until_frame_is(sought + 1)
    tab.until_clock_is_at(sought + 1)


def it_is_sought_in(tab):
    """Back, to a frame that was tracked; forward, through every frame, to one that was not."""
    tab.page.click("#release")  # of the event that was gone to
    now = tab.clock_frame
    tab.until_frame_is(now)
    tab.move_timeline(1.2)
    tab.until_frame_is(12)
    tab.page.click("#back")
    tab.until_frame_is(now)
    tab.page.click("#radii", position={"x": 120, "y": 60})
    tab.until("() => !document.getElementById('back').hidden")
    assert tab.frame < now
    tab.page.click("#release")
    tab.until_frame_is(now)
    sought = now + 15
    tab.move_timeline(sought / 10)
    tab.until_frame_is(sought)
    tab.until_clock_is_at(sought)
    tab.until_it_may_play()


def not_the_page_is_refused(chromium, address):
    """A page elsewhere that is open in the same browser gets neither the page nor its socket."""
    with somebody_elses_page() as elsewhere:
        page = chromium.new_page()
        page.goto(elsewhere)
        opens = """address => new Promise((tell) => {
            const socket = new WebSocket(address.replace("http", "ws") + "socket");
            socket.onopen = () => tell("open");
            socket.onerror = () => tell("refused");
        })"""
        reads = "address => fetch(address).then(() => 'read', () => 'refused')"
        assert page.evaluate(opens, address) == "refused"
        assert page.evaluate(reads, address) == "refused"
        page.close()
    port = int(address.rstrip("/").rpartition(":")[2])
    for header in ("Host: evil.example", f"Host: 127.0.0.1:{port}\r\nOrigin: http://evil.example"):
        with socket.create_connection(("127.0.0.1", port)) as plain:
            plain.sendall(f"GET / HTTP/1.1\r\n{header}\r\n\r\n".encode())
            assert plain.recv(1000).split()[1] == b"403"


@contextmanager
def somebody_elses_page():
    class Elsewhere(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>elsewhere</title>")

        def log_message(self, *_):
            pass

    with HTTPServer(("127.0.0.1", 0), Elsewhere) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://localhost:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


def fits(tab):
    """Nothing of the page lies beyond the window's sides, and none of its words over others."""
    tab.until("() => document.getElementById('stamp').innerText.includes('frame')")
    tab.until("() => document.getElementById('kind').innerText === 'REPLAY'")
    wide = tab.page.evaluate("() => document.scrollingElement.scrollWidth")
    assert wide <= tab.page.viewport_size["width"]
    the_table_has_room(tab)
    no_tile_is_cut(tab)
    boxes = [box.bounding_box() for box in tab.page.locator("#tiles div").all()]
    for one, other in pairwise(boxes):
        same_line = abs(one["y"] - other["y"]) < 1
        assert not same_line or one["x"] + one["width"] <= other["x"] + 1
    assert tab.wrong == []
    tab.page.close()


def test_a_new_trial_begins_beside_the_one_that_ends(chromium, tmp_path):
    out = tmp_path / "out"
    kept = ["--out", str(out), "--record", str(tmp_path / "film")]
    command = [*WORM, "live", "--camera", "sim", *kept, "--private", "--monitor"]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/", process.stderr.readline()).group()
        tab = TrialTab(chromium, address)
        tab.until("() => document.getElementById('kind').innerText === 'LIVE'")
        tab.until("() => Number(document.getElementById('stamp').innerText.split('frame')[1]) > 9")
        for width, height in WINDOWS:
            tab.page.set_viewport_size({"width": width, "height": height})
            no_tile_is_cut(tab)
        tab.page.click("#new_trial")
        assert tab.text("new_trial") == "End this trial?"
        tab.page.click("#new_trial")
        tab.until("() => document.getElementById('kind').innerText === 'ENDED'")
        tab.until("() => document.getElementById('kind').innerText === 'LIVE'")  # at one address
        tab.until("() => Number(document.getElementById('stamp').innerText.split('frame')[1]) > 9")
        tab.page.close()
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=300)[1]
        assert process.returncode == 0, said
    finally:
        process.kill()
        process.communicate()
    first, second = (
        pq.read_table(folder / "tracks.parquet")["stamp_ns"].to_numpy()
        for folder in (out, tmp_path / "out-2")
    )
    assert len(first) > 9
    assert len(second) > 9
    assert first[-1] < second[0]
    assert (out / "report.html").exists()
    assert (tmp_path / "out-2" / "report.html").exists()
    for folder, taken in (("film", first), ("film-2", second)):
        with BagPictures(tmp_path / folder) as film:
            assert film.count == len(taken)


def the_table_has_room(tab):
    """Long numbers, and a long reason why there is none, stay within the window."""
    long = {"value": -39.09, "low": 0.4455, "high": -192.3, "n": 54000, "unit": "deg", "paper": -34}
    long |= {"why": ""}
    none = {**long, "value": None, "why": "not enough data: 7 windows of time, 10 are needed"}
    skips = {**long, "unit": "per 30 min"}
    over = """async (quantities) => {
        const { fillNumbers } = await import(new URL("numbers.js", location.href));
        fillNumbers(document.getElementById("numbers"), { quantities }, "");
        const table = document.querySelector(".numbers");
        return table.scrollWidth - table.clientWidth;
    }"""
    told = {"d_c": long, "delta_r_h": none, "v_w": {**none, "unit": "mm/s"}, "n_s": skips}
    assert tab.page.evaluate(over, told) <= 0


LONG_WORDS = {
    "direction": "CCW 12.34 mm/s", "where": "chamber b", "R, W": "10.25, 2.55 mm",
    "scale": "39.95 px/mm", "frames": "107999", "fps in, done": "119.9, 119.9", "dropped": "14775",
    "latency": "14.2 s", "last frame": "28799.9 s ago", "recording": "123456.7 MB",
}  # fmt: skip


def no_tile_is_cut(tab):
    """Whatever the tiles say, each has room for it, and none lies over another."""
    cut = """words => {
        const tiles = [...document.querySelectorAll("#tiles div")];
        for (const tile of tiles) {
            const [name, value] = tile.children;
            value.textContent = words[name.textContent] ?? value.textContent;
        }
        const parts = tiles.flatMap((tile) => [...tile.children]);
        return parts.filter((part) => part.scrollWidth > part.clientWidth).map((p) => p.innerText);
    }"""
    assert tab.page.evaluate(cut, LONG_WORDS) == []


def points(out, name):
    table = pq.read_table(out / "tracks.parquet")
    return np.stack([table[f"{name}_{axis}_px"].to_numpy() for axis in "uv"], axis=1)


def head_and_tail_are_exchanged(out, unwatched, frame):
    head, tail = points(unwatched, "head"), points(unwatched, "tail")
    assert len(points(out, "head")) == len(head) == FRAMES
    assert np.allclose(points(out, "head")[:frame], head[:frame])
    assert np.allclose(points(out, "head")[frame : frame + 5], tail[frame : frame + 5], atol=2.0)


def test_browsers_that_look_seek_stall_or_die_change_no_byte(chromium, unwatched, tmp_path):
    with monitored(tmp_path / "out", "--start-paused") as address:
        tabs = [TrialTab(chromium, address) for _ in range(3)]
        for tab in tabs:
            tab.until("() => !document.getElementById('timeline').disabled")
        with stalled_socket(address):
            tabs[0].move_timeline(20.0)
            tabs[1].until_frame_is(200)
            tabs[1].move_timeline(3.0)
            tabs[1].until_frame_is(30)
            tabs[0].until_it_may_play()  # it may be told later than the other one
            tabs[0].page.click("#pause")
            tabs[0].until_frame_is_after(210)
            tabs[2].page.close()
            tabs[0].until("() => document.getElementById('kind').innerText === 'ENDED'")
        for tab in tabs[:2]:
            assert tab.wrong == []
            tab.page.close()
    for name in ("tracks.parquet", "contacts.parquet", "passages.parquet", "summary.json"):
        assert (tmp_path / "out" / name).read_bytes() == (unwatched / name).read_bytes(), name


@contextmanager
def stalled_socket(address):
    """Open the page's socket, and never read from it."""
    host = address.removeprefix("http://").rstrip("/")
    name, port = host.split(":")
    with socket.create_connection((name, int(port))) as stalled:
        stalled.sendall(
            f"GET /socket HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
        )
        assert stalled.recv(12).endswith(b"101")
        yield
