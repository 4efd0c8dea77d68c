"""What the analysis costs: processor time a frame, and each time that the estimates are asked for.

The track is a walk along the wall of known parameters at 30 frames/s. Between two publications of
the estimates (10 s of stamps) lie 300 frames, so the cost in all is that of a frame plus 1/300 of
that of the estimates. Memory is what one analysis holds after a part of the trial and after all.
"""

import sys
import time
import tracemalloc
from pathlib import Path

from rich.console import Console
from rich.table import Table

from worm_analysis.analysis import Analysis
from worm_msgs_py import BodyState

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from walked_tracks import GEOMETRY, slides_and_hops

RATE_HZ = 30.0
TRIAL_S = 1800.0
FRAMES_A_SUMMARY = 300
ROUNDS = 3


def seconds(states: list[BodyState]) -> tuple[float, float]:
    """Return the processor time of pushing all states, and of all estimates once."""
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    begin = time.process_time()
    for state in states:
        analysis.push(state)
    pushed = time.process_time()
    analysis.summary(), analysis.correlation(), analysis.distributions()
    return pushed - begin, time.process_time() - pushed


def held_mb(states: list[BodyState]) -> float:
    """Return the memory that one analysis holds after these states."""
    tracemalloc.start()
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    for state in states:
        analysis.push(state)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return held / 2**20


def main() -> None:
    """Print the table; the best of three rounds, as the machine may be busy."""
    states = slides_and_hops(0, TRIAL_S, RATE_HZ).states()
    rounds = [seconds(states) for _ in range(ROUNDS)]
    frame_us = min(push for push, _ in rounds) / len(states) * 1e6
    estimates_ms = min(ask for _, ask in rounds) * 1e3
    table = Table("analysis", "", title=f"{len(states)} frames of a walk along the wall")
    table.add_row("a frame", f"{frame_us:.1f} µs")
    table.add_row("all estimates once", f"{estimates_ms:.1f} ms")
    table.add_row("a frame in all", f"{frame_us + estimates_ms * 1e3 / FRAMES_A_SUMMARY:.1f} µs")
    for part in (len(states) // 10, len(states)):
        table.add_row(f"memory held after {part} frames", f"{held_mb(states[:part]):.2f} MB")
    Console().print(table)


if __name__ == "__main__":
    main()
