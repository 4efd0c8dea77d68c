"""What a replay leaves that is killed at random moments: OUT, the bag, and whether the next works.

Each run is a `worm replay` into a directory that holds an earlier result, ended by SIGKILL at a
moment drawn evenly over a little more than the time that a whole run takes. OUT must then hold the
earlier result or the new one, each file of it, byte for byte; the bag must be as it was; and after
the last of them a run must come to its end.
"""

import argparse
import hashlib
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.table import Table

LARVA = Path(__file__).parents[1] / "bags" / "larva"
EARLIER_S, NEW_S = 0.5, 1.0
PARTS = 12
LONGEST = 1.2
"""The latest moment, as a share of a whole run's time: some runs come to their end."""
SAME_BYTES = ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet",
              "summary.json", "report.html")  # fmt: skip


def replay(bag: Path, out: Path, duration_s: float) -> subprocess.Popen[bytes]:
    """Start a replay of the first seconds of a bag."""
    command = [Path(sys.executable).with_name("worm"), "replay", bag, "--out", out]
    return subprocess.Popen(
        [*map(str, command), "--playback-duration", str(duration_s)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def finish(process: subprocess.Popen[bytes]) -> None:
    """Wait for a replay that must succeed."""
    _, said = process.communicate()
    if process.returncode:
        raise RuntimeError(f"the replay ended with {process.returncode}: {said.decode()}")


def digest(directory: Path) -> str:
    """Return a hash of a result; its bag counts by the names of its files."""
    names = sorted(path.relative_to(directory).as_posix() for path in directory.rglob("*"))
    found = hashlib.sha256("\0".join(names).encode())
    for name in SAME_BYTES:
        found.update((directory / name).read_bytes() if name in names else b"-")
    return found.hexdigest()


def bytes_of(directory: Path) -> dict[str, bytes]:
    """Return each file of a small bag."""
    return {path.name: path.read_bytes() for path in directory.iterdir()}


def killed_replays(runs: int, seed: int) -> Iterator[tuple[float, str]]:
    """Give, for each run, the share of a whole run's time after which it was killed, and OUT.

    OUT is ``earlier``, ``new`` or what is wrong.
    """
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="worm-killed-") as folder:
        top = Path(folder)
        bag, out, kept = top / "bag", top / "out", top / "earlier"
        shutil.copytree(LARVA, bag)
        finish(replay(bag, kept, EARLIER_S))
        began_s = time.perf_counter()
        finish(replay(bag, top / "new", NEW_S))
        whole_s = time.perf_counter() - began_s
        known = {digest(kept): "earlier", digest(top / "new"): "new"}
        for _ in range(runs):
            shutil.rmtree(out, ignore_errors=True)
            shutil.copytree(kept, out)
            share = draw.uniform(0.0, LONGEST)
            process = replay(bag, out, NEW_S)
            time.sleep(share * whole_s)
            process.kill()
            process.communicate()
            state = known.get(digest(out), "neither") if out.exists() else "not there"
            yield share, state if bytes_of(bag) == bytes_of(LARVA) else "the bag changed"
        finish(replay(bag, out, NEW_S))
        if known.get(digest(out)) != "new":
            raise RuntimeError("the run after the last one that was killed is not whole")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    counts: Counter[tuple[int, str]] = Counter()
    for share, state in killed_replays(given.runs, given.seed):
        counts[int(share / LONGEST * PARTS), state] += 1
    states = ["earlier", "new", *sorted({state for _, state in counts} - {"earlier", "new"})]
    table = Table("killed after", *states, title=f"OUT after {given.runs} SIGKILLs")
    for part in range(PARTS):
        row = [str(counts[part, state]) for state in states]
        table.add_row(f"{LONGEST * part / PARTS:.0%} to {LONGEST * (part + 1) / PARTS:.0%}", *row)
    table.add_row("all", *(str(sum(counts[k, s] for k in range(PARTS))) for s in states))
    Console().print(table)
    return 0 if len(states) == 2 else 1


if __name__ == "__main__":
    sys.exit(main())
