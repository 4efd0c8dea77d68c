"""`worm live`: watch the rig through a camera, and record it."""

from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli import options
from worm_bringup.cli.grouped import grouped
from worm_bringup.cli.numbers import number
from worm_bringup.cli.progress import progress_bar, refuse_without_pose, show_result, show_speed
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out
from worm_bringup.trial import EndedEarly, Incomplete, Trial, run_graph, run_trial
from worm_msgs_py.errors import BadInput, TrackerError
from worm_tracker.sources.camera_node import RECONNECT
from worm_tracker.sources.cameras.camera_address import Kind, kind_of, shown_address

_CAMERA = "The camera"
_CAMERAS, _SIMULATED = "worm_tracker.sources.camera_node", "worm_bringup.simulated_camera"
SIMULATED = "sim"
"""The address of the simulated rig."""


@grouped
def live(
    *,
    camera: Annotated[
        str,
        typer.Option(
            help="A device (/dev/video0 or 0), an http:// (MJPEG) or rtsp:// address, or a video "
            "file, played in real time; `sim` films a simulated worm. An address with a password "
            "is better given as WORM_CAMERA: everybody on this machine can read a command line.",
            envvar="WORM_CAMERA",
            rich_help_panel=_CAMERA,
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Results directory to make at the end; none where not given."),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            help="Bag to record the pictures into, as they go; its replay gives the same results.",
            rich_help_panel=_CAMERA,
        ),
    ] = None,
    reconnect_s: Annotated[
        float,
        number(
            RECONNECT,
            help="Seconds to look for a camera that was lost; then the trial ends, and exit status "
            "1 says so.",
            rich_help_panel=_CAMERA,
        ),
    ] = 600.0,
    tracker: options.TrackerOptions,
    analysis: options.AnalysisOptions,
    private: Annotated[
        bool,
        typer.Option(
            "--private",
            help="Hide the graph from other programs; otherwise Foxglove and ros2 topic on this "
            "machine see it (ROS_DOMAIN_ID applies).",
            rich_help_panel=options.GRAPH,
        ),
    ] = False,
    graph: options.GraphOptions,
) -> None:
    """Track and analyse while the camera films; Ctrl-C ends the trial in good order.

    Frames count once the graph is ready. Where the tracker lags for more than two seconds the
    newest frame wins, and what is skipped is counted.
    """
    is_simulated = camera == SIMULATED
    is_film = not is_simulated and kind_of(camera) is Kind.FILE
    film = {"--camera": Path(camera)} if is_film else {}
    check_apart({"--out": out, "--record": record}, film)
    if out is not None:
        check_out(out)
    reach = graph.reach(visible=not private, otherwise="leave out --private")
    parameters: dict[str, Any] = {"camera": camera, "reconnect": reconnect_s}
    if record is not None:
        parameters["record"] = str(record)
    trial = Trial(
        source=NodeSpec(_SIMULATED if is_simulated else _CAMERAS, "image_source", parameters),
        origin={"camera": shown_address(camera)},
        tracker=tracker.parameters(),
        analysis=analysis.parameters(no_chamber=tracker.no_chamber),
        namespace=graph.namespace,
    )
    how: dict[str, Any] = {"reach": reach, "patience_s": graph.watchdog_s}
    try:
        with progress_bar("live") as progress:
            if out is not None:
                result, report = run_trial(trial, out, progress, live=True, **how)
            else:
                result, report = run_graph(trial, None, progress, **how), None
    except TrackerError as error:  # knows the pictures, not where they come from
        raise BadInput(f"{shown_address(camera)}: {error}") from None
    if not result.complete or result.frames == 0:
        raise Incomplete(result)
    if report is not None:
        show_result(result, report)
    else:
        show_speed(result)
    if result.ended_early:
        kept = f"; the results up to there are in {out}" if out is not None else ""
        raise EndedEarly(result.ended_early + kept)
    if report is not None:
        refuse_without_pose(report)
