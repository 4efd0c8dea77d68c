"""Options that several subcommands share."""

from pathlib import Path
from typing import Annotated, Any

import typer

from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py.errors import BadInput, TrackerError
from worm_tracker.parameters import Polarity, TrackerParameters

_TRACKER = "The picture"
_ANALYSIS = "The analysis"
_GRAPH = "The graph"

Out = Annotated[
    Path, typer.Option(help="Results directory to make; an earlier result there is replaced.")
]
PolarityOption = Annotated[
    Polarity,
    typer.Option(help="Is the worm dark on bright or bright on dark?", rich_help_panel=_TRACKER),
]
NoChamber = Annotated[
    bool,
    typer.Option("--no-chamber", help="There is no rig in view.", rich_help_panel=_TRACKER),
]
RadiusMm = Annotated[
    float,
    typer.Option(
        min=0.01, help="The chamber's known radius R: gives the scale.", rich_help_panel=_TRACKER
    ),
]
CirclePx = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        metavar="U V RADIUS",
        help="The wall's circle in pixels, instead of looking for it.",
        rich_help_panel=_TRACKER,
    ),
]
CircleBPx = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        metavar="U V RADIUS",
        help="The same of a second chamber, with --circle-px.",
        rich_help_panel=_TRACKER,
    ),
]
ExitDeg = Annotated[
    float | None,
    typer.Option(
        help="Direction of the exit, counter-clockwise from the picture's right.",
        rich_help_panel=_TRACKER,
    ),
]
ExitWidthMm = Annotated[
    float | None,
    typer.Option(help="Width W of the exit, instead of measuring it.", rich_help_panel=_TRACKER),
]
DepthMm = Annotated[
    float,
    typer.Option(
        help="Thickness h of the sheet, which a picture does not show.", rich_help_panel=_TRACKER
    ),
]
PassageMm = Annotated[
    float | None,
    typer.Option(
        help="Length L of the passage, instead of measuring it; 35 where only one chamber is in "
        "view.",
        rich_help_panel=_TRACKER,
    ),
]
PxPerMm = Annotated[
    float | None,
    typer.Option(help="Scale, with --no-chamber.", rich_help_panel=_TRACKER),
]
ContactFactor = Annotated[
    float,
    typer.Option(min=0.0, help="Contact is R − r_h < factor · d_w.", rich_help_panel=_ANALYSIS),
]
BodyWidthMm = Annotated[
    float | None,
    typer.Option(
        help="The worm's width d_w; measured in the trial where not given.",
        rich_help_panel=_ANALYSIS,
    ),
]
Processes = Annotated[
    bool,
    typer.Option("--processes", help="A process for each node.", rich_help_panel=_GRAPH),
]
Namespace = Annotated[
    str, typer.Option(help="ROS namespace, such as /rig1.", rich_help_panel=_GRAPH)
]


def tracker_parameters(
    *,
    polarity: Polarity,
    no_chamber: bool,
    radius_mm: float,
    circle_px: tuple[float, float, float] | None,
    circle_b_px: tuple[float, float, float] | None,
    exit_deg: float | None,
    exit_width_mm: float | None,
    depth_mm: float,
    passage_mm: float | None,
    px_per_mm: float | None,
) -> dict[str, Any]:
    """Return the tracker's parameters that the options give.

    Raises
    ------
    BadInput
        Where they contradict each other or make no sense.
    """
    given: dict[str, Any] = {
        "polarity": str(polarity),
        "no_chamber": no_chamber,
        "radius_m": radius_mm / 1e3,
        "depth_m": depth_mm / 1e3,
    }
    if circle_px is not None:
        given |= dict(zip(("centre_u_px", "centre_v_px", "radius_px"), circle_px, strict=True))
    if circle_b_px is not None:
        names = ("centre_b_u_px", "centre_b_v_px", "radius_b_px")
        given |= dict(zip(names, circle_b_px, strict=True))
    for name, value, unit in (
        ("exit_deg", exit_deg, 1.0),
        ("exit_width_m", exit_width_mm, 1e-3),
        ("passage_length_m", passage_mm, 1e-3),
        ("px_per_mm", px_per_mm, 1.0),
    ):
        if value is not None:
            given[name] = value * unit
    try:
        TrackerParameters(**given)
    except TrackerError as error:
        raise BadInput(f"the tracker cannot use these options: {error}") from None
    return given


def analysis_parameters(*, contact_factor: float, body_width_mm: float | None) -> dict[str, Any]:
    """Return the analysis' parameters that the options give."""
    # One threshold, no hysteresis, as in the paper.
    given: dict[str, Any] = {"contact_factor": contact_factor, "release_factor": contact_factor}
    if body_width_mm is not None:
        given["body_width_m"] = body_width_mm / 1e3
    try:
        AnalysisParameters(**given)
    except ValueError as error:
        raise BadInput(f"the analysis cannot use these options: {error}") from None
    return given
