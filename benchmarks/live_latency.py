"""A live trial as the rig runs it: what is skipped, and how late poses are published.

`python -m benchmarks.live_latency FILM` serves a film as MJPEG from a process of its own: a bag of
JPEG pictures, such as that of `worm simulate --one-chamber --minutes 3`, or one of a folding worm
that `benchmarks.folds` keeps as `.npz`. It is played there and back again where the trial is
longer: where a film begins anew its worm leaps, as no worm does, and is looked for everywhere;
where it goes back its worm crawls with the tail ahead.
The graph of `worm live` tracks it, records every picture and writes results. Counted are the
pictures that were skipped, and the time from the capture of each frame to the publication of its
state; frames that the tracker holds back on purpose, until the head is known, are counted apart.
`--watched` shows the trial on the monitor's page in a real Chromium, and adds what the monitor's
process takes of a core.
`--at-once` lets it hold none back.
"""

import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage

from benchmarks.endurance_live import camera
from benchmarks.fold_films import read_film
from worm_bringup.graph.monitor_process import Monitor
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.trial import Trial, run_trial
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.tracker_node import TrackerNode

BAR_MS = 30.0


def pictures_of(film: Path) -> list[bytes]:
    """Return a film's JPEG pictures as they are, there and back again."""
    there = _of_folds(film) if film.suffix == ".npz" else _of_bag(film)
    return there + there[-2:0:-1]


def _of_bag(bag: Path) -> list[bytes]:
    with BagPictures(bag) as pictures:
        return [
            bytes(deserialize_message(picture.raw, CompressedImage).data) for picture in pictures
        ]


def _of_folds(kept: Path) -> list[bytes]:
    film = read_film(kept)
    return [film.jpeg_of(frame).tobytes() for frame in range(len(film))]


class Timing:
    """Notes when each frame was sent and its state published, beside the nodes themselves."""

    def __init__(self) -> None:
        self.sent: list[tuple[float, int]] = []  # seconds, frames skipped until then
        self.late_ms: list[float] = []
        self.held: list[bool] = []
        self._publish_next, self._publish = CameraNode.publish_next, TrackerNode._publish

    def __enter__(self) -> "Timing":
        timing = self

        def publish_next(node: CameraNode) -> bool:
            timing.sent.append((time.monotonic(), node._camera.counts.skipped))
            return timing._publish_next(node)

        def publish(node: TrackerNode, given: list[Any]) -> None:
            timing._publish(node, given)
            now_ns = time.time_ns()
            for frame in given:
                timing.late_ms.append((now_ns - frame.state.stamp_ns) / 1e6)
                timing.held.append(frame.state.stamp_ns != node._last_ns)

        CameraNode.publish_next, TrackerNode._publish = publish_next, publish  # type: ignore[method-assign]
        return self

    def __exit__(self, *_: object) -> None:
        CameraNode.publish_next = self._publish_next  # type: ignore[method-assign]
        TrackerNode._publish = self._publish  # type: ignore[method-assign]


