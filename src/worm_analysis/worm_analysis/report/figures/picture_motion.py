"""For trials without a chamber: the worm's way in the picture, its speed and its length."""

from typing import Any

import numpy as np

from worm_analysis.report.panel import Panel, counted
from worm_analysis.report.theme import COLOURS, COLUMN_IN, INK, new_figure
from worm_analysis.results import Results
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS

SPEED_WINDOW_S = 1.0
WAY_READING = (
    "Head tip, centroid of the body's area and tail tip in the picture, as the picture shows it: "
    "<i>u</i> to the right and <i>v</i> down, whole numbers at pixel centres. Lines break where "
    "the worm was not tracked."
)
MOTION_READING = (
    "Speed: distance between the centroid's places half a second before and half a second after, "
    "per second. Length: along the midline from tip to tip. In millimetres where a scale is known, "
    "otherwise in pixels."
)
_LINE: dict[str, Any] = {"linewidth": 0.7, "alpha": 0.9}


def picture_trajectories(results: Results) -> Panel:
    """Return the panel of trajectories in pixels."""
    tracks = results.tracks
    frames = int(np.isfinite(tracks["centroid_u_px"]).sum())
    n = counted(frames, "frames")
    base: dict[str, Any] = {
        "key": "fig-picture",
        "title": "Trajectories in the picture",
        "paper": "",
        "label": "Trajectories",
        "reading": WAY_READING,
        "n": n,
    }
    if frames < 2:
        return Panel(**base, why=f"not enough data: {frames} frames with a centroid, 2 are needed")
    figure = new_figure(COLUMN_IN, COLUMN_IN)
    axes = figure.add_subplot()
    for point in reversed(KEYPOINTS):
        u, v = tracks[f"{point}_u_px"], tracks[f"{point}_v_px"]
        axes.plot(u, v, color=COLOURS[point], label=point, **_LINE)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.invert_yaxis()
    axes.set_xlabel("$u$ (px)")
    axes.set_ylabel("$v$ (px), down")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles[::-1], labels[::-1], loc="outside upper center", ncols=3, title=n, title_fontsize=7
    )
    return Panel(**base, figure=figure, alt=f"Trajectories of head, centroid and tail, {n}.")


def picture_motion(results: Results) -> Panel:
    """Return the panel of speed and length against time."""
    tracks, t_s = results.tracks, results.t_s
    scaled = bool(np.isfinite(tracks["length_mm"]).any() & np.isfinite(tracks["length_px"]).any())
    mm_per_px = float(np.nanmedian(tracks["length_mm"] / tracks["length_px"])) if scaled else 1.0
    unit = "mm" if scaled else "px"
    v = mm_per_px * speed(t_s, tracks["centroid_u_px"], tracks["centroid_v_px"])
    frames = int(np.isfinite(v).sum())
    n = counted(frames, "frames with a speed")
    base: dict[str, Any] = {
        "key": "fig-motion",
        "title": "Speed and length against time",
        "paper": "",
        "label": "Speed and length",
        "reading": MOTION_READING,
        "n": n,
    }
    if frames < 2:
        return Panel(**base, why=f"not enough data: {frames} frames with a speed, 2 are needed")
    length = mm_per_px * tracks["length_px"]
    figure = new_figure(COLUMN_IN, COLUMN_IN)
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(t_s, v, color=COLOURS["centroid"], **_LINE)
    above.set_ylabel(f"speed ({unit}/s)")
    above.set_ylim(bottom=0)
    above.set_title(n, loc="right", pad=3)
    below.plot(t_s, length, color=INK, **_LINE)
    below.set_ylabel(f"length ({unit})")
    below.set_ylim(0, 1.15 * float(np.nanmax(length)) if np.isfinite(length).any() else 1)
    below.set_xlim(0, t_s[-1])
    below.set_xlabel("time $t$ (s)")
    with_length = counted(int(np.isfinite(length).sum()), "frames with a length")
    below.set_title(with_length, loc="right", pad=3)
    figure.align_ylabels([above, below])
    alt = f"Centroid speed (median {np.nanmedian(v):.3g} {unit}/s) and length against time, {n}."
    return Panel(**base, figure=figure, alt=alt)


def speed(t_s: Floats, u: Floats, v: Floats) -> Floats:
    """Return the speed over one second around each frame.

    Parameters
    ----------
    t_s : ndarray, shape (n,)
        Times, ascending.
    u, v : ndarray, shape (n,)
        Places; NaN where they are not known.

    Returns
    -------
    ndarray, shape (n,)
        Places' unit per second; NaN within half a second of the trial's ends and of unknown places.
    """
    half = SPEED_WINDOW_S / 2
    before = np.searchsorted(t_s, t_s - half - 1e-9)
    after = np.minimum(np.searchsorted(t_s, t_s + half - 1e-9), len(t_s) - 1)
    dt = t_s[after] - t_s[before]
    whole = (t_s - half >= t_s[:1] - 1e-9) & (t_s + half <= t_s[-1:] + 1e-9) & (dt > 0)
    distance = np.hypot(u[after] - u[before], v[after] - v[before])
    found: Floats = np.divide(distance, dt, out=np.full(len(t_s), np.nan), where=whole)
    return found
