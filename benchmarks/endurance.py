"""Runs of hours: memory over time as a figure, and whether every frame has its row.

`python -m benchmarks.endurance replay` replays an hour of film at 15 frames/s, with a checkpoint
every ten seconds as `worm replay` makes them.
"""

import tempfile
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import pyarrow.parquet as pq
import typer
from rosbags.typesys import Stores, get_typestore

from benchmarks.memory import draw, sampled_memory
from worm_bringup.checkpoints import CheckpointFolder, Checkpoints
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.trial import Trial, run_trial
from worm_model.simulator.film import encode, write_picture_bag
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.playback import in_a_loop

ROOT = Path(__file__).parents[1]
LARVA = ROOT / "bags" / "larva"

app = typer.Typer(add_completion=False)


@app.callback()
def endurance() -> None:
    """Run the graph for long, and watch its memory."""


@app.command()
def replay(
    frames: Annotated[int, typer.Option(help="Length of the film.")] = 54_000,
    side_px: Annotated[int, typer.Option(help="Side of its square pictures.")] = 1024,
    figure: Annotated[Path, typer.Option(help="PNG to write.")] = ROOT
    / "docs"
    / "endurance_replay.png",
) -> None:
    """Replay the larva's film again and again, as one trial."""
    with tempfile.TemporaryDirectory() as folder:
        bag, out = Path(folder) / "long", Path(folder) / "out"
        write_picture_bag(bag, islice(looped_film(side_px), frames))
        print(f"{frames} pictures of {side_px} x {side_px} px in {_mib(bag):.0f} MiB", flush=True)
        trial = Trial(
            NodeSpec("worm_tracker.sources.replay_node", "image_source", {"bag": str(bag)}),
            {"bag": bag.name},
        )
        checkpoints = _Timed(CheckpointFolder(out), trial.fingerprint, say=print)
        began_s, began_cpu_s = time.monotonic(), time.process_time()
        with sampled_memory() as trace:
            run_trial(trial, out, trace.progress, checkpoints=checkpoints)
        elapsed_s = time.monotonic() - began_s
        cost = checkpoints.spent_s / (time.process_time() - began_cpu_s)
        rows = pq.read_metadata(out / "tracks.parquet").num_rows
    title = f"replay of {frames} frames, {side_px} x {side_px} px"
    draw({title: trace}, figure)
    print(
        f"{rows} rows in {elapsed_s / 60:.1f} min, {checkpoints.made} checkpoints "
        f"({cost:.1%} of the processor's time); "
        f"peak {max(trace.resident_mib):.0f} MiB, "
        f"{trace.growth():+.2%} after the first minute; {figure}"
    )
    if rows != frames:
        raise SystemExit(f"{frames} frames were replayed, {rows} have a row")


class _Timed(Checkpoints):
    """Checkpoints that are counted, and what they cost of the processor."""

    made = 0
    spent_s = 0.0

    def save(self) -> None:
        began_s = time.process_time()
        super().save()
        self.spent_s += time.process_time() - began_s
        self.made += 1


def looped_film(side_px: int) -> Iterator[tuple[int, bytes]]:
    """Yield the larva's pictures, scaled, in a loop without end: stamp and JPEG file."""
    store = get_typestore(Stores.ROS2_JAZZY)
    scaled: dict[int, bytes] = {}
    with BagPictures(LARVA) as pictures:
        for picture in in_a_loop(pictures):
            if picture.index not in scaled:
                data = store.deserialize_cdr(picture.raw, pictures.message_type).data
                scaled[picture.index] = _scaled(np.asarray(data), side_px)
            yield picture.stamp_ns, scaled[picture.index]


def _scaled(data: np.ndarray, side_px: int) -> bytes:
    grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    if grey.shape == (side_px, side_px):
        return data.tobytes()
    return encode(cv2.resize(grey, (side_px, side_px), interpolation=cv2.INTER_AREA), 90)


def _mib(folder: Path) -> float:
    return sum(file.stat().st_size for file in folder.iterdir()) / 2**20


if __name__ == "__main__":
    app()