class Watching:
    """A browser on the page, and the processor's time of the process that serves it."""

    def __init__(self, folder: Path) -> None:
        self.monitor = Monitor({"port": 0}, self._open)
        self._folder = folder
        self._browser: subprocess.Popen[bytes] | None = None
        self._ended = threading.Event()
        self.spent: list[tuple[float, float]] = []  # seconds of the clock, of the processor

    def _open(self, line: str) -> None:
        if "http" not in line:
            print(line)
            return
        chromium = shutil.which("chromium") or shutil.which("chromium-browser") or ""
        how = ["--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1280,800"]
        where = [f"--user-data-dir={self._folder / 'browser'}", "--remote-debugging-port=0"]
        self._browser = subprocess.Popen(
            [chromium, *how, *where, line.split()[-1]],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        threading.Thread(target=self._sample, daemon=True).start()

    def _sample(self) -> None:
        children = Path(f"/proc/{os.getpid()}/task").glob("*/children")
        numbers = [int(number) for task in children for number in task.read_text().split()]
        served_by = next(
            number
            for number in numbers
            if "worm_monitor" in Path(f"/proc/{number}/cmdline").read_text()
        )
        while not self._ended.wait(1.0):
            try:
                fields = Path(f"/proc/{served_by}/stat").read_text().rpartition(")")[2].split()
            except FileNotFoundError:  # the trial has ended
                return
            ticks = int(fields[11]) + int(fields[12])
            self.spent.append((time.monotonic(), ticks / os.sysconf("SC_CLK_TCK")))

    def close(self) -> None:
        """Close the browser, and say what the page has cost."""
        self._ended.set()
        if self._browser is not None:
            self._browser.terminate()
            self._browser.wait()
        (began_s, before_s), (ended_s, after_s) = self.spent[5], self.spent[-1]
        share = (after_s - before_s) / (ended_s - began_s)
        print(f"monitor: {share:.1%} of a core over {ended_s - began_s:.0f} s, page open")


def main(
    film: Annotated[Path, typer.Argument(help="A bag of JPEG pictures, or a film of folds.")],
    minutes: Annotated[float, typer.Option(help="How long to film.")] = 2.0,
    fps: Annotated[float, typer.Option(help="Pictures a second.")] = 30.0,
    watched: Annotated[
        bool, typer.Option("--watched", help="Show it on the page, in a Chromium.")
    ] = False,
    at_once: Annotated[bool, typer.Option("--at-once", help="Hold no frame back.")] = False,
) -> None:
    """Film, and print what was skipped and how late poses were."""
    with tempfile.TemporaryDirectory() as folder, Timing() as timing:
        out, record = Path(folder) / "out", Path(folder) / "record"
        with camera(partial(pictures_of, film), fps, [], 0.0) as address:
            source = {"camera": address, "record": str(record)}
            module = "worm_tracker.sources.camera_node"
            tracker = {"hold_back_frames": 0} if at_once else {}
            trial = Trial(NodeSpec(module, "image_source", source), {"camera": address}, tracker)

            def end_in_time(sent: int, expected: int | None) -> None:
                if sent and not ending.ident:
                    ending.start()

            ending = threading.Timer(60.0 * minutes, os.kill, (os.getpid(), signal.SIGINT))
            load = os.getloadavg()
            watching = Watching(Path(folder)) if watched else None
            page = {"monitor": watching.monitor} if watching else {}
            processor_s = time.process_time()
            result, _ = run_trial(trial, out, end_in_time, live=True, **page)
            processor_s = time.process_time() - processor_s
            if watching:
                watching.close()
    counts = result.counts
    first_second = max(skipped for at_s, skipped in timing.sent if at_s < timing.sent[0][0] + 1.0)
    late, held = np.array(timing.late_ms), np.array(timing.held)
    print(f"load before {load[0]:.1f}, after {os.getloadavg()[0]:.1f}; {os.cpu_count()} cores")
    print(f"{result.frames} frames sent in {result.elapsed_s:.0f} s; {counts}")
    print(f"skipped: {first_second} in the first second, {counts['frames skipped']} in all")
    spent = {name: f"{1e3 * s / result.frames:.1f}" for name, s in result.spent_s.items()}
    print(f"ms a frame: {spent}; processor, all threads: {1e3 * processor_s / result.frames:.1f}")
    gaps_ms = [1e3 * (b - a) for (a, _), (b, _) in pairwise(timing.sent)]
    print(f"longest time between two frames sent: {max(gaps_ms):.0f} ms")
    known = int(np.argmax(~held))  # the first frame that was not held back
    for what, some in (
        ("all", late),
        ("not held back", late[~held]),
        (f"all from frame {known} on, when the head is known", late[known:]),
    ):
        shares = ", ".join(f"{p} % {np.percentile(some, p):.1f}" for p in (50, 95, 99, 99.9, 100))
        print(f"capture → poses published, {what} ({len(some)}), ms: {shares}")
    print(f"within {BAR_MS:g} ms: {np.mean(late <= BAR_MS):.2%} of all")


if __name__ == "__main__":
    typer.run(main)
