"""The review page as people use it, in a real Chromium; what it corrects a replay then applies."""

import json
import shlex
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from browser_tab import NEEDS_CHROMIUM, WINDOWS, Tab, page_of, running_chromium
from forked_commands import worm

pytestmark = NEEDS_CHROMIUM
BAG = Path(__file__).parents[3] / "bags" / "trial"
PLAYED_S = 12
FRAMES = 120
TABLES = ("tracks.parquet", "contacts.parquet", "passages.parquet", "summary.json")


def run(*words):
    done = worm(*words)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    out = tmp_path_factory.mktemp("reviewed") / "out"
    run("replay", BAG, "--out", out, "--playback-duration", PLAYED_S)
    return out


def reviewed(results):
    """Give the address of a review, and see it to its end."""
    return page_of(("review", results, "--bag", BAG), "stdout", ends_by_itself=False)


@pytest.fixture(scope="module")
def chromium():
    with running_chromium() as browser:
        yield browser


class ReviewTab(Tab):
    """The page of a trial that is over."""

    def __init__(self, browser, address, *how):
        super().__init__(browser, address, *how)
        self.until_frame(0)

    def until_frame(self, frame):
        """Wait until the picture of a frame is shown, and the plots stand at it."""
        told = "frame => document.getElementById('stamp').innerText.split(/frame |,/)[2] == frame"
        self.until(told, frame)
        assert self.text("tiles").split("\n")[1].startswith(f"{frame} of")

    def until_listed(self, entries):
        self.until("n => document.querySelectorAll('#entries button').length === n", entries)

    def click_plot(self, name, share, to=None):
        """Click a plot at a share of its time axis, or drag from it to another one."""
        box = self.page.locator(f"#{name}").bounding_box()
        left, right = 38, box["width"] - 6
        x = [box["x"] + left + part * (right - left) for part in (share, to or share)]
        y = box["y"] + box["height"] / 2
        self.page.mouse.move(x[0], y)
        self.page.mouse.down()
        self.page.mouse.move(x[1], y, steps=4)
        self.page.mouse.up()

    def dots(self):
        """Where the canvas has the colours of head and tail, px."""
        return self.page.evaluate(
            """() => {
            const canvas = document.getElementById("picture");
            const pen = new OffscreenCanvas(canvas.width, canvas.height)
              .getContext("2d", { willReadFrequently: true });
            pen.drawImage(canvas, 0, 0);
            const { data } = pen.getImageData(0, 0, canvas.width, canvas.height);
            const found = {};
            for (const [name, colour] of [["head", [0, 114, 178]], ["tail", [0, 158, 115]]]) {
              let n = 0, u = 0, v = 0;
              for (let k = 0; k < data.length; k += 4) {
                if (colour.every((level, c) => data[k + c] === level)) {
                  n += 1; u += (k / 4) % canvas.width; v += Math.floor(k / 4 / canvas.width);
                }
              }
              found[name] = [u / n, v / n];
            }
            return found;
        }"""
        )


@pytest.fixture(scope="module")
def corrected(chromium, results):
    """Correct a stretch on the page; give what the page said, and its command."""
    with reviewed(results) as address:
        tab, other = ReviewTab(chromium, address), ReviewTab(chromium, address)
        seen = look_around(tab)
        tab.click_plot("theta", 0.25, to=0.5)
        first, last = (int(tab.page.input_value(f"#{name}")) for name in ("first", "last"))
        assert abs(first - 30) <= 1
        assert abs(last - 60) <= 1
        tab.page.fill("#frame", str(first + 5))
        tab.page.press("#frame", "Enter")
        tab.until_frame(first + 5)
        before = tab.dots()
        tab.page.fill("#by", "M. P.")
        tab.page.fill("#note", "it turned in the fold")
        tab.page.click("#exchange button")
        tab.until_listed(1)
        tab.until("() => document.getElementById('stamp').innerText.endsWith('exchanged')")
        seen |= {"range": (first, last), "dots": (before, tab.dots())}
        seen["effect"], seen["entry"] = tab.text("effect"), tab.text("entries")
        seen["tiles"] = tab.text("tiles")

        other.until_listed(1)  # without being told to look
        in_the_way(tab, other, results)
        seen["command"] = tab.text("command")
        assert tab.wrong == other.wrong == []
        assert all(url.startswith((address, "blob:")) for url in (*tab.asked, *other.asked))
        for each in (tab, other):
            each.page.close()
    return seen


def look_around(tab):
    """Click a plot, an event, keys: each leads to its frame."""
    tab.click_plot("radius", 0.5)
    tab.until("() => Math.abs(Number(document.getElementById('frame').value) - 60) <= 1")
    clicked = int(tab.page.input_value("#frame"))
    tab.until_frame(clicked)
    tab.page.keyboard.press("ArrowRight")
    tab.until_frame(clicked + 1)
    tab.page.keyboard.press("Shift+ArrowLeft")
    tab.until_frame(clicked - 29)
    tab.page.keyboard.press("End")
    tab.until_frame(FRAMES - 1)
    tab.page.keyboard.press("Home")
    tab.until_frame(0)
    tab.page.select_option("#kind", "contact")
    kinds = tab.page.locator("#events li span:nth-child(2)").all_inner_texts()
    assert kinds
    assert set(kinds) == {"contact"}
    time = tab.page.locator("#events li").nth(1).locator("time").inner_text()
    tab.page.locator("#events li").nth(1).click()
    tab.until("time => document.getElementById('clock').innerText.endsWith(time)", time)
    tab.page.keyboard.press("+")
    tab.until("() => !document.querySelector('#spans [aria-pressed=true]')")
    tab.page.click("#spans [data-span='0']")
    return {"name": tab.text("name")}


