"""A live run of eight hours in minutes: a real server, a clock that runs fast, ten real outages.

`python -m benchmarks.endurance_live` serves the larva's film, there and back again, as MJPEG from a
process of its own, and drops the connection ten times. The graph of `worm live` takes what it can,
records it and writes results. Held against each other: the outages in the summary, the frames sent,
rows and recorded pictures; and a replay of the record must give the same tables. Only the camera's
clock is not the real one: it runs `--speed` times as fast.
"""

import json
import multiprocessing
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import count
from pathlib import Path
from typing import Annotated

import cv2
import pyarrow.parquet as pq
import typer

import worm_tracker.sources.cameras.camera
from benchmarks.memory import MemoryTrace, draw, sampled_memory
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.trial import Trial, run_trial
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.sources.cameras.steady_clock import SteadyClock

ROOT = Path(__file__).parents[1]
LARVA = ROOT / "bags" / "larva"
OUTAGES = 10
TABLES = ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet")


class FastClock(SteadyClock):
    """A clock that runs faster than time."""

    speed = 1.0

    def __init__(self) -> None:
        super().__init__()
        self._began_ns = super().now_ns()

    def now_ns(self) -> int:
        """Return nanoseconds since 1970 by this clock."""
        return self._began_ns + round(self.speed * (super().now_ns() - self._began_ns))


def film(side_px: int) -> list[bytes]:
    """Return the larva's pictures, scaled, as JPEG, there and back again."""
    there = []
    for grey, _ in pictures_of_bag(LARVA):
        small = cv2.resize(grey, (side_px, side_px), interpolation=cv2.INTER_AREA)
        there.append(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 92])[1].tobytes())
    return there + there[-2:0:-1]


def serve(
    pictures_of: Callable[[], list[bytes]],
    fps: float,
    drops: list[float],
    outage_s: float,
    port: object,
) -> None:
    """Serve a film, a picture every 1 / fps; drop the connection at these seconds."""
    pictures = pictures_of()
    numbers = count()
    began_s = 0.0
    away_until_s = 0.0

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            nonlocal began_s, away_until_s
            began_s = began_s or time.monotonic()
            if time.monotonic() < away_until_s:
                self.send_error(503)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            due_s = time.monotonic()
            while True:
                if drops and time.monotonic() - began_s > drops[0]:
                    drops.pop(0)
                    away_until_s = time.monotonic() + outage_s
                    return
                jpeg = pictures[next(numbers) % len(pictures)]
                head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                try:
                    self.wfile.write(head.encode() + jpeg + b"\r\n")
                except OSError:
                    return
                due_s = max(due_s + 1.0 / fps, time.monotonic() - 1.0)
                time.sleep(max(0.0, due_s - time.monotonic()))

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    port.put(server.server_port)  # type: ignore[attr-defined]
    server.serve_forever()


@contextmanager
def camera(*arguments: object):
    """Serve from a process of its own, so that its memory is not ours."""
    context = multiprocessing.get_context("spawn")
    port = context.Queue()
    process = context.Process(target=serve, args=(*arguments, port), daemon=True)
    process.start()
    try:
        yield f"http://127.0.0.1:{port.get(timeout=120)}/"
    finally:
        process.terminate()
        process.join()


def run_live(address: str, out: Path, record: Path, run_s: float) -> MemoryTrace:
    """Run the graph of `worm live` for `run_s`, then end it as Ctrl-C does; return its memory."""
    source = {
        "camera": address,
        "record": str(record),
        "stall": 5.0 * FastClock.speed,  # by the camera's clock
        "reconnect_delay": 0.1,
    }
    trial = Trial(
        NodeSpec("worm_tracker.sources.camera_node", "image_source", source), {"camera": address}
    )
    threading.Timer(run_s, os.kill, (os.getpid(), signal.SIGINT)).start()
    with sampled_memory(descendants=False) as trace:
        run_trial(trial, out, trace.progress, live=True)
    return trace


def check(out: Path, record: Path, again: Path) -> dict[str, object]:
    """Return what the run can be held to."""
    summary = json.loads((out / "summary.json").read_text())
    rows = pq.read_metadata(out / "tracks.parquet").num_rows
    with BagPictures(record) as pictures:
        stamps = [picture.stamp_ns for picture in pictures]
    events = [event for event in summary["source_events"] if event["kind"] == "outage"]
    run_trial(
        Trial(
            NodeSpec("worm_tracker.sources.replay_node", "image_source", {"bag": str(record)}), {}
        ),
        again,
    )
    same = [(out / name).read_bytes() == (again / name).read_bytes() for name in TABLES]
    return {
        "complete": summary["complete"],
        "outages in the summary": len(events),
        "seconds without pictures (camera's clock)": round(
            sum(event["duration_s"] for event in events)
        ),
        "frames sent": summary["frames"]["read"],
        "rows": rows,
        "pictures in the record": len(stamps),
        "hours from first to last": round((stamps[-1] - stamps[0]) / 3.6e12, 3),
        "tracked": summary["frames"]["tracked"],
        "replay of the record gives the same tables": all(same),
    }


def main(
    hours: Annotated[float, typer.Option(help="By the camera's clock.")] = 8.0,
    speed: Annotated[float, typer.Option(help="How much faster that clock is.")] = 40.0,
    rate: Annotated[float, typer.Option(help="Pictures a second by the camera's clock.")] = 5.0,
    side_px: Annotated[int, typer.Option(help="Side of the square pictures.")] = 256,
    figure: Annotated[Path, typer.Option(help="PNG to write.")] = ROOT
    / "docs"
    / "endurance_live.png",
) -> None:
    """Run it, check it, draw its memory."""
    FastClock.speed = speed
    worm_tracker.sources.cameras.camera.SteadyClock = FastClock  # type: ignore[misc]
    run_s = hours * 3600 / speed
    with tempfile.TemporaryDirectory() as folder:
        out, record, again = (Path(folder) / name for name in ("out", "record", "again"))
        drops = [run_s * (k + 1) / (OUTAGES + 1) for k in range(OUTAGES)]
        with camera(partial(film, side_px), rate * speed, drops, 2.0) as address:
            trace = run_live(address, out, record, run_s)
        frames = [
            event["frame"]
            for event in json.loads((out / "summary.json").read_text())["source_events"]
        ]
        title = f"live, {hours:g} h of the camera's clock"
        draw({title: trace}, figure, {title: frames})
        found = check(out, record, again)
    for what, value in found.items():
        print(f"{what}: {value}", flush=True)
    print(
        f"memory: peak {max(trace.resident_mib):.0f} MiB, {trace.growth():+.2%} after the first "
        f"minute, {len(trace.frames)} samples in {trace.elapsed_s[-1]:.0f} s; {figure}"
    )
    counted = {found[key] for key in ("frames sent", "rows", "pictures in the record")}
    whole = found["complete"] and found["replay of the record gives the same tables"]
    if not whole or found["outages in the summary"] != OUTAGES or len(counted) != 1:
        raise SystemExit("the run is not what it should be")


if __name__ == "__main__":
    typer.run(main)
