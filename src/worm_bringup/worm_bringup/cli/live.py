"""`worm live`: watch the rig through a camera, and record it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli import options
from worm_bringup.cli.camera_options import CameraOptions
from worm_bringup.cli.monitor_options import MonitorOptions
from worm_bringup.cli.option_groups import grouped
from worm_bringup.cli.progress import progress_bar, refuse_without_pose, show_result, show_speed
from worm_bringup.graph.in_process import RunResult
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out
from worm_bringup.recorder.metadata import TrialMetadata
from worm_bringup.rig.rig_file import read_rig
from worm_bringup.trial import (
    EndedEarly,
    Incomplete,
    Trial,
    next_trial,
    run_graph,
    run_trial,
)
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import BadInput, TrackerError


@grouped
def live(
    *,
    camera: CameraOptions,
    out: Annotated[
        Path | None,
        typer.Option(help="Results directory to make at the end; none where not given."),
    ] = None,
    rig: options.RigFiles = None,
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
    view: options.ViewOptions,
    monitor: MonitorOptions,
    graph: options.GraphOptions,
) -> None:
    """Track and analyse while the camera films; Ctrl-C ends the trial in good order.

    Results and report are then written; Ctrl-C once more leaves the report out (`worm report`).

    Where the monitor's page (or the camera's service ~/new_trial) asks for a new trial, this one
    ends in the same way and the next begins: into OUT-2, recorded into RECORD-2.

    Frames count once the graph is ready. Where the tracker lags for more than twenty seconds (or
    512 MB of pictures) the newest frame wins, and what is skipped is counted.
    """
    told = read_rig(rig, graph.namespace)
    camera = camera.over(told.of("image_source"))
    source = camera.source(told.of("image_source"), private=private)
    check_apart({"--out": out, "--record": camera.record}, camera.inputs)
    if out is not None:
        check_out(out)
    reach = graph.reach(visible=not private, otherwise="leave out --private")
    trial = Trial(
        source=source,
        origin=camera.origin(source),
        tracker=tracker.parameters(told.of("tracker")),
        analysis=analysis.parameters(told.of("analysis"), no_chamber=tracker.no_chamber),
        model=told.of("model"),
        metadata=told.of("recorder", declarations(TrialMetadata)),
        namespace=graph.namespace,
        viewers=view.viewers(told, visible=not private),
    )
    page = monitor.page(told.of("monitor"), trial.metadata.get("trial") or camera.shown)
    how = {"reach": reach, "patience_s": graph.watchdog_s, "monitor": page}
    now, into = trial, out
    while _filmed(now, into, camera.shown, how).next_is_asked:
        now, into = next_trial(trial, out)


def _filmed(trial: Trial, out: Path | None, camera: str, how: Mapping[str, Any]) -> RunResult:
    """Run one trial to its end, and say what was found."""
    try:
        with progress_bar("live") as progress:
            if out is not None:
                result, report = run_trial(trial, out, progress, live=True, **how)
            else:
                result, report = run_graph(trial, None, progress, **how), None
    except TrackerError as error:  # knows the pictures, not where they come from
        raise BadInput(f"{camera}: {error}") from None
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
    return result
