"""What became of every frame: its status against time."""

from typing import Any

import numpy as np

from worm_analysis.report.panel import Panel, counted, thousands
from worm_analysis.report.theme import HEAD_COLOUR, PAGE_IN, TAIL_COLOUR, new_figure
from worm_analysis.results import Results
from worm_analysis.wording import not_enough
from worm_msgs_py import Status
from worm_msgs_py.arrays import Floats

_READING = (
    "Every frame of the bag is in exactly one row. A gap in a row means that the frame had "
    "another status. The number at the right is the count of frames."
)
WITH_POSE = [status.label for status in Status if status.has_pose]
COLUMNS = 1200
"""Runs are drawn no finer than this many parts of the trial: no screen shows more."""


def statuses(results: Results) -> Panel:
    """Return the panel."""
    status, t_s = results.tracks["status"], results.t_s
    n = counted(len(status), "frames")
    base: dict[str, Any] = {
        "key": "fig-status",
        "title": "Outcome of tracking, frame by frame",
        "paper": "",
        "label": "Tracking",
        "reading": _READING,
        "n": n,
    }
    if len(status) < 2 or t_s[-1] <= 0:
        return Panel(**base, why=not_enough(len(status), "frames", 2))
    order = [member.label for member in Status]
    present = sorted(set(status), key=lambda label: [*order, label].index(label))
    figure = new_figure(PAGE_IN, 0.72 + 0.2 * len(present))
    axes = figure.add_subplot()
    for place, label in enumerate(reversed(present)):
        chosen = status == label
        colour = TAIL_COLOUR if label in WITH_POSE else HEAD_COLOUR
        axes.broken_barh(
            times_of_runs(t_s, chosen), (place - 0.36, 0.72), color=colour, linewidth=0
        )
        axes.annotate(
            thousands(int(chosen.sum())),
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
        )
    axes.set_yticks(range(len(present)), [label.replace("_", " ") for label in reversed(present)])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(-0.6, len(present) - 0.4)
    axes.set_xlim(0, t_s[-1])
    axes.set_xlabel("time $t$ (s)")
    axes.set_title(n, loc="right", pad=3)
    told = ", ".join(
        f"{int((status == label).sum())} {label.replace('_', ' ')}" for label in present
    )
    return Panel(**base, figure=figure, alt=f"Status of each frame against time: {told}.")


def times_of_runs(t_s: Floats, chosen: np.ndarray) -> list[tuple[float, float]]:
    """Return start and length of each run of chosen frames, s.

    A run reaches to the next frame, and each is at least 1/1200 of the trial long so that a single
    lost frame can be seen; runs that then touch are one.
    """
    step = float(np.median(np.diff(t_s)))
    ends = np.append(t_s[1:], t_s[-1] + step)
    edges = np.flatnonzero(np.diff(np.r_[False, chosen, False].astype(int)))
    shortest = t_s[-1] / COLUMNS
    found: list[tuple[float, float]] = []
    for first, after in edges.reshape(-1, 2):
        start, end = float(t_s[first]), float(max(ends[after - 1], t_s[first] + shortest))
        if found and start <= found[-1][0] + found[-1][1]:
            start = found.pop()[0]
        found.append((start, end - start))
    return found
