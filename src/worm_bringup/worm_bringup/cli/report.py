"""`worm report`: draw the figures of results that are there already."""

from pathlib import Path
from typing import Annotated

import typer

from worm_analysis.report import write_report


def report(
    results: Annotated[list[Path], typer.Argument(help="Directories made by worm replay.")],
) -> None:
    """Write report.html anew in each results directory."""
    for directory in results:
        typer.echo(f"Report: {write_report(directory)}")
