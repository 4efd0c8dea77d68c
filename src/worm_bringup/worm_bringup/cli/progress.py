"""What a person sees while a trial runs, and at its end."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from worm_bringup.cli.terminal import Terminal
from worm_bringup.graph.in_process import Progress as Report
from worm_bringup.graph.in_process import RunResult
from worm_bringup.trial import WithoutPose
from worm_msgs_py import Status
from worm_msgs_py.contract.source_events import in_words, read_source_events
from worm_msgs_py.files.corrections import corrections_in_words, corrections_of
from worm_msgs_py.text import printable

_QUANTITIES_SHOWN = (
    "d_c",
    "d_nc",
    "delta_r_h",
    "v_w",
    "psi_b_negative_peak",
    "psi_b_positive_peak",
    "r_c_over_R",
    "r_h_over_R",
    "t_per",
    "tau_h",
)
_POSE_LABELS = [status.label for status in Status if status.has_pose]


class _Speed(ProgressColumn):
    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.0f} frames/s")


@contextmanager
def progress_bar(description: str) -> Iterator[Report]:
    """Show a bar on stderr; give the function that moves it."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        _Speed(),
        TimeRemainingColumn(),
    )
    console = Terminal(stderr=True)
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task(printable(description), total=None)
        yield lambda sent, total: progress.update(task, completed=sent, total=total)
    if not console.is_terminal:  # a log gets the full bar once, and an error one line alone
        console.print(progress.get_renderable())


def show_result(result: RunResult, report: Path) -> None:
    """Print what was found, where the time went, and last the path of the report."""
    show_trial(report, partial(_show_run, result))


def _show_run(result: RunResult) -> None:
    show_speed(result)
    if result.no_picture:
        said = printable(f"The report opens without a picture: {result.no_picture}")
        Terminal().print(said, style="yellow", soft_wrap=True, highlight=False, markup=False)


def show_trial(report: Path, between: Callable[[], None] = lambda: None) -> None:
    """Print what was found, then whatever `between` prints, and last the path of the report."""
    console = Terminal()
    summary = json.loads((report.parent / "summary.json").read_text(encoding="utf-8"))
    frames = summary["frames"]
    others = ", ".join(
        f"{name} {count}"
        for name, count in frames.items()
        if name not in ("read", "tracked") and count
    )
    console.print(
        f"{frames['read']} frames in, {frames['tracked']} tracked"
        + (f"; {others}" if others else "")
    )
    corrected = summary.get("corrections", {"applied": (), "frames_swapped": 0})
    corrections = corrections_of(corrected["applied"])
    for line in (
        *in_words(read_source_events(summary.get("source_events", ()))),
        *corrections_in_words(corrections, corrected["frames_swapped"]),
    ):
        console.print(
            printable(line), style="yellow", soft_wrap=True, highlight=False, markup=False
        )
    for topic, count in summary.get("ignored_messages", {}).items():
        said = f"{count} messages on {topic} were not of this graph and are ignored"
        console.print(printable(said), style="yellow", highlight=False, markup=False)
    between()
    shown = {name: summary["quantities"][name] for name in _QUANTITIES_SHOWN}
    known = {name: item for name, item in shown.items() if item["value"] is not None}
    if known:
        console.print(_quantities_table(known))
    if len(known) < len(shown):
        unknown = ", ".join(name for name in shown if name not in known)
        console.print(f"No value, for reasons given in the report: {unknown}", soft_wrap=True)
    console.print(f"Report: {report}", soft_wrap=True, highlight=False)


def refuse_without_pose(report: Path) -> None:
    """Raise `WithoutPose` where not one frame of the results has a pose."""
    summary = json.loads((report.parent / "summary.json").read_text(encoding="utf-8"))
    frames = summary["frames"]
    poses = (count for name, count in frames.items() if name in _POSE_LABELS)
    if not sum(poses):
        why = (summary["what_to_try"] or "").partition(": ")[2] or "for several reasons"
        raise WithoutPose(
            f"not one of {frames['read']} frames has a pose: {why}; "
            f"the results are in {report.parent}"
        )


def show_speed(result: RunResult) -> None:
    """Print the frames that were sent, how fast, and where the time went."""
    console = Terminal()
    speed = (result.frames - result.earlier) / max(result.elapsed_s, 1e-9)
    console.print(f"{result.frames} frames, {speed:.0f} / s")
    skipped = result.counts.get("frames skipped")
    if skipped is not None:
        captured = result.counts["frames captured"]
        lost = int(result.counts["frames lost"])
        never = f", {lost} never came" if lost else ""
        console.print(f"{captured} captured, {skipped} skipped{never}")
    if result.spent_s:
        total = sum(result.spent_s.values())
        shares = ", ".join(
            f"{name} {100 * seconds / total:.0f} %" for name, seconds in result.spent_s.items()
        )
        console.print(f"time: {shares}", soft_wrap=True)


def _quantities_table(quantities: dict[str, dict[str, Any]]) -> Table:
    table = Table("quantity", "value", "95 % interval", "n", "unit", "paper")
    for name, quantity in quantities.items():
        low, high = quantity["low"], quantity["high"]
        table.add_row(
            name,
            _three_digits(quantity["value"]),
            "" if low is None or high is None else f"{_three_digits(low)} … {_three_digits(high)}",
            str(quantity["n"]),
            quantity["unit"],
            _three_digits(quantity["paper"]),
        )
    return table


def _three_digits(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"
