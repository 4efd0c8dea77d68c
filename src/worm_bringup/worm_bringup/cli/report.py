"""`worm report`: draw the figures of results that are there already, of one trial or of many."""

from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from worm_analysis.report import write_pooled_report, write_report
from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.terminal import say
from worm_bringup.model_comparisons import compare_pool
from worm_bringup.outputs.earlier_result import POOLED, SOFTWARE
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.outputs.results_directory import check_out, results_directory
from worm_bringup.pooled_walks import pooled_walks


def report(
    results: Annotated[
        list[Path], typer.Argument(help="Directories made by worm replay or worm analyse.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            help="Directory for one report of all trials together; an earlier one is replaced. "
            "Without it each trial's own report is written anew."
        ),
    ] = None,
) -> None:
    """Pool trials and draw every figure of the paper, or write each trial's report anew.

    Each figure is in figures/ too, as SVG and PDF. With --out: one report.html without network,
    what its figures show as CSV in tables/, and every number in summary.json. Trials are grouped by
    the width W of the exit; intervals allow for trials that differ where there are five or more.

    A trial that is incomplete or damaged, has no chamber, or is there twice, ends the command with
    one line that names it: leave it out yourself.
    """
    if out is None:
        for directory in results:
            say(f"Report: {write_report(directory)}")
        return
    check_apart({"--out": out}, {f"trial {number}": path for number, path in enumerate(results, 1)})
    check_out(out, POOLED)
    software = {"software": SOFTWARE, "version": version("worm-escape")}
    with results_directory(out, POOLED) as partial, progress_bar(out.name) as progress:
        path = write_pooled_report(results, partial, pooled_walks, compare_pool, software, progress)
    say(f"Report: {out / path.name}")
