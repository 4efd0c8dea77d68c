"""The server gives the page, frames and curves, and lets nobody else change a correction."""

import asyncio
import json
import re
import threading
import urllib.error
import urllib.request

import cv2
import numpy as np
import pytest
from reviewed_trials import FRAMES, small_trial

from worm_monitor.access import Access
from worm_monitor.review.pictures import TrialPictures
from worm_monitor.review.review_server import ReviewServer
from worm_monitor.review.trial import read_reviewed_trial


class Served:
    """A review in a thread of its own."""

    def __init__(self, directory, token=""):
        trial = read_reviewed_trial(directory)
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever)
        self.thread.start()
        access = Access("127.0.0.1", 0, token)
        self.server = ReviewServer(TrialPictures(trial, None), access, "worm replay …")
        self.run(self.server.site.listen())
        self.address = self.server.site.access.address

    def run(self, what):
        return asyncio.run_coroutine_threadsafe(what, self.loop).result()

    def close(self):
        self.run(self.server.close())
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return small_trial(tmp_path_factory.mktemp("reviewed") / "out")


@pytest.fixture(scope="module")
def served(results):
    made = Served(results)
    yield made
    made.close()


def ask(address, body=None, **headers):
    """Return the status, headers and bytes of an answer."""
    request = urllib.request.Request(address, data=body, headers=headers)
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read()


def test_the_page_and_all_that_it_names_are_there_and_nothing_comes_from_elsewhere(served):
    waiting, seen = [""], {}
    while waiting:
        name = waiting.pop()
        status, headers, body = ask(served.address + name)
        assert status == 200, name
        seen[name] = body.decode()
        named = re.findall(r'(?:href|src)="([^"]+)"|from "\./([^"]+)"', seen[name])
        waiting += [one or other for one, other in named if (one or other) not in seen]
    assert {"review.js", "traces.js", "picture.js", "plots.js", "style.css"} <= seen.keys()
    everything = "".join(seen.values())
    assert not [a for a in re.findall(r"https?://[^\"' )>]+", everything) if "w3.org" not in a]
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "unsafe" not in headers["Content-Security-Policy"]


def test_curves_come_as_numbers_a_frame(served):
    told = json.loads(ask(served.address + "trial")[2])
    curves = np.frombuffer(ask(served.address + "columns")[2], np.float32)
    assert told["frames"] == FRAMES
    assert curves.size == FRAMES * len(told["columns"])
    frames = curves.reshape(-1, FRAMES)[told["columns"].index("frame")]
    assert (frames == np.arange(FRAMES)).all()


def test_a_frame_without_a_bag_is_drawn_on_blank_ground_and_says_why(served):
    body = ask(served.address + "frame?row=17")[2]
    length = int.from_bytes(body[:4], "little")
    head = json.loads(body[4 : 4 + length])
    picture = cv2.imdecode(np.frombuffer(body[4 + length :], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert (head["frame"], head["row"]) == (17, 17)
    assert "--bag" in head["why_blank"]
    assert picture.std() < 1.0
    assert head["pose"]["head"][0] < picture.shape[1] / head["scale"]


@pytest.mark.parametrize("row", [str(FRAMES), "-1", "x", "", "1e3", "9" * 30, "²"])
def test_a_frame_that_is_not_there_is_not_found(served, row):
    address = f"{served.address}frame?row={urllib.parse.quote(row)}"
    assert ask(address)[0] == 404


def test_nobody_else_can_change_a_correction(served, results):
    body = json.dumps(
        {"based_on": "none", "add": {"first": 1, "last": 2, "by": "x", "note": ""}}
    ).encode()
    ours = served.address.rstrip("/")
    for headers in (
        {},
        {"Origin": "http://evil.example"},
        {"Origin": ours, "Host": "evil.example"},
        {"Origin": "null"},
    ):
        assert ask(served.address + "corrections", body, **headers)[0] == 403
    assert not (results / "corrections.json").exists()
    assert ask(served.address + "corrections", b"[", Origin=ours)[0] == 400
    assert ask(served.address + "corrections", b"[]", Origin=ours)[0] == 400
    assert ask(served.address + "corrections", b" " * 100_000, Origin=ours)[0] in (400, 413)
    status, _, told = ask(served.address + "corrections", body, Origin=ours)
    assert (status, json.loads(told)["refused"]) == (200, "")
    assert (results / "corrections.json").exists()


def test_without_the_token_nothing_is_there(results):
    made = Served(results, token="secret")
    try:
        bare = made.address.replace("secret/", "")
        for path in ("", "trial", "columns", "frame?row=0", "corrections"):
            assert ask(bare + path)[0] == 404, path
            assert ask(bare + "wrong/" + path)[0] == 404, path
            assert ask(made.address + path)[0] == 200, path
    finally:
        made.close()
