"""`worm analyse`: a table of tracks goes in, from any tracker; analysis and a report come out."""

from math import isclose, nan
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_analysis.parameters import AnalysisParameters
from worm_analysis.report import write_report
from worm_bringup.cli import options
from worm_bringup.cli.number_options import number, numbers
from worm_bringup.cli.option_groups import grouped
from worm_bringup.cli.progress import progress_bar, show_trial
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out, results_directory
from worm_bringup.recorder.metadata import TrialMetadata
from worm_bringup.rig.rig_file import read_rig
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import TableRig, rig_of_summary
from worm_bringup.tracks.track_table import TrackTable
from worm_msgs_py import limits
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.ros.running import finish_despite_signals
from worm_msgs_py.units import MM_PER_M

_PLACE = Limit(-1e4, 1e4, "mm")


@grouped
def analyse(
    *,
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
    rig: options.RigFiles = None,
    analysis: options.AnalysisOptions,
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
    from_file = read_rig(rig)
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
    parameters = AnalysisParameters(**analysis.parameters(from_file.of("analysis")))
    metadata = TrialMetadata(**from_file.of("recorder", declarations(TrialMetadata)))
    check_apart({"--out": out}, {"the tracks": path})
    check_out(out)
    seen = from_file.of("tracker")
    in_pixels = None if "radius_px" in seen and circle_px is None else circle_px is not None
    table = TrackTable(path, in_pixels=in_pixels)
    table_rig = _rig(path, told, _of_file(seen, in_pixels=table.in_pixels))
    with results_directory(out) as partial:
        with progress_bar(path.name) as progress:
            analyse_tracks(
                table, table_rig, parameters, partial, progress, metadata=metadata.given()
            )
        with finish_despite_signals():
            report = write_report(partial)
    show_trial(out / report.name)


def _of_file(seen: dict[str, Any], *, in_pixels: bool) -> dict[str, Any]:
    """Return what a rig file says of a table's rig; the wall's place is that in the pictures."""
    lengths = ("radius", "exit_width", "passage", "depth")
    told: dict[str, Any] = {
        f"{name}_mm": seen[f"{name}_m"] * MM_PER_M for name in lengths if f"{name}_m" in seen
    }
    if in_pixels and "radius_px" in seen:
        told["circle_px"] = (seen["centre_u_px"], seen["centre_v_px"], seen["radius_px"])
        told["exit_deg"] = seen.get("exit_deg", 0.0)
    return told


def _rig(path: Path, told: dict[str, Any], of_file: dict[str, Any]) -> TableRig:
    """Return the rig: as told, or as the summary beside a result's own tracks has it.

    A rig file says nothing new of a result's own rig, and must not contradict it.
    """
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
            radius_mm = of_file.get("radius_mm", rig.radius_mm)
            if not isclose(radius_mm, rig.radius_mm):
                raise BadInput(
                    f"{summary}: these tracks rest on R = {rig.radius_mm:g} mm, the rig file says "
                    f"{radius_mm:g}: replay the bag with it"
                )
            return rig
        if not {"circle_px", "centre_mm"} & {*told, *of_file}:
            raise BadInput(
                f"{summary}: saw no chamber: say with --circle-px U V RADIUS where it is"
            )
    told = {**of_file, **told}
    if "circle_px" in told and {"centre_mm", "y_down"} & told.keys():
        raise BadInput("--circle-px is for tables in pixels: leave out --centre-mm and --y-down")
    return TableRig(**{"exit_width_mm": nan, **told})
