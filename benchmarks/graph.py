"""What the graph costs: frames/s of the whole graph beside a bare loop over the same bag.

The bare loop reads, decodes, tracks and analyses with the cores alone: no ROS, no files written.
The ways of running the graph follow in the same run, with the seconds spent in each node; one is
with the parameter services that a graph has which others can see.
"""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any
from unittest.mock import patch

from rich.console import Console
from rich.table import Table
from rosbags.typesys import Stores, get_typestore
from threadpoolctl import threadpool_limits

from worm_analysis.analysis import Analysis
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.trial import Trial, run_graph
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.tracker import Tracker

BAG = Path(__file__).parents[1] / "bags" / "larva"
ROUNDS = 3


def bare_loop(bag: Path) -> tuple[int, dict[str, float]]:
    """Read, decode, track and analyse a bag; return the frames and the seconds of each step."""
    store = get_typestore(Stores.ROS2_JAZZY)
    decoder, tracker, analysis = PictureDecoder(), Tracker(TrackerParameters()), Analysis()
    spent = dict.fromkeys(("read", "decode", "track", "analyse"), 0.0)
    states = 0

    def analyse(frames: list) -> None:
        nonlocal states
        for frame in frames:
            analysis.push(frame)
            states += 1

    with BagPictures(bag) as pictures:
        ticks = [time.perf_counter()]
        for picture in pictures:
            message = store.deserialize_cdr(picture.raw, pictures.message_type)
            ticks.append(time.perf_counter())
            grey = decoder.decode(message)
            ticks.append(time.perf_counter())
            frames = tracker.push(grey, picture.stamp_ns)
            ticks.append(time.perf_counter())
            analyse(frames)
            ticks.append(time.perf_counter())
            for step, begin, end in zip(spent, ticks, ticks[1:], strict=False):
                spent[step] += end - begin
            ticks = [time.perf_counter()]
    analyse(tracker.finish())
    return states, spent


def timed_bare_loop() -> tuple[float, dict[str, float]]:
    """Return frames/s and the seconds of each step."""
    began = time.perf_counter()
    with threadpool_limits(1):  # as in the graph
        frames, spent = bare_loop(BAG)
    return frames / (time.perf_counter() - began), spent


def timed_graph(*, processes: bool) -> tuple[float, dict[str, float]]:
    """Return frames/s and the seconds of each node's callbacks; files are written."""
    trial = Trial(
        NodeSpec("worm_tracker.sources.replay_node", "image_source", {"bag": str(BAG)}), {}
    )
    with tempfile.TemporaryDirectory() as out:
        result = run_graph(trial, Path(out), processes=processes)
    spent = result.spent_s
    if spent:
        spent = spent | {"executor": result.elapsed_s - sum(spent.values())}
    return result.frames / result.elapsed_s, spent


def timed_served_graph() -> tuple[float, dict[str, float]]:
    """As `timed_graph` in one process, its nodes with parameter services."""
    make = NodeSpec.make

    def with_services(spec: NodeSpec, **how: Any) -> Any:
        return make(spec, **(how | {"served": True}))

    with patch.object(NodeSpec, "make", with_services):
        return timed_graph(processes=False)


def main() -> None:
    """Run each way in turn, several rounds, and print the medians."""
    ways: dict[str, Callable[[], tuple[float, dict[str, float]]]] = {
        "bare loop": timed_bare_loop,
        "graph, one process": partial(timed_graph, processes=False),
        "graph, parameter services": timed_served_graph,
        "graph, a process a node": partial(timed_graph, processes=True),
    }
    rounds = [{name: way() for name, way in ways.items()} for _ in range(ROUNDS)]
    table = Table("the same bag", "frames/s", "of the bare loop", "where the time goes")
    for name in ways:
        speed = median(results[name][0] for results in rounds)
        ratio = median(results[name][0] / results["bare loop"][0] for results in rounds)
        table.add_row(name, f"{speed:.0f}", f"{ratio:.2f}", shares(rounds[-1][name][1]))
    Console().print(table)


def shares(spent: dict[str, float]) -> str:
    """Return each part's share of the time, in per cent."""
    total = sum(spent.values())
    return ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in spent.items())


if __name__ == "__main__":
    main()
