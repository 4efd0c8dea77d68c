"""Damages bags at random and sees what becomes of them: `python -m benchmarks.fuzz_bags`."""

import argparse
import json
import queue
import random
import re
import resource
import select
import subprocess
import sys
import tempfile
import time
import traceback
from binascii import crc32
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import fuzz_mutations as mutations
from benchmarks.fuzz_scan import readable
from worm_msgs_py.errors import BadInput, BadPicture
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.scan.scan import scan_bag
from worm_tracker.sources.bags.scan.scan_result import FoundMessage
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.tracker import Tracker

CASE_S = 120.0
MEMORY = 3 << 30
_NOTHING = np.empty((0, 0), np.uint8)
THROUGH_THE_COMMAND = 500
"""Every so many-th case also goes through `worm replay`."""


@dataclass
class Outcome:
    """What became of one damaged bag.

    Attributes
    ----------
    case : int
    kind : str
        Storage and form of the pictures.
    faults : list of str
        What went wrong: traceback, silent loss, a line that does not help.
    refused, salvage_refused : bool
        Whether it was refused with one line, as it is and with --salvage.
    recorded, readable, saved : int
        Messages that the bag held; of these what an independent scan reads unchanged; of those
        what --salvage reads unchanged.
    """

    case: int
    kind: str
    faults: list[str]
    refused: bool = False
    salvage_refused: bool = False
    recorded: int = 0
    readable: int = 0
    saved: int = 0


def run_case(case: int, seed: int, seeds: Path) -> Outcome:
    """Damage one bag and read it in every way."""
    rng = random.Random(f"{seed} {case}")
    storage, picture = rng.choice(mutations.STORAGES), rng.choice(mutations.PICTURES)
    outcome = Outcome(case, f"{storage}, {picture}", [])
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        bag = mutations.damage(Path(folder), storage, picture, seeds, rng)
        original = {(log_ns, crc32(data)) for log_ns, data in mutations.messages(picture)}
        outcome.recorded = len(original)
        can_be_read = original & readable(mutations.storage_file(bag))
        outcome.readable = len(can_be_read)
        for salvage in (False, True):
            try:
                _read(bag, salvage, picture, len(can_be_read), outcome, case % 4 == salvage)
            except BadInput as error:
                _check_line(str(error), bag, outcome)
                if salvage:
                    outcome.salvage_refused = True
                else:
                    outcome.refused = True
            except Exception:
                outcome.faults.append(f"traceback: {traceback.format_exc(limit=-3)}")
        with suppress(Exception):  # told above
            outcome.saved = len(can_be_read & _scanned(bag))
        if outcome.saved < outcome.readable:
            print(f"case {case}: {outcome.saved} of {outcome.readable}", file=sys.stderr)
        if case % THROUGH_THE_COMMAND == 0:
            _through_the_command(bag, Path(folder) / "out", case, outcome)
    return outcome


def _read(
    bag: Path, salvage: bool, picture: str, can_be_read: int, outcome: Outcome, track: bool
) -> None:
    """Read a bag as the graph does, and count what comes out."""
    frames, said = 0, 0
    decoder, tracker = PictureDecoder(), Tracker(TrackerParameters(no_chamber=True))
    given = 0
    with BagPictures(bag, salvage=salvage) as pictures:
        for item in pictures:
            frames += 1
            said += item.why_bad != ""
            with suppress(BadInput, BadPicture):
                grey = decoder.decode(read_picture(item.raw, pictures.message_type))
                if track:
                    given += len(tracker.push(grey, item.stamp_ns))
                    continue
            if track:
                given += len(tracker.push(_NOTHING, item.stamp_ns))
        said += len(pictures.losses)
    if track and given + len(tracker.finish()) != frames:
        outcome.faults.append("silent loss: the tracker gave fewer frames than it took")
    if frames < can_be_read and not said:
        outcome.faults.append(f"silent loss: {frames} of {can_be_read} frames, salvage {salvage}")
    elif frames < outcome.recorded and not said:
        outcome.faults.append(f"unsaid: {frames} of {outcome.recorded} recorded, {salvage}")


def _scanned(bag: Path) -> set[tuple[int, int]]:
    return {
        (found.log_ns, crc32(found.data))
        for found in scan_bag(bag)
        if isinstance(found, FoundMessage)
    }


def _check_line(line: str, bag: Path, outcome: Outcome) -> None:
    """See that a refusal is one line with the bag's name and a reason."""
    if "\n" in line or str(bag) not in line or re.search(r"\(\)|\( *;|: *;", line):
        outcome.faults.append(f"a line that does not help: {line}")


