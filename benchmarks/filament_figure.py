"""The figure of the worm in two dimensions, beside the paper's Figs 1 and 3 to 9."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Circle

from worm_analysis.report.theme import COLOURS, GREY, INK, PAPER_STYLE, new_figure, say_n, style
from worm_msgs_py import Quantity, paper

SHADES = ("#000000", "#0072B2", "#009E73", "#E69F00", "#CC79A7")
"""Of the widths, from narrow to wide: told apart by the colour-blind, too."""
MARKS = "osD^v"
_OVER_POINTS = {"frameon": True, "framealpha": 0.9, "edgecolor": "none", "borderpad": 0.2}
PAPER_BETA = {w: paper.paper_value("beta", w) for w in (0.5, 1.0, 3.0, 5.0)}


def draw(
    trials: Sequence[Any],
    together: Mapping[str, Quantity],
    by_width: Mapping[float, Mapping[str, Quantity]],
    path: Path,
) -> None:
    """Draw all panels.

    Parameters
    ----------
    trials : sequence of Measured
        Ascending in W.
    together, by_width : mapping
        The quantities of all trials, and of those of each W.
    path : Path
        The PNG to write.
    """
    with style():
        figure = new_figure(7.0, 8.2)
        axes = figure.subplots(4, 3)
        _bodies(axes[0, 0], trials[-1])
        _radii(axes[0, 1], trials)
        _angles(axes[0, 2], trials, together)
        for at, name, label, value in (
            (axes[1, 0], "d_c", "$d_c$", paper.SLIDE_MM),
            (axes[1, 1], "d_nc", "$d_{nc}$", paper.HOP_MM),
            (axes[1, 2], "delta_r_h", r"$\Delta r_h$", paper.EXCURSION_MM),
        ):
            _law(at, _joined(trials, name), label, value, together[name])
        _speed(axes[2, 0], trials, together)
        _persistence(axes[2, 1], trials, together)
        _searches(axes[2, 2], trials, by_width)
        _against_width(axes[3, 0], by_width, "tau_h", r"$\langle\tau_h\rangle$ (s)", {})
        constant = dict.fromkeys(by_width, paper.SUCCESS)
        _against_width(axes[3, 1], by_width, "success", "success rate", constant)
        axes[3, 1].set_ylim(0, 1)
        _depths(axes[3, 2], trials, by_width)
        for letter, at in zip("abcdefghijkl", axes.flat, strict=True):
            at.set_title(f"({letter})", loc="left")
        figure.savefig(path, dpi=200, metadata={"Software": None})


def _joined(trials: Sequence[Any], name: str) -> Any:
    return np.concatenate([trial.points[name] for trial in trials])


def _bodies(axes: Any, trial: Any) -> None:
    path = trial.path_mm
    in_a = np.hypot(*path[:, 1].T) < paper.RADIUS_MM
    last = int(np.argmin(in_a)) if not in_a.all() else len(path)
    first, last = (0, last) if last > 300 else (0, min(len(path), 1500))
    axes.add_patch(Circle((0, 0), paper.RADIUS_MM, fill=False, color=INK, linewidth=0.8))
    for body in path[first:last:60, 3:]:
        axes.plot(*body.T, color="#C8C8C8", linewidth=0.6, zorder=1)
    for k, name in enumerate(("head", "centroid", "tail")):
        axes.plot(*path[first:last, k].T, color=COLOURS[name], linewidth=0.6, label=name)
    axes.legend(loc="center", fontsize=6)
    axes.set(aspect="equal", xlim=(-11, 11), ylim=(-11, 11), xlabel="x (mm)", ylabel="y (mm)")
    say_n(axes, f"{(last - first) / 30:.0f} s", y=0.04)


def _radii(axes: Any, trials: Sequence[Any]) -> None:
    for name, key in (("head", "r_h"), ("centroid", "r_c"), ("tail", "r_t")):
        counts = sum(trial.points[f"{key}_counts"] for trial in trials)
        edges = trials[0].points[f"{key}_edges"] * 1e3 / paper.RADIUS_MM
        density = counts / counts.sum() / np.diff(edges)
        axes.stairs(density, edges, color=COLOURS[name], label=f"${key}$")
    axes.axvline(paper.paper_number("r_c_over_R"), **PAPER_STYLE)
    axes.set(xlim=(0, 1.1), xlabel="$r/R$", ylabel="$P(r/R)$", yscale="log", ylim=(0.02, 60))
    axes.legend(loc="upper left")


def _angles(axes: Any, trials: Sequence[Any], together: Mapping[str, Quantity]) -> None:
    counts = sum(trial.points["psi_b_counts"] for trial in trials)
    edges = np.degrees(trials[0].points["psi_b_edges"])
    density = counts / counts.sum() / np.diff(edges)
    axes.stairs(density, edges, color=INK)
    axes.set_ylim(0, 1.2 * density.max())
    for name in ("psi_b_negative_peak", "psi_b_positive_peak"):
        axes.axvline(paper.paper_number(name), **PAPER_STYLE)
    axes.set(xlim=(-120, 120), xlabel=r"$\psi_b$ (deg)", ylabel=r"$P(\psi_b)$ (1/deg)")
    say_n(axes, f"n = {round(counts.sum())} frames")


def _law(axes: Any, values: Any, label: str, paper_mm: float, number: Quantity) -> None:
    edges = np.arange(0.0, 12.5, 0.5)
    counts = np.histogram(values, edges)[0]
    density = counts / len(values) / np.diff(edges)
    seen = counts > 0
    middle = 0.5 * (edges[1:] + edges[:-1])
    error = np.sqrt(counts[seen]) / len(values) / 0.5
    axes.errorbar(middle[seen], density[seen], error, fmt="o", color=COLOURS["head"], ms=2.5)
    x = np.linspace(0, 12, 100)
    axes.plot(x, np.exp(-x / paper_mm) / paper_mm, label="paper", **PAPER_STYLE)
    if number.value is not None:
        law = np.exp(-x / number.value) / number.value
        axes.plot(x, law, color=INK, linewidth=0.8, label=f"{number.value:.2f} mm")
    axes.set(yscale="log", ylim=(2e-4, 2), xlim=(0, 12), xlabel=f"{label} (mm)")
    axes.set_ylabel(f"$P$({label}) (1/mm)")
    axes.legend(loc="upper right", title=f"n = {len(values)}", title_fontsize=7)


def _speed(axes: Any, trials: Sequence[Any], together: Mapping[str, Quantity]) -> None:
    points = np.concatenate([trial.sums["window_points"] for trial in trials])
    axes.plot(points[:, 0], 1e3 * points[:, 1], ".", color=GREY, ms=2, alpha=0.5)
    x = np.array([-1.0, 1.0])
    slope = together["v_w"].value or 0.0
    axes.plot(x, slope * x, color=INK, label=f"{slope:.2f} mm/s")
    axes.plot(x, paper.SPEED_MM_S * x, label="paper", **PAPER_STYLE)
    axes.set(xlim=(-1, 1), ylim=(-4, 4), xlabel=r"$\sin\langle\psi_b\rangle$")
    axes.set_ylabel(r"$\langle v_b\rangle$ (mm/s)")
    axes.legend(loc="upper left", **_OVER_POINTS)
    say_n(axes, f"n = {len(points)} windows", y=0.04)


def _persistence(axes: Any, trials: Sequence[Any], together: Mapping[str, Quantity]) -> None:
    pairs, products = np.split(sum(trial.sums["c_theta"].sum(axis=0) for trial in trials), 2)
    lag_s = trials[0].lag_s
    enough = pairs > 0.02 * pairs[0]
    axes.plot(lag_s[enough], products[enough] / pairs[enough], color=COLOURS["head"])
    axes.plot(lag_s, np.exp(-lag_s / paper.T_PER_S[0]), label="paper, 27 s", **PAPER_STYLE)
    t_per = together["t_per"].value
    if t_per is not None:
        axes.plot(lag_s, np.exp(-lag_s / t_per), color=INK, lw=0.8, label=f"{t_per:.0f} s")
    axes.set(xlim=(0, 60), ylim=(-0.2, 1.05), xlabel="$t$ (s)", ylabel=r"$C_\theta(t)$")
    axes.legend(loc="upper right")


def _searches(axes: Any, trials: Sequence[Any], by_width: Mapping[float, Any]) -> None:
    for w, colour in zip(by_width, SHADES, strict=False):
        tau = np.sort(_joined([t for t in trials if t.width_mm == w], "tau_h"))
        if len(tau):
            left = 1.0 - np.arange(len(tau)) / len(tau)
            axes.step(tau, left, color=colour, where="post", label=f"{w:g} mm, n = {len(tau)}")
    axes.set(yscale="log", xlim=(0, 250), ylim=(0.01, 1.1), xlabel=r"$\tau_h$ (s)")
    axes.set_ylabel(r"part of searches longer than $\tau_h$")
    axes.legend(loc="upper right", fontsize=6)


def _against_width(
    axes: Any, by_width: Mapping[float, Any], name: str, label: str, told: Mapping[float, float]
) -> None:
    for w, found in by_width.items():
        q = found[name]
        if q.value is not None:
            low = q.value if q.low is None else q.low
            high = q.value if q.high is None else q.high
            span = [[q.value - low], [high - q.value]]
            axes.errorbar(w, q.value, span, fmt="o", color=COLOURS["head"], ms=3)
            axes.annotate(f"{q.n}", (w, high), ha="center", va="bottom", fontsize=6)
    if told:
        axes.plot(list(told), list(told.values()), label="paper", **PAPER_STYLE)
        axes.legend(loc="lower right")
    axes.set(xlabel="$W$ (mm)", ylabel=label, xlim=(0, 5.5))
    axes.set_ylim(0, 1.1 * axes.get_ylim()[1])


def _depths(axes: Any, trials: Sequence[Any], by_width: Mapping[float, Any]) -> None:
    for (w, found), colour, mark in zip(by_width.items(), SHADES, MARKS, strict=False):
        depth = np.sort(_joined([t for t in trials if t.width_mm == w], "x_p"))
        left = 1.0 - np.arange(len(depth)) / max(len(depth), 1)
        beta = found["beta"].value
        label = f"{w:g} mm, n = {len(depth)}" + ("" if beta is None else f", β = {beta:.2g}")
        axes.plot(depth, left, mark, color=colour, ms=2.2, label=label)
    x = np.linspace(0, 10, 50)
    for beta in (PAPER_BETA[0.5], PAPER_BETA[5.0]):
        axes.plot(x, np.exp(-x * (beta or 0.0)), **PAPER_STYLE)
    axes.set(yscale="log", xlim=(0, 10), ylim=(0.01, 1.5), xlabel="$x_p$ (mm)")
    axes.set_ylabel("part of failures deeper than $x_p$")
    axes.legend(loc="upper right", fontsize=5.5, **_OVER_POINTS)
