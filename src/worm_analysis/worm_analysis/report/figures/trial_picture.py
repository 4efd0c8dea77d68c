"""A picture of the trial itself, with what was found in it: wall, exit, midline, ends, centroid."""

from typing import Any

import numpy as np
from matplotlib.patches import Arc

from worm_analysis.report.panel import Panel, counted, thousands
from worm_analysis.report.theme import COLOURS, PAGE_IN, new_figure
from worm_analysis.results import Results
from worm_analysis.results.picture import TrialPicture
from worm_msgs_py import Chamber
from worm_msgs_py.colours import MIDLINE_COLOUR, WALL_COLOUR
from worm_msgs_py.contract.body import KEYPOINTS

SHOWN_LEVELS = (0.001, 0.999)
"""Quantiles of the grey levels that are drawn black and white."""
PASSAGE_SHOWN_R = 0.4
"""So much of the passage is drawn, in units of R."""
NONE_KEPT = "no picture is kept beside these tracks"
_READING = (
    "One frame as the camera took it, its grey levels stretched to the whole range. Left: the "
    "chamber. Orange: the wall’s circle and the walls of the exit’s passage, as calibrated. Right: "
    "the worm, enlarged. Yellow: its midline. Blue: tip of the head; red: centroid of the body’s "
    "area; green: tip of the tail. The frame is chosen by rule: of those with a whole body and a "
    "certain head, at the wall if there are any, the one whose midline the tracker trusts most. It "
    "says how well the best frames are tracked, not how well all are."
)


def trial_picture(results: Results, picture: TrialPicture | None) -> Panel:
    """Return the panel; without a picture the reason stands in its place."""
    base: dict[str, Any] = {
        "key": "fig-frame", "title": "The worm in the picture", "paper": "",
        "label": "Picture", "reading": _READING,
    }  # fmt: skip
    if picture is None:
        return Panel(**base, n=counted(0, "frames"), why=NONE_KEPT)
    tracks, row = results.tracks, picture.row
    number, time_s = int(tracks["frame"][row]), float(results.t_s[row])
    n = f"Frame {thousands(number)}, at {time_s:.1f} s"
    figure = new_figure(PAGE_IN, 3.5)
    whole, close = figure.subplots(1, 2)
    chambers = [item for item in results.chambers if item.name == tracks["where"][row]]
    _show(whole, picture, *_square_shown(picture, (chambers or list(results.chambers))[:1]))
    u, v = picture.midline_u_px, picture.midline_v_px
    ends = [np.r_[part, _keypoints_px(results, row, axis)] for part, axis in ((u, "u"), (v, "v"))]
    _show(close, picture, *_square_around(ends, 0.12))
    for chamber in results.chambers:
        for axes, width in ((whole, 1.0), (close, 1.4)):
            _draw_wall(axes, chamber, width)
    for axes, size in ((whole, 3.0), (close, 6.0)):
        axes.plot(u, v, color=MIDLINE_COLOUR, linewidth=0.2 * size)
        for point in KEYPOINTS:
            place = [tracks[f"{point}_{axis}_px"][row] for axis in "uv"]
            axes.plot(*place, "o", color=COLOURS[point], markersize=size, mec="white", mew=0.4,
                      label=point if axes is close else None)  # fmt: skip
    px_per_mm = float(tracks["length_px"][row] / tracks["length_mm"][row])
    low = v > np.nanmedian(v)  # the part of the worm that a bar below could hide
    for axes in (whole, close):
        _scale_bar(axes, px_per_mm, u[low])
    figure.legend(loc="outside upper center", ncols=3, title=n, title_fontsize=7.0)
    alt = (
        f"Frame {number} of the trial: the chamber, and the worm enlarged, with wall, exit, "
        "midline, head, centroid and tail as they were found."
    )
    return Panel(**base, n=n, figure=figure, alt=alt)


def _keypoints_px(results: Results, row: int, axis: str) -> Any:
    return np.array([results.tracks[f"{point}_{axis}_px"][row] for point in KEYPOINTS])


def _square_shown(picture: TrialPicture, chambers: list[Chamber]) -> tuple[float, float, float]:
    """Return the middle and half the side of the square that holds a chamber, or the picture."""
    if not chambers:
        height, width = picture.grey.shape
        return (width - 1) / 2, (height - 1) / 2, max(height, width) / 2
    chamber = chambers[0]
    return chamber.centre_u_px, chamber.centre_v_px, 1.15 * chamber.radius_px


def _square_around(uv: list[Any], margin: float) -> tuple[float, float, float]:
    """Return the middle and half the side of the square around some points."""
    low, high = np.nanmin(uv, axis=1), np.nanmax(uv, axis=1)
    middle = (low + high) / 2
    return float(middle[0]), float(middle[1]), float((high - low).max() * (0.5 + margin))


def _show(axes: Any, picture: TrialPicture, u: float, v: float, half: float) -> None:
    """Show the part of the picture that is in view, at its own resolution."""
    low, high = np.quantile(picture.grey, SHOWN_LEVELS)
    height, width = picture.grey.shape
    left, right = max(0, int(u - half)), min(width, int(u + half) + 2)
    top, bottom = max(0, int(v - half)), min(height, int(v + half) + 2)
    axes.imshow(
        picture.grey[top:bottom, left:right], cmap="gray", vmin=low, vmax=high,
        interpolation="none", extent=(left - 0.5, right - 0.5, bottom - 0.5, top - 0.5),
    )  # fmt: skip
    axes.set_xlim(u - half, u + half)
    axes.set_ylim(v + half, v - half)
    axes.set_xticks([])
    axes.set_yticks([])


def _draw_wall(axes: Any, chamber: Chamber, width: float) -> None:
    R, W = chamber.radius_m, chamber.exit_width_m
    half = float(np.degrees(np.arcsin(min(W / 2 / R, 1.0)))) if W > 0 else 0.0
    line: dict[str, Any] = {"color": WALL_COLOUR, "linewidth": width}
    side = 2 * chamber.radius_px
    # v points down, so that angles of the picture are turned round.
    axes.add_patch(
        Arc((chamber.centre_u_px, chamber.centre_v_px), side, side,
            angle=-np.degrees(chamber.exit_rad), theta1=half, theta2=360 - half, **line)
    )  # fmt: skip
    if W > 0:
        along = np.array([np.sqrt(R**2 - (W / 2) ** 2), (1 + PASSAGE_SHOWN_R) * R])
        for y in (-W / 2, W / 2):
            axes.plot(*chamber.to_pixels(along, np.full(2, y)), **line)


def _scale_bar(axes: Any, px_per_mm: float, worm_u_px: Any) -> None:
    """Draw a bar of a round length into the lower corner that is farther from the worm."""
    if not np.isfinite(px_per_mm):
        return
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    side = right - left
    length_mm = next((mm for mm in (10, 5, 2, 1, 0.5) if mm * px_per_mm < 0.35 * side), 0.1)
    on_the_left = np.nanmean(worm_u_px) > (left + right) / 2
    u = left + 0.05 * side if on_the_left else right - 0.05 * side - length_mm * px_per_mm
    v = bottom + 0.05 * (top - bottom)
    for colour, width in (("white", 4.5), ("black", 2.0)):
        axes.plot([u, u + length_mm * px_per_mm], [v, v], color=colour, linewidth=width)
    axes.annotate(
        f"{length_mm:g} mm", (u, v), xytext=(0, 4), textcoords="offset points", fontsize=7.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0},
    )  # fmt: skip
