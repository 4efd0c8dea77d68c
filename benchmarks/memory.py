"""Resident memory of a run over time: sampled in a thread, told as growth, drawn as a figure.

```
with sampled_memory() as trace:  # or of another process: sampled_memory(pid)
    run_graph(..., progress=trace.progress)
print(trace.growth())
draw({"replay": trace}, Path("docs/endurance.png"))
```
"""

import os
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

_MIB = 1 << 20
_PAGE = os.sysconf("SC_PAGE_SIZE")
_PERIOD_FRAMES = 2048
"""Memory goes up and down with the row groups of `TableWriter`, which are so many frames long."""


@dataclass
class MemoryTrace:
    """Samples of a run: seconds since its start, frames sent by then, resident memory in MiB."""

    elapsed_s: list[float] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    resident_mib: list[float] = field(default_factory=list)
    sent: int = 0

    def progress(self, sent: int, expected: int | None = None) -> None:
        """Take note of the frames that were sent; fits where a graph asks for its progress."""
        self.sent = sent

    def sample(self, elapsed_s: float, resident_mib: float) -> None:
        """Add a sample."""
        self.elapsed_s.append(elapsed_s)
        self.frames.append(self.sent)
        self.resident_mib.append(resident_mib)

    def growth(self, after_s: float = 60.0) -> float:
        """Return by what part memory grew from the end of the first minute to the last frame.

        The median over about the first tenth of the frames after that minute is compared with the
        median over about their last tenth: whole periods of the row groups, one at least, so that
        what these take and give back again is no growth. The report, which is drawn after the last
        frame, takes its memory once whatever the length of the run.

        Raises
        ------
        ValueError
            Where fewer than two periods come after that minute.
        """
        samples = zip(self.elapsed_s, self.frames, self.resident_mib, strict=True)
        later = [(sent, mib) for s, sent, mib in samples if s >= after_s and sent < self.frames[-1]]
        first, last = (later[0][0], later[-1][0]) if later else (0, 0)
        span = max(1, (last - first) // 10 // _PERIOD_FRAMES) * _PERIOD_FRAMES
        if last - first < 2 * span:
            raise ValueError(f"{last - first} frames after {after_s:g} s; {2 * span} are needed")
        before = median(mib for sent, mib in later if sent < first + span)
        return median(mib for sent, mib in later if sent > last - span) / before - 1.0


def resident_mib(pid: int, descendants: bool = True) -> float:
    """Return the resident memory of a process and, if asked, of all its descendants, MiB."""
    mib = 0.0
    with suppress(OSError):  # it may have just ended
        mib = int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * _PAGE / _MIB
    for listed in Path(f"/proc/{pid}/task").glob("*/children") if descendants else ():
        with suppress(OSError):
            mib += sum(resident_mib(int(child)) for child in listed.read_text().split())
    return mib


@contextmanager
def sampled_memory(
    pid: int | None = None, every_s: float = 1.0, *, descendants: bool = True
) -> Iterator[MemoryTrace]:
    """Sample the memory of a process (this one), and of its descendants, while the block runs."""
    trace, stop, began_s = MemoryTrace(), threading.Event(), time.monotonic()

    def run() -> None:
        while not stop.wait(every_s):
            trace.sample(time.monotonic() - began_s, resident_mib(pid or os.getpid(), descendants))

    thread = threading.Thread(target=run, name="memory", daemon=True)
    thread.start()
    try:
        yield trace
    finally:
        stop.set()
        thread.join()


def draw(
    traces: Mapping[str, MemoryTrace], path: Path, marks: Mapping[str, list[int]] | None = None
) -> None:
    """Draw memory against frames, a panel a run, and write a PNG.

    Parameters
    ----------
    traces : mapping of title to MemoryTrace
    marks : mapping of title to list of int, optional
        Frames at which something happened (an outage): a line each.
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(
        1, len(traces), figsize=(5.6 * len(traces), 3.4), squeeze=False, layout="constrained"
    )
    for axis, (title, trace) in zip(axes[0], traces.items(), strict=True):
        minute = next((n for s, n in zip(trace.elapsed_s, trace.frames, strict=True) if s >= 60), 0)
        axis.axvspan(0, minute / 1e3, color="0.93", label="first minute")
        for k, frame in enumerate((marks or {}).get(title, ())):
            label = "camera outage" if k == 0 else None
            axis.axvline(frame / 1e3, color="tab:red", lw=0.8, alpha=0.6, label=label)
        thousands = [frames / 1e3 for frames in trace.frames]
        axis.plot(thousands, trace.resident_mib, lw=1.2, label=f"n = {len(thousands)} samples")
        axis.set(
            title=f"{title}: {trace.growth():+.2%} after the first minute",
            xlabel="frames sent (thousands)",
            ylabel="resident memory (MiB)",
            ylim=(0, 1.25 * max(trace.resident_mib)),
        )
        axis.title.set_fontsize("medium")
        axis.legend(frameon=False, loc="lower right", fontsize="small")
    figure.savefig(path, dpi=130)
    plt.close(figure)
