"""The whole trial at a glance: the head's radius, its angle and the body's angle against time."""

from typing import Any

import numpy as np

from worm_analysis.report.figures.time_traces import without_wraps
from worm_analysis.report.panel import Panel, counted
from worm_analysis.report.theme import HEAD_COLOUR, INK, PAGE_IN, new_figure
from worm_analysis.results import Results
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough

MOST_SHOWN = 2400
"""Frames that are drawn at most: more are one blot."""
_READING = (
    "All of the trial, by up to 2400 evenly spaced frames. <i>r</i><sub>h</sub>: distance "
    "of the head tip from the chamber’s centre (line: the wall at <i>R</i>). θ<sub>h</sub>: its "
    "polar angle from the exit’s direction, unwrapped within a visit of a chamber, growing "
    "counter-clockwise; whole turns are marked. ψ<sub>b</sub>: signed angle from the outward "
    "normal at the head to the body, so that θ<sub>h</sub> should grow where ψ<sub>b</sub> &gt; 0. "
    "Empty: the worm was not tracked, or in the passage."
)


def time_course(results: Results) -> Panel:
    """Return the panel, with one axis of time."""
    theta = results.tracks["theta_h_rad"]
    known = int(np.isfinite(theta).sum())
    n = counted(known, "frames with the head in a chamber")
    base: dict[str, Any] = {
        "key": "fig-course", "title": "The whole trial: radius, angle and orientation", "paper": "",
        "label": "The whole trial", "reading": _READING, "n": n,
    }  # fmt: skip
    if not results.chambers:
        return Panel(**base, why=NO_CHAMBER)
    if known < 2:
        return Panel(**base, why=not_enough(known, "frames", 2))
    shown = slice(None, None, -(-len(theta) // MOST_SHOWN))
    minutes = results.t_s[shown] / 60
    where = results.tracks["where"][shown]
    begins = np.r_[False, where[1:] != where[:-1]]  # no line goes from one visit to the next
    columns = {
        "r_h_mm": results.tracks["r_h_mm"][shown],
        "theta_h_deg": np.degrees(theta[shown]),
        "psi_b_deg": results.tracks["psi_b_deg"][shown],
    }
    figure = new_figure(PAGE_IN, 3.6)
    rows = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.35, 1.0))
    labels = ("$r_h$ (mm)", r"$\theta_h$ (degrees)", r"$\psi_b$ (degrees)")
    for axes, (name, values), label in zip(rows, columns.items(), labels, strict=True):
        is_angle = name == "psi_b_deg"
        drawn = np.where(begins, np.nan, without_wraps(values) if is_angle else values)
        axes.plot(minutes, drawn, color=INK if is_angle else HEAD_COLOUR, linewidth=0.5)
        axes.set_ylabel(label)
    rows[0].axhline(results.radius_mm, color=INK, linewidth=0.6)
    rows[0].set_ylim(0, 1.06 * results.radius_mm)
    _mark_turns(rows[1])
    rows[2].axhline(0.0, color=INK, linewidth=0.5)
    rows[2].set_ylim(-180, 180)
    rows[2].set_yticks([-180, -90, 0, 90, 180])
    rows[2].set_xlim(0, results.t_s[-1] / 60)
    rows[2].set_xlabel("time $t$ (min)")
    rows[0].set_title(n, loc="right", pad=3)
    figure.align_ylabels(rows)
    alt = f"Head radius, head angle and body angle against time over the whole trial, {n}."
    return Panel(**base, figure=figure, alt=alt, tables={"": {"t_min": minutes, **columns}})


def _mark_turns(axes: Any) -> None:
    """Put a tick and a faint line at whole turns, few enough to read."""
    low, high = (end / 360 for end in axes.get_ylim())
    step = next((step for step in (1, 2, 5, 10, 20, 50) if (high - low) / step <= 6), 100)
    turns = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step * 360
    if len(turns) > 1:
        axes.set_yticks(turns)
        axes.grid(axis="y", linewidth=0.4)
