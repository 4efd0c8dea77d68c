"""Draw docs/picture.png: a simulated worm filmed by the rig, tracked and analysed by the cores.

python docs/make_picture.py
"""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from worm_analysis.analysis import Analysis
from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import frames as midlines
from worm_model.simulator.filming import Filming, film
from worm_model.simulator.rig import Optics
from worm_model.simulator.rig.views import one_chamber
from worm_msgs_py import Observables, TrackedFrame
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

SEED, SECONDS, FPS, SHOWN = 13, 45.0, 20.0, 620
HEAD, CENTROID, TAIL, INK = "#0072B2", "#D55E00", "#009E73", "#222222"


def main() -> None:
    """Film, track, analyse, draw."""
    tracker, analysis = Tracker(TrackerParameters()), Analysis()
    frames: list[TrackedFrame] = []
    pictures = {}
    worm = FilamentParameters()
    life = midlines(worm, FilamentRig(), seed=SEED, duration_s=SECONDS, frames_per_s=FPS)
    filming = Filming(frames_per_s=FPS, body_width_mm=worm.width_mm)
    for number, shot in enumerate(film(life, one_chamber(40.0, 2.0, Optics()), filming)):
        frames += tracker.push(np.asarray(shot.picture, np.uint8), shot.stamp_ns)
        if number == SHOWN:
            pictures[number] = shot.picture
    frames += tracker.finish()
    observables = [analysis.push(frame)[0] for frame in frames]

    plt.rcParams.update({"font.size": 9, "axes.edgecolor": INK, "font.family": "DejaVu Sans"})
    figure = plt.figure(figsize=(9.6, 4.2), dpi=125, layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=[1.0, 1.25])
    draw_picture(left.subplots(), pictures[SHOWN], frames)
    draw_traces(right, observables)
    figure.savefig(Path(__file__).with_name("picture.png"))


def draw_picture(axes: Axes, picture: np.ndarray, frames: list[TrackedFrame]) -> None:
    """Draw one frame with the midline and the trails of the ten seconds before."""
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
    trail = frames[SHOWN - int(10 * FPS) : SHOWN + 1]
    for name, colour in (("tail", TAIL), ("centroid", CENTROID), ("head", HEAD)):
        points = np.array(
            [(getattr(f.state, name).u_px, getattr(f.state, name).v_px) for f in trail]
        )
        axes.plot(*points.T, color=colour, lw=1.2, alpha=0.8)
        axes.plot(*points[-1], "o", color=colour, ms=6, mec="white", label=name)
    midline = frames[SHOWN].midline
    axes.plot(midline.u_px, midline.v_px, color="white", lw=0.9)
    axes.legend(loc="lower left", frameon=False, labelcolor="white", fontsize=8)
    axes.set_axis_off()


def draw_traces(figure: plt.Figure, observables: list[Observables]) -> None:
    """Draw r_h, θ_h and ψ_b against time, contact shaded."""
    time_s = np.array([o.stamp_ns for o in observables]) / 1e9
    contact = np.array([bool(o.contact) for o in observables])
    rows = (
        ("$r_h$ (mm)", [o.r_h_m * 1e3 for o in observables], HEAD),
        (r"$\theta_h$ (°)", np.degrees([o.theta_h_rad for o in observables]), HEAD),
        (r"$\psi_b$ (°)", np.degrees([o.psi_b_rad for o in observables]), INK),
    )
    axes = figure.subplots(len(rows), 1, sharex=True)
    for row, (label, values, colour) in zip(axes, rows, strict=True):
        row.plot(time_s, values, color=colour, lw=1.0)
        row.fill_between(
            time_s, 0, 1, where=contact, transform=row.get_xaxis_transform(),
            color="#000000", alpha=0.10, lw=0,
        )  # fmt: skip
        row.set_ylabel(label)
        row.spines[["top", "right"]].set_visible(False)
    axes[-1].axhline(0, color=INK, lw=0.5)
    axes[-1].set_xlabel("time (s); shaded: head in contact with the wall")
    axes[-1].set_xlim(0, time_s[-1])
    figure.align_ylabels(axes)


if __name__ == "__main__":
    main()
