"""What the graph costs: frames/s of the whole graph beside a bare loop over the same bag.

The bare loop reads, decodes, tracks and analyses with the cores alone: no ROS, no files written.
Both ways of running the graph follow in the same run, with the seconds spent in each node.
"""

import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rosbags.typesys import Stores, get_typestore

from worm_analysis.analysis import Analysis
from worm_bringup.node_spec import NodeSpec
from worm_bringup.trial import Trial, run_graph
from worm_tracker.bag_pictures import BagPictures
from worm_tracker.pictures import PictureDecoder
from worm_tracker.tracker import Tracker

BAG = Path(__file__).parents[1] / "bags" / "larva"


def bare_loop(bag: Path) -> tuple[int, dict[str, float]]:
    """Read, decode, track and analyse a bag; return the frames and the seconds of each step."""
    store = get_typestore(Stores.ROS2_JAZZY)
    decoder, tracker, analysis = PictureDecoder(), Tracker(), Analysis()
    spent = dict.fromkeys(("read", "decode", "track", "analyse"), 0.0)
    version = states = 0

    def analyse(frames: list) -> None:
        nonlocal version, states
        for frame in frames:
            if tracker.geometry is not None and tracker.geometry.version != version:
                version = tracker.geometry.version
                analysis.set_geometry(tracker.geometry)
            analysis.push(frame.state)
            states += 1

    with BagPictures(bag) as pictures:
        ticks = [time.perf_counter()]
        for picture in pictures:
            message = store.deserialize_cdr(picture.raw, pictures.type_name)
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


def main() -> None:
    """Print the table."""
    began = time.perf_counter()
    frames, spent = bare_loop(BAG)
    bare_s = time.perf_counter() - began
    table = Table("the same bag", "frames/s", "of the bare loop", "where the time goes")
    table.add_row("bare loop", f"{frames / bare_s:.0f}", "1.00", shares(spent))
    trial = Trial(NodeSpec("worm_tracker.replay_node", "image_source", {"bag": str(BAG)}), {})
    for name, processes in (("graph, one process", False), ("graph, a process a node", True)):
        with tempfile.TemporaryDirectory() as out:
            result = run_graph(trial, Path(out), processes=processes)
        speed = result.frames / result.elapsed_s
        table.add_row(
            name, f"{speed:.0f}", f"{speed * bare_s / frames:.2f}", shares(result.spent_s)
        )
    Console().print(table)


def shares(spent: dict[str, float]) -> str:
    """Return each part's share of the time, in per cent."""
    total = sum(spent.values())
    return ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in spent.items())


if __name__ == "__main__":
    main()
