"""Options that several subcommands share, and the groups that go together."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli.number_options import declared_number, number, numbers
from worm_bringup.cli.usage_errors import refuse_together, refuse_without
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.nodes import NODES
from worm_bringup.overlay.foxglove_server import DEFAULT_PORT
from worm_bringup.rig.rig_file import RigParameters
from worm_msgs_py import limits
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.network import Reach
from worm_msgs_py.ros.watchdog import PATIENCE, PATIENCE_S
from worm_msgs_py.units import MM_PER_M
from worm_tracker.detection.polarity import Polarity
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.scan.decompression import CHUNK_MIB
from worm_tracker.sources.image_decoder import MEGAPIXELS

_PICTURE = "The picture"
RIG = "The rig"
ANALYSIS = "The analysis"
GRAPH = "The graph"
DAMAGE = "Damaged bags"
RigFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--rig",
        help="Parameter file in ROS's own form: camera, rig, contact rule, notes of the trial. "
        "Of several the last one wins, and options win over files.",
    ),
]


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
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
PolarityOption = Annotated[
    Polarity | None,
    typer.Option(
        help="Is the worm dark on bright or bright on dark? Dark where not given.",
        rich_help_panel=_PICTURE,
    ),
]
NoChamber = Annotated[
    bool,
    typer.Option("--no-chamber", help="There is no rig in view.", rich_help_panel=_PICTURE),
]
RadiusMm = Annotated[
    float | None,
    number(
        limits.RADIUS.to("mm"),
        help="The chamber's known radius R, which gives pictures their scale; 10 where not given.",
        rich_help_panel=RIG,
    ),
]
CIRCLE = {"U": limits.PLACE_PX, "V": limits.PLACE_PX, "RADIUS": limits.RADIUS_PX}
CirclePx = Annotated[
    tuple[float, float, float] | None,
    numbers(
        "The wall's circle in pixels, instead of looking for it.",
        rich_help_panel=_PICTURE,
        **CIRCLE,
    ),
]
CircleBPx = Annotated[
    tuple[float, float, float] | None,
    numbers("The same of a second chamber, with --circle-px.", rich_help_panel=_PICTURE, **CIRCLE),
]
ExitDeg = Annotated[
    float | None,
    number(
        limits.ANGLE,
        help="Direction of the exit, counter-clockwise from the picture's right.",
        rich_help_panel=RIG,
    ),
]
ExitWidthMm = Annotated[
    float | None,
    number(
        limits.EXIT_WIDTH.to("mm"),
        help="Width W of the exit, instead of measuring it in pictures.",
        rich_help_panel=RIG,
    ),
]
DepthMm = Annotated[
    float | None,
    number(
        limits.DEPTH.to("mm"),
        help="Thickness h of the sheet, which no picture shows; 1.5 where not given.",
        rich_help_panel=RIG,
    ),
]
PassageMm = Annotated[
    float | None,
    number(
        limits.PASSAGE_LENGTH.to("mm"),
        help="Length L of the passage, instead of measuring it in pictures of two chambers; "
        "otherwise 35.",
        rich_help_panel=RIG,
    ),
]
PxPerMm = Annotated[
    float | None,
    number(limits.PX_PER_MM, help="Scale, with --no-chamber.", rich_help_panel=_PICTURE),
]
Processes = Annotated[
    bool,
    typer.Option("--processes", help="A process for each node.", rich_help_panel=GRAPH),
]
Network = Annotated[
    bool,
    typer.Option(
        "--network",
        help="Let other machines see the graph too, as ROS_* of the environment says "
        "(docs/network.md).",
        rich_help_panel=GRAPH,
    ),
]
WatchdogS = Annotated[
    float,
    number(
        PATIENCE,
        help="Seconds that a node may take over one message; longer, and it hangs: the run ends.",
        rich_help_panel=GRAPH,
    ),
]
Namespace = Annotated[
    str,
    typer.Option(
        help="ROS namespace, such as /rig1.", callback=_check_namespace, rich_help_panel=GRAPH
    ),
]

Foxglove = Annotated[
    bool,
    typer.Option(
        "--foxglove",
        help="Serve Foxglove: pictures, what is drawn over them, frames and numbers. Needs "
        "pip install 'worm-escape[foxglove]'.",
        rich_help_panel=GRAPH,
    ),
]
FoxglovePort = Annotated[
    int | None,
    typer.Option(
        help=f"Port that Foxglove connects to, {DEFAULT_PORT} where not given; 0: any that is "
        "free. Two rigs need two.",
        min=0,
        max=65535,
        rich_help_panel=GRAPH,
    ),
]
FoxgloveHost = Annotated[
    str | None,
    typer.Option(
        help="Address that Foxglove is served at, this machine alone where not given; 0.0.0.0 is "
        "everybody on the network, without a password.",
        rich_help_panel=GRAPH,
    ),
]

MaxChunkMib = Annotated[
    float | None,
    number(
        CHUNK_MIB,
        help="Largest piece of a bag, decompressed, that is read, MiB: no small file fills the "
        "memory; 512 where not given.",
        rich_help_panel=DAMAGE,
    ),
]
MaxMegapixels = Annotated[
    float | None,
    number(
        MEGAPIXELS,
        help="Larger pictures are bad ones: they are not decoded; 64 where not given.",
        rich_help_panel=DAMAGE,
    ),
]


@dataclass(frozen=True)
class GraphOptions:
    """Who can see the graph, and how long a node may take."""

    network: Network = False
    watchdog_s: WatchdogS = PATIENCE_S
    namespace: Namespace = ""

    def reach(self, *, visible: bool, otherwise: str) -> Reach:
        """Return who can see the graph.

        Raises
        ------
        BadInput
            Where a hidden graph is to be opened to the network; `otherwise` is what to do.
        """
        if self.network and not visible:
            raise BadInput(f"--network opens a graph that others can see: {otherwise}")
        if self.network:
            return Reach.NETWORK
        return Reach.MACHINE if visible else Reach.OWN


@dataclass(frozen=True)
class ViewOptions:
    """Who is shown the trial while it runs."""

    foxglove: Foxglove = False
    foxglove_port: FoxglovePort = None
    foxglove_host: FoxgloveHost = None

    def viewers(self, told: RigParameters, *, visible: bool) -> tuple[NodeSpec, ...]:
        """Return the nodes that only look, after a rig file; the overlay's where others see it.

        Raises
        ------
        BadInput
            Where an address is given that nobody serves.
        """
        options = asdict(self)
        for name in ("foxglove_port", "foxglove_host"):
            refuse_without(options, name, "foxglove", "is where Foxglove is served")
        given = {"port": self.foxglove_port, "host": self.foxglove_host}
        address = {name: value for name, value in given.items() if value is not None}
        names = ["overlay"] * visible + ["foxglove"] * self.foxglove
        parameters = {"overlay": told.of("overlay"), "foxglove": told.of("foxglove") | address}
        return tuple(NodeSpec(NODES[name], name, parameters[name]) for name in names)


@dataclass(frozen=True)
class TrackerOptions:
    """What is to be seen in the pictures."""

    polarity: PolarityOption = None
    no_chamber: NoChamber = False
    radius_mm: RadiusMm = None
    circle_px: CirclePx = None
    circle_b_px: CircleBPx = None
    exit_deg: ExitDeg = None
    exit_width_mm: ExitWidthMm = None
    depth_mm: DepthMm = None
    passage_mm: PassageMm = None
    px_per_mm: PxPerMm = None

    def parameters(self, rig: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the tracker's parameters: those of the rig file, and the options over them.

        Raises
        ------
        BadInput
            Where they contradict each other or make no sense.
        """
        options = asdict(self)
        of_rig = [name for name in options if name not in ("polarity", "no_chamber", "px_per_mm")]
        refuse_together(options, "says that there is no rig in view", "no_chamber", *of_rig)
        given: dict[str, Any] = {**(rig or {})}
        known = options | {
            "no_chamber": self.no_chamber or given.get("no_chamber"),
            "circle_px": self.circle_px or given.get("radius_px"),
        }
        why = "is the scale of pictures without a chamber; with one, --radius-mm gives it"
        refuse_without(known, "px_per_mm", "no_chamber", why)
        refuse_without(known, "circle_b_px", "circle_px", "is a second chamber")
        if self.polarity is not None:
            given["polarity"] = str(self.polarity)
        if self.no_chamber:
            given["no_chamber"] = True
        if self.circle_px is not None:
            names = ("centre_u_px", "centre_v_px", "radius_px")
            given |= dict(zip(names, self.circle_px, strict=True))
        if self.circle_b_px is not None:
            names = ("centre_b_u_px", "centre_b_v_px", "radius_b_px")
            given |= dict(zip(names, self.circle_b_px, strict=True))
        for option, (name, unit) in TRACKER_NUMBERS.items():
            if options[option] is not None:
                given[name] = options[option] * unit
        TrackerParameters(**given)
        return given