def _through_the_command(bag: Path, out: Path, case: int, outcome: Outcome) -> None:
    command = [sys.executable, "-c", "from worm_bringup.cli import main; main()"]
    options = ["--no-chamber", *(["--salvage"] if case // THROUGH_THE_COMMAND % 2 else [])]
    done = subprocess.run(
        [*command, "replay", str(bag), "--out", str(out), *options],
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    wrote = (out / "summary.json").exists()
    if done.returncode < 0:
        outcome.faults.append(f"signal: the command ended by {-done.returncode}")
    elif "Traceback" in done.stderr or done.returncode not in (0, 1, 2):
        outcome.faults.append(f"traceback: the command, {done.returncode}: {done.stderr[-800:]}")
    elif wrote != (done.returncode < 2):  # 1: whole, without one pose
        outcome.faults.append(f"silent loss: status {done.returncode}, results {wrote}")


# The worker, and the parent that watches it.


def work(seed: int, seeds: Path) -> None:
    """Run the cases whose numbers come on standard input; answer each with one line of JSON."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for line in sys.stdin:
        print(json.dumps(asdict(run_case(int(line), seed, seeds))), flush=True)


class Worker:
    """A process that is started anew whenever a case has killed it."""

    def __init__(self, seed: int, seeds: Path) -> None:
        self._command = [sys.executable, "-m", "benchmarks.fuzz_bags", "--work", str(seeds)]
        self._command += ["--seed", str(seed)]
        self._process: subprocess.Popen[str] | None = None

    def run(self, case: int) -> dict[str, Any]:
        """Return what became of a case: signals and hangs are faults too."""
        if self._process is None:
            self._process = subprocess.Popen(
                self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        print(case, file=process.stdin, flush=True)
        limit_s = CASE_S + (240.0 if case % THROUGH_THE_COMMAND == 0 else 0.0)
        ready, _, _ = select.select([process.stdout], [], [], limit_s)
        line = process.stdout.readline() if ready else ""
        if line:
            return dict(json.loads(line))
        process.kill() if not ready else None
        status = process.wait()
        self._process = None
        fault = f"signal: {-status}" if ready else f"hang: more than {limit_s} s"
        if status > 0:
            fault = f"traceback: in the scan that it is held against, status {status}"
        return asdict(Outcome(case, "?", [fault]))

    def close(self) -> None:
        """End the process."""
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()
            self._process.wait()


def fuzz(count: int, seed: int, first: int = 0, jobs: int = 1) -> list[dict[str, Any]]:
    """Run cases; return their outcomes."""
    outcomes: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="fuzz-seeds-") as folder:
        seeds = Path(folder)
        for storage in mutations.STORAGES:
            for picture in mutations.PICTURES:
                (seeds / f"{storage} {picture}").mkdir()
                what = mutations.messages(picture)
                mutations.write(seeds / f"{storage} {picture}", storage, picture, what)
        workers: queue.SimpleQueue[Worker] = queue.SimpleQueue()
        for _ in range(jobs):
            workers.put(Worker(seed, seeds))

        def run(case: int) -> dict[str, Any]:
            worker = workers.get()
            try:
                return worker.run(case)
            finally:
                workers.put(worker)

        began_s = time.monotonic()
        with ThreadPoolExecutor(jobs) as pool:
            for outcome in pool.map(run, range(first, first + count)):
                outcomes.append(outcome)
                for fault in outcome["faults"]:
                    print(f"case {outcome['case']} ({outcome['kind']}): {fault}", flush=True)
                if len(outcomes) % 500 == 0:
                    print(f"after {time.monotonic() - began_s:.0f} s:", flush=True)
                    print(in_words(outcomes), flush=True)
        while not workers.empty():
            workers.get().close()
    return outcomes


def in_words(outcomes: list[dict[str, Any]]) -> str:
    """Return the counts as a table."""
    faults = Counter(fault.split(":")[0] for outcome in outcomes for fault in outcome["faults"])
    total = {key: sum(o[key] for o in outcomes) for key in ("recorded", "readable", "saved")}
    share = 100 * total["saved"] / max(1, total["readable"])
    rows = {
        "damaged bags": len(outcomes),
        "ended by a signal": faults["signal"],
        "hung": faults["hang"],
        "traceback": faults["traceback"],
        "silent loss": faults["silent loss"],
        "fewer frames than were recorded, unsaid": faults["unsaid"],
        "a line that does not help": faults["a line that does not help"],
        "refused with one line": sum(o["refused"] for o in outcomes),
        "refused with one line, with --salvage": sum(o["salvage_refused"] for o in outcomes),
        "messages recorded": total["recorded"],
        "… that an independent scan reads": total["readable"],
        "… of these, saved by `worm repair`": f"{total['saved']} ({share:.2f} %)",
    }
    return "\n".join(f"| {what} | {number} |" for what, number in rows.items())


def main() -> int:
    """Run the command; the status is 1 where a bag did harm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000, help="damaged bags")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=1, help="bags at a time")
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.work is not None:
        work(given.seed, given.work)
        return 0
    outcomes = fuzz(given.count, given.seed, given.first, given.jobs)
    print(in_words(outcomes))
    return int(any(outcome["faults"] for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
