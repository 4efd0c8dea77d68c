"""The paper's Figs 5 (right column) and 6, drawn from the exact boundary walk."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from worm_model.boundary_walk.first_passage import FirstPassage, SolvedWalk
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_msgs_py.files.whole_files import new_file
from worm_msgs_py.paper import (
    EXIT_WIDTHS_MM,
    REVERSAL_OF_FIG_6,
    ROUND_S,
    TRIAL_S,
    WALK_HOP_MM,
    WALK_SLIDE_MM,
)

FIGURE_FORMATS = ".svg", ".png", ".pdf"
_REVERSALS = sorted(REVERSAL_OF_FIG_6)
WIDTHS_MM = 0.5, 1.0, 3.0, 5.0
"""Panels of Fig. 5."""
LONGEST_S = 250.0
_MODEL, _GREY = "#CC79A7", "#767676"
_WALK_STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "lines.linewidth": 1.0,
    "svg.fonttype": "path",
    "svg.hashsalt": "worm-escape",
}
_METADATA = {
    ".svg": dict.fromkeys(("Date", "Creator", "Format", "Type")),
    ".png": {"Software": None},
    ".pdf": dict.fromkeys(("Creator", "Producer", "CreationDate")),
}


def write_figure(path: Path, rule: ReversalRule, *, hop_may_land: bool = True) -> None:
    """Draw the figure and write it; the same arguments give the same bytes.

    Parameters
    ----------
    path : Path
        Its suffix says the format, one of `FIGURE_FORMATS`.
    rule : ReversalRule
        What the reversals of Fig. 6's caption, 45 (35 to 55) %, count; not a rate.
    hop_may_land : bool
        See `boundary_walk.WalkParameters`.

    Raises
    ------
    ValueError
        Where the suffix is another, the rule is a rate, or there is no such directory.
    BadInput
        Where the file is there already, or cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in FIGURE_FORMATS:
        raise ValueError(f"{path}: a figure's name ends in {', '.join(FIGURE_FORMATS)}")
    if rule is ReversalRule.RATE:
        raise ValueError("rule rate: the paper gives a share of steps; use per_cycle or per_phase")
    if not path.parent.is_dir():
        raise ValueError(f"{path}: there is no directory {path.parent}; make it first")
    with new_file(path) as unfinished, mpl.rc_context(_WALK_STYLE):
        figure = draw_figure(rule, hop_may_land=hop_may_land)
        figure.savefig(unfinished, format=suffix[1:], dpi=200, metadata=_METADATA[suffix])


def draw_figure(rule: ReversalRule, *, hop_may_land: bool = True) -> Figure:
    """Return the figure: four distributions of τ_h, its mean and the skips against W."""

    def solve(width_mm: float, reversal: float) -> FirstPassage:
        walk = WalkParameters(
            exit_width_mm=width_mm,
            mean_slide_mm=WALK_SLIDE_MM,
            mean_hop_mm=WALK_HOP_MM,
            reversal=reversal,
            rule=rule,
            hop_may_land=hop_may_land,
        )
        return SolvedWalk(walk).first_passage()

    figure = Figure(figsize=(7.0, 6.2), layout="constrained")
    grid = figure.add_gridspec(4, 2)
    first: Any = None
    for row, width_mm in enumerate(WIDTHS_MM):
        first = figure.add_subplot(grid[row, 0], sharex=first, sharey=first)
        _draw_distribution(first, [solve(width_mm, reversal) for reversal in _REVERSALS])
        first.set_title(f"W = {width_mm:g} mm", loc="left")
        first.label_outer()
    first.set_xlabel("τ$_h$ (s)")
    _draw_against_width(figure.add_subplot(grid[:2, 1]), solve, lambda law: law.mean_s)
    mean, skips = figure.axes[-1], figure.add_subplot(grid[2:, 1])
    mean.axhline(ROUND_S, color=_GREY, linestyle=(0, (4, 2)))
    mean.text(5.0, ROUND_S, "paper: one round ≈ 40 s", color=_GREY, ha="right", va="bottom")
    mean.set_ylabel("⟨τ$_h$⟩ (s)")
    mean.legend(loc="lower left")
    _draw_against_width(skips, solve, lambda law: TRIAL_S * law.skips / law.mean_s)
    skips.set_ylabel("n$_s$ per 30 min of searching")
    skips.set_xlabel("W (mm)")
    figure.suptitle(_caption(rule, hop_may_land), fontsize=7.5)
    return figure


def _caption(rule: ReversalRule, hop_may_land: bool) -> str:
    walk = WalkParameters()
    of = "slide and hop" if rule is ReversalRule.PER_CYCLE else "slide and per hop"
    lands = "may" if hop_may_land else "may not"
    return (
        f"Boundary walk, exact (no sampling, no n): v = {walk.speed_mm_s:g} mm/s, ⟨d$_c$⟩ = "
        f"{WALK_SLIDE_MM:g} mm, ⟨d$_{{nc}}$⟩ = {WALK_HOP_MM:g} mm, R = {walk.radius_mm:g} mm, h = "
        f"{walk.depth_mm:g} mm;\nexit √(W² + h²) wide, a hop {lands} land in it; 45 % reversals "
        f"per {of}, shaded: 35 to 55 %; uniform start"
    )


def _draw_distribution(axes: Any, laws: list[FirstPassage]) -> None:
    """Draw P(τ_h) on a logarithmic axis, and the exponential law of the same mean."""
    t_s = np.linspace(0.1, LONGEST_S, 150)
    low, middle, high = (law.density(t_s) for law in laws)
    axes.fill_between(t_s, np.minimum(low, high), np.maximum(low, high), color=_MODEL, alpha=0.3)
    axes.plot(t_s, middle, color=_MODEL, label="walk")
    mean_s = laws[1].mean_s
    axes.plot(
        t_s,
        np.exp(-t_s / mean_s) / mean_s,
        color="black",
        lw=0.7,
        ls=":",
        label="exponential, same mean",
    )
    axes.set_yscale("log")
    axes.set_ylim(1e-4, 1e-1)
    axes.set_xlim(0.0, LONGEST_S)
    axes.set_ylabel("P(τ$_h$) (1/s)")
    axes.text(
        0.97, 0.92, f"⟨τ$_h$⟩ = {mean_s:.1f} s", transform=axes.transAxes, ha="right", va="top"
    )
    axes.legend(loc="lower left", ncols=2)


def _draw_against_width(
    axes: Any,
    solve: Callable[[float, float], FirstPassage],
    number: Callable[[FirstPassage], float],
) -> None:
    width_mm = np.linspace(0.1, 5.25, 40)
    low, middle, high = (
        np.array([number(solve(float(width), reversal)) for width in width_mm])
        for reversal in _REVERSALS
    )
    axes.fill_between(
        width_mm,
        np.minimum(low, high),
        np.maximum(low, high),
        color=_MODEL,
        alpha=0.3,
        linewidth=0.0,
        label="35 to 55 % reversals",
    )
    axes.plot(width_mm, middle, color=_MODEL, label="45 % reversals")
    points = [number(solve(width, _REVERSALS[1])) for width in EXIT_WIDTHS_MM]
    axes.plot(EXIT_WIDTHS_MM, points, "o", ms=3.0, color=_MODEL, label="the rig's widths")
    axes.set_xlim(0.0, 5.25)
    axes.set_ylim(bottom=0.0)
