"""Fig. 1c: where head, centroid and tail went in the chamber."""

from math import ceil
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Arc

from worm_analysis.report.examples import Indices, example_spans
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.panel import Panel, counted, thousands
from worm_analysis.report.theme import COLOURS, COLUMN_IN, INK, PAGE_IN, new_figure
from worm_analysis.results import Results
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough
from worm_msgs_py import Chamber, Where
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.units import MM_PER_M

PASSAGE_SHOWN_MM = 3.0
SAME_FRAME_MM = 1.0
"""Far less than the chambers are apart, far more than a calibration is ever corrected."""
_READING = (
    "Head tip, centroid of the body's area and tail tip in the chamber's own frame: origin at its "
    "centre, <i>x</i> towards the middle of the exit, <i>y</i> such that angles grow "
    "counter-clockwise as seen in the picture. The black circle is the wall of radius <i>R</i> "
    "with the opening of width <i>W</i>. Lines are frame by frame and break where the worm was "
    "not tracked."
)
_READING_EXAMPLE = " First, one minute of the trial: that with the fewest reversals of direction."
_READING_LONG = " The whole trial is shown as points, one for each of evenly spaced frames."


def trajectories(results: Results) -> Panel:
    """Return the panel; a trial longer than 90 s shows one minute, and the whole as points."""
    long = len(results.t_s) > 0 and results.t_s[-1] > FIGURES.whole_s
    base: dict[str, Any] = {
        "key": "fig-1c",
        "title": "Trajectories of head, centroid and tail",
        "paper": "Fig. 1c",
        "reading": _READING,
    }
    if not results.chambers:
        return Panel(**base, n=counted(0, "frames"), why=NO_CHAMBER)
    inside = [(chamber, _rows_in(results, chamber)) for chamber in results.chambers]
    inside = [(chamber, rows) for chamber, rows in inside if len(rows)]
    frames = sum(len(rows) for _, rows in inside)
    n = counted(frames, "frames with a pose")
    if frames < 2:
        return Panel(**base, n=n, why=not_enough(frames, "frames", 2))
    drawn: list[tuple[Chamber, Indices, bool]] = []
    if long:
        for example in example_spans(results, 1):
            minute = example[np.isfinite(results.tracks["head_x_mm"][example])]
            place = results.tracks["where"][minute[0]]
            drawn += [(chamber, minute, False) for chamber, _ in inside if chamber.name == place]
            base["reading"] += _READING_EXAMPLE
    if long:
        base["reading"] += _READING_LONG
    drawn += [(chamber, rows, long) for chamber, rows in inside]
    figure = new_figure(*_figure_size_in(len(drawn)))
    for number, (chamber, rows, as_points) in enumerate(drawn):
        axes = figure.add_subplot(1, len(drawn), number + 1)
        _draw_chamber(axes, chamber)
        (_draw_points if as_points else _draw_lines)(axes, results, rows)
        _label(axes, chamber, several=len(inside) > 1, first=number == 0)
        seconds = results.t_s[rows[-1]] - results.t_s[rows[0]]
        axes.set_title(
            f"n = {thousands(len(rows))} frames, {seconds:.0f} s", loc="right", pad=3, fontsize=7.0
        )
    handles = [Line2D([], [], color=COLOURS[point], linewidth=1.2) for point in KEYPOINTS]
    figure.legend(handles, KEYPOINTS, loc="outside upper center", ncols=3)
    alt = (
        f"Trajectories of the worm's head (blue), centroid (red) and tail (green) in "
        f"{len(inside)} chamber(s) of radius {results.radius_mm:.3g} mm, {n}."
    )
    return Panel(**base, n=n, figure=figure, alt=alt)


