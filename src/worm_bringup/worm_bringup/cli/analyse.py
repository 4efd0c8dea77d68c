"""`worm analyse`: a table of tracks goes in, from any tracker; analysis and a report come out."""

from math import nan
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_analysis.parameters import AnalysisParameters
from worm_analysis.report import write_report
from worm_bringup.cli import options
from worm_bringup.cli.numbers import number, numbers
from worm_bringup.cli.progress import progress_bar, show_trial
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out, results_directory
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import TableRig, rig_of_summary
from worm_bringup.tracks.track_table import TrackTable
from worm_msgs_py import limits
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.ros.running import finish_despite_signals

_PLACE = Limit(-1e4, 1e4, "mm")


def analyse(
    tracks: Annotated[
        Path,
        typer.Argument(help="A .csv or .parquet table of tracks, or a results directory."),
    ],
    out: options.Out,
    radius_mm: options.RadiusMm = None,
    exit_width_mm: options.ExitWidthMm = None,
    passage_mm: options.PassageMm = None,
    depth_mm: options.DepthMm = None,
    centre_mm: Annotated[
        tuple[float, float] | None,
        numbers(
            "The chamber's centre in the table's millimetres; 0 0 where not given.",
            rich_help_panel=options.RIG,
            X=_PLACE,
            Y=_PLACE,
        ),
    ] = None,
    exit_deg: Annotated[
        float | None,
        number(
            limits.ANGLE,
            help="Direction of the exit, counter-clockwise from the table's x axis (with "
            "--circle-px: from the picture's right); 0 where not given.",
            rich_help_panel=options.RIG,
        ),
    ] = None,
    y_down: Annotated[
        bool,
        typer.Option(
            "--y-down",
            help="The table's y points down, as in pictures.",
            rich_help_panel=options.RIG,
        ),
    ] = False,
    circle_px: Annotated[
        tuple[float, float, float] | None,
        numbers(
            "The wall's circle in pixels: take the columns in pixels (head_u_px …).",
            rich_help_panel=options.RIG,
            **options.CIRCLE,
        ),
    ] = None,
    contact_factor: options.ContactFactor = None,
    body_width_mm: Annotated[
        float | None,
        number(
            limits.BODY_WIDTH.to("mm"),
            help="The worm's width d_w; the median of the table's width_mm where not given.",
            rich_help_panel=options.ANALYSIS,
        ),
    ] = None,
) -> None:
    """Analyse tracks that are there already, from `worm replay` or from any other tracker.

    The table has a row for each frame, in the order of time, with `stamp_ns` or `time_s`, and
    `head_x_mm`, `head_y_mm`. All else is optional: `centroid_x_mm centroid_y_mm`, `tail_x_mm
    tail_y_mm`, `head_yaw_deg`, `length_mm`, `width_mm`, `where` (chamber_a, chamber_b, passage),
    `status`, `confidence`, `head_certainty` (0.5 to 1; taken for 1 where there is none), `frame`,
    and `head_u_px head_v_px …` in pixels.
    An empty cell is a frame in which it is not known.

    Coordinates are those of the chamber: origin at its centre, x towards the middle of its exit,
    angles counter-clockwise as seen from above, unless the options say otherwise.

    Writes what `worm replay` writes, but for the bag; what the table does not allow is null in
    summary.json, with the reason.
    """
    path = tracks / "tracks.parquet" if tracks.is_dir() else tracks
    given = {
        "radius_mm": radius_mm,
        "exit_width_mm": exit_width_mm,
        "passage_mm": passage_mm,
        "depth_mm": depth_mm,
        "centre_mm": centre_mm,
        "exit_deg": exit_deg,
        "circle_px": circle_px,
    }
    told = {name: value for name, value in given.items() if value is not None}
    if y_down:
        told["y_down"] = True
    parameters = AnalysisParameters(
        **options.AnalysisOptions(contact_factor, body_width_mm).parameters()
    )
    check_apart({"--out": out}, {"the tracks": path})
    check_out(out)
    table = TrackTable(path, in_pixels=circle_px is not None)
    rig = _rig(path, told)
    with results_directory(out) as partial:
        with progress_bar(path.name) as progress:
            analyse_tracks(table, rig, parameters, partial, progress)
        with finish_despite_signals():
            report = write_report(partial)
    show_trial(out / report.name)


def _rig(path: Path, told: dict[str, Any]) -> TableRig:
    """Return the rig: as told, or as the summary beside a result's own tracks has it."""
    summary = path.with_name("summary.json")
    if path.name == "tracks.parquet" and summary.is_file():
        rig = rig_of_summary(summary)
        if rig is not None and told:
            option = "--" + next(iter(told)).replace("_", "-")
            raise BadInput(
                f"{summary}: has the rig of these tracks: leave out {option}, or copy the table "
                "to another directory"
            )
        if rig is not None:
            return rig
        if "circle_px" not in told and "centre_mm" not in told:
            raise BadInput(
                f"{summary}: saw no chamber: say with --circle-px U V RADIUS where it is"
            )
    if "circle_px" in told and {"centre_mm", "y_down"} & told.keys():
        raise BadInput("--circle-px is for tables in pixels: leave out --centre-mm and --y-down")
    return TableRig(**{"exit_width_mm": nan, **told})