TRACKER_NUMBERS = {
    "radius_mm": ("radius_m", 1e-3),
    "exit_deg": ("exit_deg", 1.0),
    "exit_width_mm": ("exit_width_m", 1e-3),
    "depth_mm": ("depth_m", 1e-3),
    "passage_mm": ("passage_m", 1e-3),
    "px_per_mm": ("px_per_mm", 1.0),
}
"""Which parameter an option is, and its unit in the parameter's."""


_OF_ANALYSIS = {declared.name: declared for declared in declarations(AnalysisParameters)}


def _analysis_option(name: str) -> Any:
    """Return the option of one of the analysis' parameters, as that tells of itself."""
    return declared_number(_OF_ANALYSIS[name], ANALYSIS)


BodyWidthMm = Annotated[
    float | None,
    number(
        limits.BODY_WIDTH.to("mm"),
        help="The worm's width d_w; measured in the trial where not given.",
        rich_help_panel=ANALYSIS,
    ),
]


@dataclass(frozen=True)
class AnalysisOptions:
    """What the analysis takes for a contact, and over which times it looks."""

    contact_factor: Annotated[float | None, _analysis_option("contact_factor")] = None
    release_factor: Annotated[float | None, _analysis_option("release_factor")] = None
    body_width_mm: BodyWidthMm = None
    min_episode_s: Annotated[float | None, _analysis_option("min_episode_s")] = None
    theta_dot_window_s: Annotated[float | None, _analysis_option("theta_dot_window_s")] = None
    mean_window_s: Annotated[float | None, _analysis_option("mean_window_s")] = None
    min_head_certainty: Annotated[float | None, _analysis_option("min_head_certainty")] = None
    incidence_window_s: Annotated[float | None, _analysis_option("incidence_window_s")] = None
    max_gap_s: Annotated[float | None, _analysis_option("max_gap_s")] = None
    max_bridged_s: Annotated[float | None, _analysis_option("max_bridged_s")] = None
    max_lag_s: Annotated[float | None, _analysis_option("max_lag_s")] = None
    fine_lag_s: Annotated[float | None, _analysis_option("fine_lag_s")] = None
    fine_step_s: Annotated[float | None, _analysis_option("fine_step_s")] = None
    coarse_step_s: Annotated[float | None, _analysis_option("coarse_step_s")] = None
    stroke_window_s: Annotated[float | None, _analysis_option("stroke_window_s")] = None
    minimum_n: Annotated[int | None, _analysis_option("minimum_n")] = None
    summary_interval_s: Annotated[float | None, _analysis_option("summary_interval_s")] = None

    def parameters(
        self, rig: Mapping[str, Any] | None = None, *, no_chamber: bool = False
    ) -> dict[str, Any]:
        """Return the analysis' parameters: those of the rig file, and the options over them.

        Raises
        ------
        BadInput
            Where they contradict each other or make no sense.
        """
        options = {"no_chamber": no_chamber, **asdict(self)}
        reason = "says that there is no wall to touch"
        refuse_together(options, reason, "no_chamber", "contact_factor", "body_width_mm")
        given = {name: value for name, value in asdict(self).items() if value is not None}
        if "body_width_mm" in given:
            given["body_width_m"] = given.pop("body_width_mm") / MM_PER_M
        merged = {**(rig or {}), **given}
        AnalysisParameters(**merged)
        return merged