def _rows_in(results: Results, chamber: Chamber) -> Indices:
    """Return the frames with the head in a chamber, or in the passage and in its frame."""
    tracks = results.tracks
    here = tracks["where"] == chamber.name
    seen = np.isin(tracks["where"], [member.name for member in results.chambers])
    off_mm = _off_frame_mm(results, chamber)
    others = [_off_frame_mm(results, other) for other in results.chambers if other is not chamber]
    # In the middle of the passage both frames have nearly the same numbers.
    nearest = np.all([off_mm < other for other in others], axis=0)
    told = (off_mm < SAME_FRAME_MM) & nearest
    in_its_frame = np.where(np.isfinite(off_mm), told, _last_known(here, seen))
    beyond = (tracks["where"] == Where.PASSAGE.label) & in_its_frame
    return np.flatnonzero((here | beyond) & np.isfinite(tracks["head_x_mm"]))


def _off_frame_mm(results: Results, chamber: Chamber) -> Floats:
    """Return how far a head's pixels are from its millimetres, if these are in this frame."""
    tracks = results.tracks
    x_m, y_m = chamber.to_metres(tracks["head_u_px"], tracks["head_v_px"])
    off_mm = np.hypot(MM_PER_M * x_m - tracks["head_x_mm"], MM_PER_M * y_m - tracks["head_y_mm"])
    return np.asarray(off_mm, dtype=np.float64)


def _last_known(here: Any, seen: Any) -> Any:
    """Return what `here` was in the last frame in which it could be told."""
    last = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), 0))
    return here[last] if len(seen) else here


def _figure_size_in(panels: int) -> tuple[float, float]:
    above = 0.2  # the legend
    if panels == 1:
        return COLUMN_IN, 0.9 * COLUMN_IN + above
    return PAGE_IN, 0.9 * PAGE_IN / panels + above + (0.0 if panels == 2 else 0.25)


def _draw_chamber(axes: Any, chamber: Chamber) -> None:
    R, W = chamber.radius_m * MM_PER_M, chamber.exit_width_m * MM_PER_M
    half = float(np.degrees(np.arcsin(min(W / 2 / R, 1.0)))) if W > 0 else 0.0
    wall: dict[str, Any] = {"color": INK, "linewidth": 1.2, "zorder": 1}
    axes.add_patch(Arc((0, 0), 2 * R, 2 * R, theta1=half, theta2=360 - half, **wall))
    if W > 0:
        start = float(np.sqrt(R**2 - (W / 2) ** 2))
        for side in (-W / 2, W / 2):
            axes.plot([start, R + PASSAGE_SHOWN_MM], [side, side], **wall)
    axes.set_xlim(-1.08 * R, 1.08 * R + (PASSAGE_SHOWN_MM if W > 0 else 0.0))
    axes.set_ylim(-1.08 * R, 1.08 * R)
    axes.set_aspect("equal")


def _draw_lines(axes: Any, results: Results, rows: Indices) -> None:
    for point in reversed(KEYPOINTS):
        x, y = (_unbroken(results, rows, f"{point}_{axis}_mm") for axis in "xy")
        axes.plot(x, y, color=COLOURS[point], linewidth=0.7, label=point, alpha=0.9)


def _draw_points(axes: Any, results: Results, rows: Indices) -> None:
    shown = rows[:: ceil(len(rows) / FIGURES.most_points)]
    for point in reversed(KEYPOINTS):
        x, y = (results.tracks[f"{point}_{axis}_mm"][shown] for axis in "xy")
        axes.plot(x, y, ".", color=COLOURS[point], markersize=1.8, alpha=0.55, label=point, mew=0)


def _unbroken(results: Results, rows: Indices, column: str) -> Any:
    """Return a column over all rows between the first and the last, NaN outside of `rows`."""
    span = np.full(rows[-1] - rows[0] + 1, np.nan)
    span[rows - rows[0]] = results.tracks[column][rows]
    return span


def _label(axes: Any, chamber: Chamber, *, several: bool, first: bool) -> None:
    axes.set_xlabel("$x$ (mm)")
    if first:
        axes.set_ylabel("$y$ (mm)")
    if several:
        axes.set_title(chamber.name.replace("_", " "), loc="left", pad=3)
    ticks = np.arange(-10, 11, 5) * chamber.radius_m * 100
    axes.set_xticks(ticks)
    axes.set_yticks(ticks)
