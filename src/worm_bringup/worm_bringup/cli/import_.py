"""`worm import`: a video, or a folder of pictures, becomes a bag."""

import sys
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.cli.number_options import number
from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.terminal import say
from worm_bringup.outputs.output_rules import check_apart
from worm_msgs_py.limits import FRAME_RATE, JPEG_QUALITY
from worm_msgs_py.text import printable
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.video_import import import_film, open_film


def import_(
    video: Annotated[
        Path, typer.Argument(help="A video, a TIFF stack, or a folder of numbered pictures.")
    ],
    out: Annotated[Path, typer.Option(help="The bag to make.")],
    fps: Annotated[
        float | None,
        number(FRAME_RATE, help="Pictures a second; a video's own times are kept where not given."),
    ] = None,
    start: Annotated[
        datetime | None,
        typer.Option(
            help="When the first picture was taken (local time); stamps begin at 0 otherwise."
        ),
    ] = None,
    jpeg_quality: Annotated[
        int | None,
        number(JPEG_QUALITY, help="Smaller, but lossy; PNG, lossless, where not given."),
    ] = None,
) -> None:
    """Turn a film that is no bag into one, every picture of it, to be replayed.

    Then: `worm replay OUT --out RESULTS`.
    """
    check_apart({"--out": out}, {"the film": video})
    film = open_film(video)
    start_ns = 0 if start is None else round(start.timestamp() * NS_PER_S)
    with progress_bar(video.name) as progress:
        done = import_film(
            film, out, fps=fps, start_ns=start_ns, jpeg_quality=jpeg_quality, progress=progress
        )
    if film.frames and done.frames != film.frames:
        print(
            f"worm: {printable(video)}: the file announces {film.frames} pictures, {done.frames} "
            "could be read; is it whole?",
            file=sys.stderr,
        )
    say(f"Bag: {out} ({done.frames} pictures, {done.duration_s:.3f} s)")
