"""`worm replay`: a bag goes in; tracks, analysis and a report come out."""

import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.checkpoints import CheckpointFolder, Checkpoints, progress_of
from worm_bringup.cli import options
from worm_bringup.cli.correction_options import check_fit, other_settings
from worm_bringup.cli.monitor_options import MonitorOptions
from worm_bringup.cli.number_options import number
from worm_bringup.cli.option_groups import grouped
from worm_bringup.cli.progress import progress_bar, refuse_without_pose, show_result
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.outputs.earlier_result import TRIAL
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out
from worm_bringup.provenance import bag_hash
from worm_bringup.recorder.metadata import TrialMetadata
from worm_bringup.rig.rig_file import read_rig
from worm_bringup.trial import Incomplete, Trial, run_trial
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import BadInput, TrackerError
from worm_msgs_py.files.corrections import read_corrections
from worm_tracker.parameters import HOLD_BACK, MOST_HOLD_BACK_FRAMES, TrackerParameters
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.playback import NO_SEEK, PLAYBACK, RATE, START_OFFSET
from worm_tracker.sources.replay_node import ReplayNode

_PLAYER = "The player (as in ros2 bag play)"


@grouped
def replay(
    *,
    bag: Annotated[Path, typer.Argument(help="A rosbag2 directory, an .mcap or a .db3 file.")],
    out: options.Out,
    topic: Annotated[
        str, typer.Option(help="Topic of the pictures; found where there is one.")
    ] = "",
    rate: Annotated[
        float | None,
        number(
            RATE,
            help="1 is real time; 0, where not given, is as fast as the graph can take it.",
            rich_help_panel=_PLAYER,
        ),
    ] = None,
    start_offset: Annotated[
        float | None,
        number(START_OFFSET, help="Seconds to leave out.", rich_help_panel=_PLAYER),
    ] = None,
    playback_duration: Annotated[
        float | None, number(PLAYBACK, help="Seconds to play.", rich_help_panel=_PLAYER)
    ] = None,
    loop: Annotated[
        bool,
        typer.Option(
            "--loop",
            help="Begin again at the end, until Ctrl-C; the results hold every round.",
            rich_help_panel=_PLAYER,
        ),
    ] = False,
    start_paused: Annotated[
        bool,
        typer.Option(
            "--start-paused",
            help="Wait for the service ~/resume or ~/play_next (with --visible or --monitor).",
            rich_help_panel=_PLAYER,
        ),
    ] = False,
    with_pictures: Annotated[
        bool,
        typer.Option(
            "--with-pictures",
            help="Copy the pictures into OUT/bag too, as they came: it shows the worm under its "
            "midline in other software, and can be replayed.",
        ),
    ] = False,
    hold_back_frames: Annotated[
        int | None,
        number(
            HOLD_BACK,
            help="Most frames that wait for the decision which end is the head, "
            f"{MOST_HOLD_BACK_FRAMES} where not given; a live trial has "
            f"{TrackerParameters().hold_back_frames}.",
        ),
    ] = None,
    rig: options.RigFiles = None,
    tracker: options.TrackerOptions,
    analysis: options.AnalysisOptions,
    corrections: Annotated[
        Path | None,
        typer.Option(
            help="A corrections.json, or the results directory that holds one: where people have "
            "set right which end is the head.",
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Go on with a replay into OUT that was stopped; the results are the same.",
        ),
    ] = False,
    processes: options.Processes = False,
    visible: Annotated[
        bool,
        typer.Option(
            "--visible",
            help="Let other programs on this machine see the graph (ROS_DOMAIN_ID applies); "
            "otherwise it keeps to itself.",
            rich_help_panel=options.GRAPH,
        ),
    ] = False,
    view: options.ViewOptions,
    monitor: MonitorOptions,
    graph: options.GraphOptions,
    salvage: Annotated[
        bool,
        typer.Option(
            "--salvage",
            help="Go over what is damaged in the bag, and say what was lost.",
            rich_help_panel=options.DAMAGE,
        ),
    ] = False,
    max_chunk_mib: options.MaxChunkMib = None,
    max_megapixels: options.MaxMegapixels = None,
) -> None:
    """Replay a bag of a past trial: every frame, none lost, the same bytes every time.

    Writes tracks.parquet, contacts.parquet, passages.parquet, summary.json, report.html, figures/
    and bag/ into OUT, whole or not at all. A replay that is stopped leaves a checkpoint beside OUT,
    which the same command goes on from with --resume.
    """
    told = read_rig(rig, graph.namespace)
    given = {
        "bag": str(bag),
        "topic": topic or None,
        "rate": rate,
        "start_offset": start_offset,
        "playback_duration": playback_duration,
        "loop": loop or None,
        "start_paused": start_paused or None,
        "salvage": salvage or None,
        "max_chunk_mib": max_chunk_mib,
        "max_megapixels": max_megapixels,
    }
    player = {declared.name: declared.default for declared in ReplayNode.PARAMETERS}
    player |= told.of("image_source", ReplayNode.PARAMETERS)
    player |= {name: value for name, value in given.items() if value is not None}
    if player["playback_duration"] < 0.0:  # to the end
        del player["playback_duration"]
    if resume and (processes or player["loop"]):
        one = "--processes" if processes else "--loop"
        raise BadInput(f"--resume goes with no {one}, which makes no checkpoints: leave one out")
    metadata = told.of("recorder", declarations(TrialMetadata))
    page = monitor.page(told.of("monitor"), metadata.get("trial") or bag.name, player)
    waits = {"--start-paused": player["start_paused"], "seek_to": player["seek_to"] != NO_SEEK}
    if any(waits.values()) and not visible and page is None:
        which = next(name for name in waits if waits[name])
        raise BadInput(
            f"{which} waits for a service call, which reaches only a visible graph: "
            "add --visible, or --monitor"
        )
    if processes and visible:
        raise BadInput(
            "--processes keeps to a ROS domain of its own: leave out --visible, or --processes"
        )
    corrected = () if corrections is None else read_corrections(corrections)
    if corrected and player["loop"]:
        raise BadInput("--corrections are of one round of the recording: leave out --loop")
    reach = graph.reach(visible=visible, otherwise="add --visible")
    check_apart({"--out": out}, {"the bag": bag})
    check_out(out, replace(TRIAL, corrections=corrected))
    with BagPictures(
        bag,
        player["topic"] or None,
        salvage=player["salvage"],
        max_chunk_mib=player["max_chunk_mib"],
        max_megapixels=player["max_megapixels"],
    ) as pictures:
        chosen = pictures.topic
    if corrected:
        check_fit(corrections, corrected, player)
    see = {"hold_back_frames": MOST_HOLD_BACK_FRAMES, **told.of("tracker")}
    if hold_back_frames is not None:
        see["hold_back_frames"] = hold_back_frames
    if max_megapixels is not None or "max_megapixels" not in see:
        see["max_megapixels"] = player["max_megapixels"]
    trial = Trial(
        source=NodeSpec("worm_tracker.sources.replay_node", "image_source", player),
        origin={
            "bag": bag.name,
            "sha256": bag_hash(bag),
            "topic": chosen,
            "start_offset_s": player["start_offset"],
            "playback_duration_s": player.get("playback_duration"),
        }
        | ({"salvaged": "what is damaged was passed over"} if player["salvage"] else {}),
        tracker=tracker.parameters(see),
        analysis=analysis.parameters(told.of("analysis"), no_chamber=tracker.no_chamber),
        model=told.of("model"),
        metadata=metadata,
        namespace=graph.namespace,
        viewers=view.viewers(told, visible=visible),
        with_pictures=with_pictures,
        corrections=corrected,
    )
    doubt = other_settings(corrections, trial.parameters["tracker"]) if corrected else ""
    if doubt:
        _say(doubt)
    checkpoints = None
    if not (processes or player["loop"]):
        folder = CheckpointFolder(out)
        checkpoints = Checkpoints(folder, trial.fingerprint, resume=resume, say=_say)
    try:
        with progress_bar(bag.name) as progress:
            result, report = run_trial(
                trial,
                out,
                progress,
                processes=processes,
                reach=reach,
                checkpoints=checkpoints,
                patience_s=graph.watchdog_s,
                monitor=page,
            )
    except Incomplete as error:
        if checkpoints is not None and checkpoints.saved is not None:
            error.add_note(f"{progress_of(checkpoints.saved)}; go on with: {_with_resume()}")
        raise
    except TrackerError as error:  # knows the pictures, not where they come from
        raise BadInput(f"{bag}: {error}") from None
    show_result(result, report)
    refuse_without_pose(report)


def _say(line: str) -> None:
    print(f"worm: {line}", file=sys.stderr)


def _with_resume() -> str:
    """Return this command with --resume."""
    given = [word for word in sys.argv[1:] if word != "--resume"]
    return shlex.join(["worm", *given, "--resume"])
