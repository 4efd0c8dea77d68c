"""Fig. 2: the head's place and the body's and head's angles against time."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from worm_analysis.report.examples import Indices, example_spans
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.panel import Panel, counted, thousands
from worm_analysis.report.theme import HEAD_COLOUR, INK, PAGE_IN, SHADE, new_figure
from worm_analysis.results import Columns, Results
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py.arrays import Floats

_READING = (
    "<i>r</i><sub>h</sub>: distance of the head tip from the chamber's centre (thin line: the wall "
    "at <i>R</i>). θ<sub>h</sub>: its polar angle from the exit's direction, unwrapped, growing "
    "counter-clockwise. ψ<sub>b</sub>: signed angle from the outward normal at the head to the "
    "body (centroid to head); ψ<sub>h</sub>: the same with the head's own direction, that of the "
    "midline's first tenth; both positive counter-clockwise, so θ<sub>h</sub> should rise where "
    "ψ<sub>b</sub> &gt; 0. Grey: the head in contact with the wall "
    "(<i>R</i> − <i>r</i><sub>h</sub> &lt; 0.3 <i>d</i><sub>w</sub>). Lines break where the worm "
    "was not tracked."
)
_READING_LONG = (
    " The examples are stretches of up to one minute in one chamber, chosen by rule: of all in "
    "which θ<sub>h</sub> is known in 90 % of the frames, those with the fewest, the median and the "
    "most reversals."
)
_BASE: dict[str, Any] = {
    "key": "fig-2",
    "title": "Radial position, angular position and orientation against time",
    "paper": "Fig. 2",
}
HEIGHTS = (1.0, 1.35, 1.0, 1.0)
WRAP_DEG = 180.0


@dataclass(frozen=True, eq=False, slots=True)
class Example:
    """A stretch of a trial that is shown; the rest of the trial need not be kept for it.

    Attributes
    ----------
    tracks : mapping of column name to ndarray
        Its rows.
    t_s : ndarray
        Times from the trial's start.
    radius_mm : float
        R.
    trial : str
        What the trial is called; empty where there is only one.
    """

    tracks: Columns
    t_s: Floats
    radius_mm: float
    trial: str = ""

    @classmethod
    def of(cls, results: Results, rows: Indices, trial: str = "") -> "Example":
        """Cut the stretch out of its trial."""
        tracks = {name: column[rows] for name, column in results.tracks.items()}
        return cls(tracks, results.t_s[rows], results.radius_mm, trial)


def time_traces(results: Results) -> Panel:
    """Return the panel of one trial: up to three examples, or the whole of a short one."""
    if not results.chambers:
        return Panel(**_BASE, n=counted(0, "frames"), reading=_READING, why=NO_CHAMBER)
    examples = [Example.of(results, rows) for rows in example_spans(results)]
    return traces(examples, whole=bool(len(results.t_s)) and results.t_s[-1] <= FIGURES.whole_s)


def traces(examples: Sequence[Example], *, whole: bool = False) -> Panel:
    """Return the panel of up to three examples, of one trial or of several."""
    known = sum(_known(example) for example in examples)
    n = counted(known, "frames")
    if known < 2:
        why = "not enough data: the head was not tracked in a chamber for 54 s of any minute"
        return Panel(**_BASE, n=n, reading=_READING, why=why)
    figure = new_figure(PAGE_IN, 4.3)
    grid = figure.subplots(4, len(examples), sharex="col", squeeze=False, height_ratios=HEIGHTS)
    tables = {}
    for column, example in enumerate(examples):
        _draw_column(grid[:, column], example)
        tables[f"example-{column + 1}"] = _traces_table(example)
    for row in (0, 2, 3):
        limits = [axes.get_ylim() for axes in grid[row]]
        for axes in grid[row]:
            axes.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))
            axes.tick_params(labelleft=axes is grid[row, 0])
    for axes in grid[2:].flat:
        step = 90 if axes.get_ylim()[1] > 100 else 45
        limits = axes.get_ylim()
        axes.set_yticks(np.arange(-2, 3) * step)
        axes.set_ylim(limits)
    labels = ("$r_h$ (mm)", r"$\theta_h$ (degrees)", r"$\psi_b$ (degrees)", r"$\psi_h$ (degrees)")
    for axes, label in zip(grid[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    figure.align_ylabels(grid[:, 0])
    span = "the whole trial" if whole else f"{len(examples)} examples of one minute"
    alt = f"Head radius, head angle, body angle and head direction against time, {span}, {n}."
    reading = _READING if whole else _READING + _READING_LONG
    trials = [example.trial for example in examples if example.trial]
    if trials:
        reading += f" From left to right they are from {escape(', '.join(trials))}."
    return Panel(**_BASE, n=n, reading=reading, figure=figure, alt=alt, tables=tables)


def _known(example: Example) -> int:
    return int(np.isfinite(example.tracks["theta_h_rad"]).sum())


def _traces_table(example: Example) -> dict[str, Any]:
    tracks = example.tracks
    return {
        "t_s": example.t_s,
        "r_h_mm": tracks["r_h_mm"],
        "theta_h_deg": np.degrees(tracks["theta_h_rad"]),
        "psi_b_deg": tracks["psi_b_deg"],
        "psi_h_deg": tracks["psi_h_deg"],
        "contact": [None if np.isnan(told) else bool(told) for told in tracks["contact"]],
    }


def contact_spans(t_s: Floats, contact: Floats) -> list[tuple[float, float]]:
    """Return start and end of each run of frames in contact, s; it reaches to the next frame."""
    touching = np.r_[False, contact == 1.0, False]
    edges = np.flatnonzero(touching[1:] != touching[:-1])
    return [
        (float(t_s[start]), float(t_s[min(end, len(t_s) - 1)]))
        for start, end in edges.reshape(-1, 2)
    ]


def without_wraps(angle_deg: Floats) -> Floats:
    """Put NaN where an angle jumps over ±180°, so that no line is drawn across."""
    broken = angle_deg.copy()
    broken[np.flatnonzero(np.abs(np.diff(angle_deg)) > WRAP_DEG) + 1] = np.nan
    return broken


def _draw_column(column: Any, example: Example) -> None:
    tracks, t_s = example.tracks, example.t_s
    spans = contact_spans(t_s, tracks["contact"])
    for axes in column:
        for start, end in spans:
            axes.axvspan(start, end, color=SHADE, linewidth=0, zorder=0)
        axes.set_xlim(t_s[0], t_s[-1])
    radius, theta, body, head = column
    line = {"linewidth": 0.8}
    radius.axhline(example.radius_mm, color=INK, linewidth=0.6)
    radius.plot(t_s, tracks["r_h_mm"], color=HEAD_COLOUR, **line)
    radius.set_ylim(top=1.04 * example.radius_mm)
    theta.plot(t_s, np.degrees(tracks["theta_h_rad"]), color=HEAD_COLOUR, **line)
    _whole_turns(theta)
    for axes, name in ((body, "psi_b_deg"), (head, "psi_h_deg")):
        axes.axhline(0.0, color=INK, linewidth=0.5)
        angle = tracks[name]
        axes.plot(t_s, without_wraps(angle), color=INK, **line)
        axes.set_ylim(*_angle_limits(angle))
    head.set_xlabel("time $t$ (s)")
    known = _known(example)
    radius.set_title(f"n = {thousands(known)} frames", loc="right", pad=3)


def _angle_limits(angle_deg: Floats) -> tuple[float, float]:
    """Return symmetric limits that leave nothing out: a quarter of a turn at least."""
    largest = float(np.nanmax(np.abs(angle_deg), initial=0.0))
    reach = next((reach for reach in (100.0, 140.0) if largest <= reach), 180.0)
    return -reach, reach


def _whole_turns(axes: Any) -> None:
    """Put ticks where the head is at whole parts of a turn."""
    low, high = axes.get_ylim()
    steps = (15, 30, 45, 90, 180, 360, 720, 1440, 3600)
    step = next((step for step in steps if (high - low) / step <= 5), 7200)
    first, last = int(np.ceil(low / step)), int(np.floor(high / step))
    axes.set_yticks(np.arange(first, last + 1) * step)