def in_the_way(tab, other, results):
    """Somebody who saw an older list is told, and what the first one did stays."""
    stale = json.loads((results / "corrections.json").read_text())
    held = []  # it does not hear of the change that follows
    other.page.route("**/corrections", lambda route: held.append(route))
    other.page.fill("#first", "100")
    other.page.fill("#last", "110")
    other.page.fill("#by", "somebody")
    tab.page.fill("#first", "90")
    tab.page.fill("#last", "95")
    tab.page.click("#exchange button")
    tab.until_listed(2)
    other.page.unroute("**/corrections")
    other.page.click("#exchange button")
    for route in held:
        route.continue_()
    other.until("() => document.getElementById('refused').innerText.includes('somebody else')")
    other.until_listed(2)
    tab.page.locator("#entries button").nth(1).click()
    tab.until_listed(1)
    assert json.loads((results / "corrections.json").read_text()) == stale


def test_a_correction_is_in_the_file_with_its_person_and_note(corrected, results):
    first, last = corrected["range"]
    (entry,) = json.loads((results / "corrections.json").read_text())["corrections"]
    stamps = pq.read_table(results / "tracks.parquet")["stamp_ns"].to_pylist()
    assert (entry["what"], entry["by"], entry["note"]) == (
        "swap_head", "M. P.", "it turned in the fold",
    )  # fmt: skip
    assert (entry["first_frame"], entry["last_frame"]) == (first, last)
    assert (entry["first_stamp_ns"], entry["last_stamp_ns"]) == (stamps[first], stamps[last])


def test_the_page_shows_the_exchange_at_once_and_says_what_does_not_change(corrected, results):
    first, last = corrected["range"]
    before, after = corrected["dots"]
    for one, its in (("head", "tail"), ("tail", "head")):
        assert np.allclose(after[one], before[its], atol=1.5), one
    assert np.hypot(*np.subtract(before["head"], before["tail"])) > 20
    assert f"from frame {first} to {last}" in corrected["entry"]
    assert "M. P." in corrected["entry"]
    assert corrected["effect"].startswith(f"{last - first + 1} frames are shown exchanged")
    assert "only with a replay" in corrected["effect"]
    assert "set by a person" in corrected["tiles"]


def test_the_command_of_the_page_replays_the_trial_corrected_the_same_twice(corrected, results):
    first, last = corrected["range"]
    command = shlex.split(corrected["command"])
    assert command[:2] == ["worm", "replay"]
    out = Path(command[command.index("--out") + 1])
    run(*command[1:])
    once = {name: (out / name).read_bytes() for name in TABLES}
    shutil.rmtree(out)
    run(*command[1:])
    assert {name: (out / name).read_bytes() for name in TABLES} == once
    told = json.loads(once["summary.json"])["corrections"]
    assert told["frames_swapped"] == last - first + 1
    assert [entry["first_frame"] for entry in told["applied"]] == [first]
    swapped, plain = (points(place) for place in (out, results))
    inside = np.zeros(FRAMES, dtype=bool)
    inside[first : last + 1] = True
    for one, its in (("head", "tail"), ("tail", "head")):
        assert np.allclose(swapped[one][~inside], plain[one][~inside])
        assert np.allclose(swapped[one][inside], plain[its][inside], atol=0.5)


def points(out):
    table = pq.read_table(out / "tracks.parquet")
    return {
        name: np.stack([table[f"{name}_{axis}_px"].to_numpy() for axis in "uv"], axis=1)
        for name in ("head", "tail")
    }


def test_everything_fits_the_window(chromium, results):
    with reviewed(results) as address:
        for size in WINDOWS:
            for scheme in ("light", "dark"):
                tab = ReviewTab(chromium, address, size, scheme)
                wide = tab.page.evaluate("() => document.scrollingElement.scrollWidth")
                assert wide <= size[0]
                assert tab.wrong == []
                tab.page.close()
        no_peak_of_a_long_trial_is_left_out(ReviewTab(chromium, address))


def no_peak_of_a_long_trial_is_left_out(tab):
    """Of half an hour at thirty frames a second one frame is seen, and a gap is no line."""
    seen = tab.page.evaluate(
        """async () => {
        const { bands, trace } = await import("./traces.js");
        const n = 54000, ts = Float32Array.from({ length: n }, (_, k) => k / 30);
        const values = new Float32Array(n);
        values[31234] = 1; values[40000] = -1;
        values.fill(NaN, 5000, 8000);
        const canvas = new OffscreenCanvas(600, 100), pen = canvas.getContext("2d");
        const place = { pen, left: 0, right: 600, top: 0, bottom: 100,
          px: (t) => (t * 600) / 1800, py: (value) => 50 - 40 * value };
        trace(place, ts, values, [0, n], "#000", { gap: 0.1 });
        bands(place, ts, [[20000, 20000]], "#f00", [0, 0.1]);
        const inked = (x, y) => pen.getImageData(x - 2, y - 2, 5, 5).data.some((level) => level);
        const at = (k) => Math.round((k * 600) / n);
        return [inked(at(31234), 12), inked(at(40000), 88), inked(at(25000), 50),
          inked(at(6500), 50), inked(at(20000), 5), inked(at(21000), 5)];
    }"""
    )
    assert seen == [True, True, True, False, True, False]
    tab.page.close()
