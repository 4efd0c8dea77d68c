"""`worm simulate`: film a simulated worm in the rig, with the truth of every frame beside it."""

import shutil
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.cli.numbers import number
from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.terminal import say
from worm_bringup.graph.in_process import Progress
from worm_model.simulator.film import FilmFrame, truth_path, write_film
from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.worm import Walker, simulate_film
from worm_msgs_py import limits
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

_WORM = "The worm"
_RIG = "The rig"
DURATION = Limit(0.1, 604_800.0, "s")
FILM_FPS = Limit(0.1, 1000.0, "frames/s")
FILM_BODY_LENGTH, FILM_BODY_WIDTH = Limit(1.0, 60.0, "mm"), Limit(0.05, 5.0, "mm")
FILM_SPEED = Limit(0.01, 10.0, "mm/s")
FILM_STEP, FILM_EXCURSION = Limit(0.01, 100.0, "mm"), Limit(0.01, 8.0, "mm")
FILM_EXIT_WIDTH = Limit(0.1, 15.0, "mm", or_zero=True)
NOISE = Limit(0.0, 255.0, "grey levels")
FRAME_BYTES = 100_000
"""About what a picture of the simulated rig takes in the bag."""
MOST_FRAMES = 1_000_000


def simulate(
    out: Annotated[Path, typer.Option(help="The bag to make; its truth is written beside it.")],
    duration_s: Annotated[float, number(DURATION)] = 60.0,
    fps: Annotated[float, number(FILM_FPS)] = 30.0,
    seed: Annotated[int, number(limits.SEED, help="Same seed, same film.")] = 0,
    length_mm: Annotated[float, number(FILM_BODY_LENGTH, rich_help_panel=_WORM)] = 20.0,
    body_width_mm: Annotated[float, number(FILM_BODY_WIDTH, rich_help_panel=_WORM)] = 0.4,
    speed_mm_s: Annotated[
        float, number(FILM_SPEED, help="Along the wall.", rich_help_panel=_WORM)
    ] = 2.02,
    slide_mm: Annotated[float, number(FILM_STEP, help="Mean d_c.", rich_help_panel=_WORM)] = 1.95,
    hop_mm: Annotated[float, number(FILM_STEP, help="Mean d_nc.", rich_help_panel=_WORM)] = 1.46,
    excursion_mm: Annotated[
        float, number(FILM_EXCURSION, help="Mean Δr_h.", rich_help_panel=_WORM)
    ] = 1.14,
    reversal: Annotated[
        float, number(limits.SHARE, help="Per slide and hop.", rich_help_panel=_WORM)
    ] = 0.03,
    exit_width_mm: Annotated[
        float, number(FILM_EXIT_WIDTH, help="W; 0: no exit.", rich_help_panel=_RIG)
    ] = 2.0,
    exit_deg: Annotated[
        float, number(limits.ANGLE, help="Counter-clockwise from right.", rich_help_panel=_RIG)
    ] = 0.0,
    noise: Annotated[float, number(NOISE, help="Grey levels, sd.", rich_help_panel=_RIG)] = 2.0,
    jpeg_quality: Annotated[int, number(limits.JPEG_QUALITY, rich_help_panel=_RIG)] = 90,
) -> None:
    """Film a worm that follows the wall: a bag like the rig's, and exact truth beside it.

    Try the whole path with known answers: `worm simulate --out walk`, then `worm replay walk --out
    out/walk`, and compare with walk_truth.parquet.
    """
    _refuse_huge(out, duration_s * fps)
    walker = Walker(
        length_mm=length_mm,
        width_mm=body_width_mm,
        speed_mm_s=speed_mm_s,
        mean_slide_mm=slide_mm,
        mean_hop_mm=hop_mm,
        mean_excursion_mm=excursion_mm,
        reversal_per_cycle=reversal,
        seed=seed,
    )
    rig = Rig(
        exit_rad=radians(exit_deg),
        exit_width_mm=exit_width_mm,
        optics=replace(Optics(), noise=noise, seed=seed),
    )
    with progress_bar(out.name) as progress:
        film = _counted(simulate_film(rig, walker, duration_s, fps), progress, duration_s * fps)
        write_film(out, film, jpeg_quality=jpeg_quality)
    say(f"Bag: {out}\nTruth: {truth_path(out)}")


def _counted(film: Iterable[FilmFrame], progress: Progress, total: float) -> Iterator[FilmFrame]:
    for count, frame in enumerate(film, start=1):
        yield frame
        progress(count, round(total))


def _refuse_huge(out: Path, frames: float) -> None:
    """Refuse a film that nobody would wait for, or that its disk cannot hold."""
    cure = "give a shorter --duration-s or a lower --fps"
    if frames > MOST_FRAMES:
        raise BadInput(f"--duration-s times --fps is {frames:.0f} frames: {cure}")
    disk = next(folder for folder in out.absolute().parents if folder.exists())
    free = shutil.disk_usage(disk).free
    if frames * FRAME_BYTES > free:
        raise BadInput(
            f"--out {out}: {frames:.0f} frames take about {frames * FRAME_BYTES / 1e9:.1f} GB, "
            f"{free / 1e9:.1f} GB are free: {cure}"
        )
