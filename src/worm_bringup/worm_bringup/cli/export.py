"""`worm export`: a result in a form that other programs show."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.terminal import say
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.overlay.film import write_overlay_film
from worm_msgs_py.errors import BadInput


class Form(StrEnum):
    """What a result can be exported to."""

    MP4 = "mp4"


def export(
    results: Annotated[Path, typer.Argument(help="Directory made by worm replay or worm live.")],
    to: Annotated[Form, typer.Option(help="mp4: a film, wall, midline and ends drawn over it.")],
    out: Annotated[
        Path | None,
        typer.Option(help="File to make; RESULTS.mp4 beside the results where not given."),
    ] = None,
    bag: Annotated[
        Path | None,
        typer.Option(
            help="The bag that was replayed or recorded, where the results do not hold the "
            "pictures (worm replay --with-pictures)."
        ),
    ] = None,
) -> None:
    """Draw what was found over every picture of a trial.

    Frame n of the film is frame n of the tracks, at the trial's usual rate. A frame that is in
    doubt looks so: pale where the status is not plainly tracked, hollow ends where head and tail
    may be exchanged, and the reason in the corner. A file that is there already is not replaced.
    """
    film = out if out is not None else results.resolve().with_suffix(f".{to}")
    if film.suffix.lower() != f".{to}":
        raise BadInput(f"--out {film}: name a file that ends in .{to}")
    check_apart(
        {"--out": film}, {"the results": results} | ({"the bag": bag} if bag is not None else {})
    )
    with progress_bar(film.name) as progress:
        count = write_overlay_film(results, film, bag, progress)
    say(f"{count} frames: {film}")
