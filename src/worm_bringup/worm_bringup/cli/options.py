"""Options that several subcommands share."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli.numbers import number, numbers
from worm_bringup.cli.usage import refuse_together, refuse_without
from worm_msgs_py import limits
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.network import Reach
from worm_msgs_py.ros.watchdog import PATIENCE
from worm_tracker.parameters import TrackerParameters
from worm_tracker.polarity import Polarity
from worm_tracker.sources.bags.scan.decompression import CHUNK_MIB
from worm_tracker.sources.image_decoder import MEGAPIXELS

_TRACKER = "The picture"
_ANALYSIS = "The analysis"
_GRAPH = "The graph"
_DAMAGE = "Damaged bags"


def _check_namespace(value: str) -> str:
    """Refuse a namespace that ROS does not take."""
    try:
        if value:
            validate_namespace("/" + value.lstrip("/"))
    except InvalidNamespaceException:
        raise typer.BadParameter(
            f"{value!r} is no ROS namespace: give letters, digits, _ and /, such as /rig1"
        ) from None
    return value


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
    float | None,
    number(
        limits.RADIUS.to("mm"),
        help="The chamber's known radius R, which gives the scale; 10 where not given.",
        rich_help_panel=_TRACKER,
    ),
]
_CIRCLE = {"U": limits.PLACE_PX, "V": limits.PLACE_PX, "RADIUS": limits.RADIUS_PX}
CirclePx = Annotated[
    tuple[float, float, float] | None,
    numbers(
        "The wall's circle in pixels, instead of looking for it.",
        rich_help_panel=_TRACKER,
        **_CIRCLE,
    ),
]
CircleBPx = Annotated[
    tuple[float, float, float] | None,
    numbers("The same of a second chamber, with --circle-px.", rich_help_panel=_TRACKER, **_CIRCLE),
]
ExitDeg = Annotated[
    float | None,
    number(
        limits.ANGLE,
        help="Direction of the exit, counter-clockwise from the picture's right.",
        rich_help_panel=_TRACKER,
    ),
]
ExitWidthMm = Annotated[
    float | None,
    number(
        limits.EXIT_WIDTH.to("mm"),
        help="Width W of the exit, instead of measuring it.",
        rich_help_panel=_TRACKER,
    ),
]
DepthMm = Annotated[
    float | None,
    number(
        limits.DEPTH.to("mm"),
        help="Thickness h of the sheet, which a picture does not show; 1.5 where not given.",
        rich_help_panel=_TRACKER,
    ),
]
PassageMm = Annotated[
    float | None,
    number(
        limits.PASSAGE_LENGTH.to("mm"),
        help="Length L of the passage, instead of measuring it; 35 where only one chamber is in "
        "view.",
        rich_help_panel=_TRACKER,
    ),
]
PxPerMm = Annotated[
    float | None,
    number(limits.PX_PER_MM, help="Scale, with --no-chamber.", rich_help_panel=_TRACKER),
]
ContactFactor = Annotated[
    float | None,
    number(
        limits.CONTACT_FACTOR,
        help="Contact is R − r_h < factor · d_w; 0.3, as in the paper, where not given.",
        rich_help_panel=_ANALYSIS,
    ),
]
BodyWidthMm = Annotated[
    float | None,
    number(
        limits.BODY_WIDTH.to("mm"),
        help="The worm's width d_w; measured in the trial where not given.",
        rich_help_panel=_ANALYSIS,
    ),
]
Processes = Annotated[
    bool,
    typer.Option("--processes", help="A process for each node.", rich_help_panel=_GRAPH),
]
Network = Annotated[
    bool,
    typer.Option(
        "--network",
        help="Let other machines see the graph too, as ROS_* of the environment says "
        "(docs/network.md).",
        rich_help_panel=_GRAPH,
    ),
]
WatchdogS = Annotated[
    float,
    number(
        PATIENCE,
        help="Seconds that a node may take over one message; longer, and it hangs: the run ends.",
        rich_help_panel=_GRAPH,
    ),
]
Namespace = Annotated[
    str,
    typer.Option(
        help="ROS namespace, such as /rig1.", callback=_check_namespace, rich_help_panel=_GRAPH
    ),
]

MaxChunkMib = Annotated[
    float,
    number(
        CHUNK_MIB,
        help="Largest piece of a bag, decompressed, that is read, MiB: no small file fills the "
        "memory.",
        rich_help_panel=_DAMAGE,
    ),
]
MaxMegapixels = Annotated[
    float,
    number(
        MEGAPIXELS,
        help="Larger pictures are bad ones: they are not decoded.",
        rich_help_panel=_DAMAGE,
    ),
]


def reach(*, visible: bool, network: bool, otherwise: str) -> Reach:
    """Return who can see the graph.

    Raises
    ------
    BadInput
        Where a hidden graph is to be opened to the network; `otherwise` is what to do.
    """
    if network and not visible:
        raise BadInput(f"--network opens a graph that others can see: {otherwise}")
    if network:
        return Reach.NETWORK
    return Reach.MACHINE if visible else Reach.OWN


def tracker_parameters(
    *,
    polarity: Polarity,
    no_chamber: bool,
    circle_px: tuple[float, float, float] | None,
    circle_b_px: tuple[float, float, float] | None,
    **numbers: float | None,
) -> dict[str, Any]:
    """Return the tracker's parameters that the options give.

    Raises
    ------
    BadInput
        Where they contradict each other or make no sense.
    """
    options: dict[str, Any] = {
        "no_chamber": no_chamber, "circle_px": circle_px, "circle_b_px": circle_b_px, **numbers,
    }  # fmt: skip
    rig = [name for name in options if name not in ("no_chamber", "px_per_mm")]
    refuse_together(options, "says that there is no rig in view", "no_chamber", *rig)
    why = "is the scale of pictures without a chamber; with one, --radius-mm gives it"
    refuse_without(options, "px_per_mm", "no_chamber", why)
    refuse_without(options, "circle_b_px", "circle_px", "is a second chamber")
    given: dict[str, Any] = {"polarity": str(polarity), "no_chamber": no_chamber}
    if circle_px is not None:
        given |= dict(zip(("centre_u_px", "centre_v_px", "radius_px"), circle_px, strict=True))
    if circle_b_px is not None:
        names = ("centre_b_u_px", "centre_b_v_px", "radius_b_px")
        given |= dict(zip(names, circle_b_px, strict=True))
    for option, (name, unit) in _TRACKER_NUMBERS.items():
        value = numbers[option]
        if value is not None:
            given[name] = value * unit
    TrackerParameters(**given)
    return given


_TRACKER_NUMBERS = {
    "radius_mm": ("radius_m", 1e-3),
    "exit_deg": ("exit_deg", 1.0),
    "exit_width_mm": ("exit_width_m", 1e-3),
    "depth_mm": ("depth_m", 1e-3),
    "passage_mm": ("passage_length_m", 1e-3),
    "px_per_mm": ("px_per_mm", 1.0),
}
"""Which parameter an option is, and its unit in the parameter's."""


def analysis_parameters(
    *, contact_factor: float | None, body_width_mm: float | None, no_chamber: bool = False
) -> dict[str, Any]:
    """Return the analysis' parameters that the options give.

    Raises
    ------
    BadInput
        Where they contradict each other or make no sense.
    """
    options = {
        "no_chamber": no_chamber, "contact_factor": contact_factor, "body_width_mm": body_width_mm,
    }  # fmt: skip
    reason = "says that there is no wall to touch"
    refuse_together(options, reason, "no_chamber", "contact_factor", "body_width_mm")
    given: dict[str, Any] = {}
    if contact_factor is not None:  # one threshold, no hysteresis, as in the paper
        given |= {"contact_factor": contact_factor, "release_factor": contact_factor}
    if body_width_mm is not None:
        given["body_width_m"] = body_width_mm / 1e3
    AnalysisParameters(**given)
    return given
