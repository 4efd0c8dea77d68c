"""`worm model`: what the boundary walk says, without a trial."""

import json
from dataclasses import replace
from math import isnan, radians
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from worm_bringup.cli import options
from worm_bringup.cli.model_compare import compare
from worm_bringup.cli.number_options import number
from worm_bringup.cli.terminal import Terminal, say
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState
from worm_model.boundary_walk.summary import CONVENTIONS, NO_FALL, WalkSummary, summarise
from worm_msgs_py import limits
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

_WALK = "The walk"
_RIG = "The rig"
_START = "The start"
_DEFAULTS = WalkParameters()
WALK_EXIT_WIDTH = replace(limits.EXIT_WIDTH.to("mm"), or_zero=True)
WALK_DEPTH = replace(limits.DEPTH.to("mm"), or_zero=True)
WALK_SPEED, WALK_STEP = Limit(1e-3, 1e3, "mm/s"), Limit(0.01, 1e3, "mm")
WALK_REVERSAL, AT = Limit(0.0, 100.0), Limit(0.0, 1e7, "s")

model = typer.Typer(
    name="model", help="Ask the boundary walk, solved exactly.", no_args_is_help=True
)
model.command()(compare)


@model.command()
def solve(
    exit_width_mm: Annotated[
        float, number(WALK_EXIT_WIDTH, help="Width W of the exit.", rich_help_panel=_RIG)
    ] = _DEFAULTS.exit_width_mm,
    radius_mm: Annotated[
        float,
        number(limits.RADIUS.to("mm"), help="Radius R of the chamber.", rich_help_panel=_RIG),
    ] = _DEFAULTS.radius_mm,
    depth_mm: Annotated[
        float | None,
        number(
            WALK_DEPTH, help="Depth h of the chamber; 1.5 where not given.", rich_help_panel=_RIG
        ),
    ] = None,
    effective_width: Annotated[
        bool, typer.Option(help="Take the exit as √(W² + h²) wide, or as W.", rich_help_panel=_RIG)
    ] = _DEFAULTS.effective_width,
    speed_mm_s: Annotated[
        float, number(WALK_SPEED, help="Speed along the wall.", rich_help_panel=_WALK)
    ] = _DEFAULTS.speed_mm_s,
    slide_mm: Annotated[
        float, number(WALK_STEP, help="Mean d_c.", rich_help_panel=_WALK)
    ] = _DEFAULTS.mean_slide_mm,
    hop_mm: Annotated[
        float, number(WALK_STEP, help="Mean d_nc.", rich_help_panel=_WALK)
    ] = _DEFAULTS.mean_hop_mm,
    reversal: Annotated[
        float,
        number(
            WALK_REVERSAL,
            help="Share of reversals, at most 1; with --rule rate, per s.",
            rich_help_panel=_WALK,
        ),
    ] = _DEFAULTS.reversal,
    rule: Annotated[
        ReversalRule, typer.Option(help="What a reversal counts.", rich_help_panel=_WALK)
    ] = _DEFAULTS.rule,
    hop_may_land: Annotated[
        bool, typer.Option(help="A hop that ends above the exit finds it.", rich_help_panel=_WALK)
    ] = _DEFAULTS.hop_may_land,
    theta_deg: Annotated[
        float | None,
        number(
            limits.ANGLE,
            help="Start at an angle from the exit's middle, counter-clockwise positive; without "
            "it, anywhere on the wall.",
            rich_help_panel=_START,
        ),
    ] = None,
    direction: Annotated[
        Direction | None, typer.Option(help="Needs --theta-deg.", rich_help_panel=_START)
    ] = None,
    phase: Annotated[
        Phase | None,
        typer.Option(help="Needs --theta-deg; without it, slide.", rich_help_panel=_START),
    ] = None,
    at_s: Annotated[
        list[float] | None,
        number(AT, help="Time of the survival function; may be given several times."),
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Solve one walk exactly: mean and sd of τ_h, skips, survival, t_per.

    Try it: `worm model solve --exit-width-mm 2 --reversal 0.45 --at-s 10 --at-s 30`, or from a
    state: `worm model solve --theta-deg -90 --direction ccw`.
    """
    if depth_mm is not None and not effective_width:
        raise BadInput(
            "--no-effective-width takes the exit as W wide, whatever h is: leave out --depth-mm"
        )
    if reversal > 1.0 and rule is not ReversalRule.RATE:
        raise BadInput(
            f"--reversal is {reversal:g}: give a share, 0 to 1, or add --rule rate, for 1/s"
        )
    try:
        parameters = WalkParameters(
            radius_mm=radius_mm,
            exit_width_mm=exit_width_mm,
            depth_mm=_DEFAULTS.depth_mm if depth_mm is None else depth_mm,
            speed_mm_s=speed_mm_s,
            mean_slide_mm=slide_mm,
            mean_hop_mm=hop_mm,
            reversal=reversal,
            rule=rule,
            hop_may_land=hop_may_land,
            effective_width=effective_width,
        )
    except ValueError as error:
        raise BadInput(f"--exit-width-mm, --depth-mm, --radius-mm: {error}") from None
    start = _start_state(theta_deg, direction, phase)
    try:
        summary = summarise(parameters, start, at_s or ())
    except ValueError as error:
        raise BadInput(f"--theta-deg: {error}") from None
    if as_json:
        document = summary.document()
        typer.echo(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))
    else:
        Terminal().print(_walk_table(summary))


@model.command()
def figure(
    out: Annotated[Path, typer.Option(help="File to write: .svg, .png or .pdf.")],
    rule: Annotated[
        ReversalRule, typer.Option(help="What the 45 % of reversals count: per_cycle or per_phase.")
    ] = ReversalRule.PER_CYCLE,
    hop_may_land: Annotated[
        bool, typer.Option(help="A hop that ends above the exit finds it.")
    ] = True,
) -> None:
    """Draw the paper's Figs 5 and 6 from the model, with bands for 35-55 % of reversals."""
    from worm_model.boundary_walk.paper_figures import write_figure  # Matplotlib: slow to import

    try:
        write_figure(out, rule, hop_may_land=hop_may_land)
    except ValueError as error:
        raise BadInput(str(error)) from None
    say(f"Figure: {out}")


def _start_state(
    theta_deg: float | None, direction: Direction | None, phase: Phase | None
) -> WalkState | None:
    if theta_deg is None:
        if direction is not None or phase is not None:
            raise BadInput("--direction and --phase are of a state: give --theta-deg too")
        return None
    if direction is None:
        raise BadInput(
            "--theta-deg is of a state, which has a direction: give --direction cw or ccw too"
        )
    return WalkState(radians(theta_deg), direction, phase or Phase.SLIDE)


def _walk_table(summary: WalkSummary) -> Table:
    """Return the numbers, then what they rest on."""
    walk = summary.parameters
    table = Table("", "value", "", title="boundary walk, exact")
    low_s, median_s, high_s = summary.quantiles_s
    table.add_row("mean τ_h", f"{summary.mean_s:.4g} s", CONVENTIONS["tau_h"])
    table.add_row("sd of τ_h", f"{summary.sd_s:.4g} s", "")
    table.add_row("median, 90 % interval", f"{median_s:.4g} s", f"{low_s:.4g} to {high_s:.4g} s")
    table.add_row("skips", f"{summary.skips:.4g}", CONVENTIONS["skips"])
    for t_s, survival in zip(summary.at_s, summary.survival, strict=True):
        table.add_row(f"not found by {t_s:g} s", f"{survival:.4g}", "probability")
    t_per = ("–", NO_FALL) if isnan(summary.t_per_s) else (f"{summary.t_per_s:.4g} s", "")
    table.add_row("t_per", t_per[0], t_per[1] or CONVENTIONS["t_per"], end_section=True)
    start = "uniform", CONVENTIONS["start"]
    if summary.start is not None:
        at = summary.document()["start"]
        start = f"{at['theta_deg']:g}°, {at['direction']}, {at['phase']}", CONVENTIONS["theta"]
    table.add_row("start", *start)
    per = {"per_cycle": "per slide and hop", "per_phase": "per slide and per hop", "rate": "1/s"}
    arc = "√(W² + h²)" if walk.effective_width else "W"
    lands = "a hop may land in it" if walk.hop_may_land else "a hop never lands in it"
    for name, value, remark in (
        ("R, W, h", f"{walk.radius_mm:g}, {walk.exit_width_mm:g}, {walk.depth_mm:g} mm", ""),
        ("exit's arc", f"{walk.exit_arc_mm:.4g} mm", f"{arc}; {lands}"),
        ("speed", f"{walk.speed_mm_s:g} mm/s", ""),
        ("mean slide, hop", f"{walk.mean_slide_mm:g}, {walk.mean_hop_mm:g} mm", "exponential"),
        ("reversal", f"{walk.reversal:g}", f"{per[walk.rule]} ({walk.rule})"),
    ):
        table.add_row(name, value, remark)
    return table
