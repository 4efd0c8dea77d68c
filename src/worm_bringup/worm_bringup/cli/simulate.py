"""`worm simulate`: film a simulated worm in the rig, with the truth of every frame beside it."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.cli.progress import progress_bar
from worm_bringup.graph import Progress
from worm_model.simulator.film import FilmFrame, truth_path, write_film
from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.worm import Walker, simulate_film

_WORM = "The worm"
_RIG = "The rig"


def simulate(
    out: Annotated[Path, typer.Option(help="The bag to make; its truth is written beside it.")],
    duration_s: Annotated[float, typer.Option(min=0.1)] = 60.0,
    fps: Annotated[float, typer.Option(min=0.1)] = 30.0,
    seed: Annotated[int, typer.Option(help="Same seed, same film.")] = 0,
    length_mm: Annotated[float, typer.Option(min=1.0, rich_help_panel=_WORM)] = 20.0,
    body_width_mm: Annotated[float, typer.Option(min=0.05, rich_help_panel=_WORM)] = 0.4,
    speed_mm_s: Annotated[
        float, typer.Option(min=0.0, help="Along the wall.", rich_help_panel=_WORM)
    ] = 2.02,
    slide_mm: Annotated[
        float, typer.Option(min=0.01, help="Mean d_c.", rich_help_panel=_WORM)
    ] = 1.95,
    hop_mm: Annotated[
        float, typer.Option(min=0.01, help="Mean d_nc.", rich_help_panel=_WORM)
    ] = 1.46,
    excursion_mm: Annotated[
        float, typer.Option(min=0.01, help="Mean Δr_h.", rich_help_panel=_WORM)
    ] = 1.14,
    reversal: Annotated[
        float,
        typer.Option(min=0.0, max=1.0, help="Per slide and hop.", rich_help_panel=_WORM),
    ] = 0.03,
    exit_width_mm: Annotated[float, typer.Option(min=0.0, rich_help_panel=_RIG)] = 2.0,
    exit_deg: Annotated[
        float, typer.Option(help="Counter-clockwise from right.", rich_help_panel=_RIG)
    ] = 0.0,
    noise: Annotated[
        float, typer.Option(min=0.0, help="Grey levels, sd.", rich_help_panel=_RIG)
    ] = 2.0,
    jpeg_quality: Annotated[int, typer.Option(min=1, max=100, rich_help_panel=_RIG)] = 90,
) -> None:
    """Film a worm that follows the wall: a bag like the rig's, and exact truth beside it.

    Try the whole path with known answers: `worm simulate --out walk`, then `worm replay walk --out
    out/walk`, and compare with walk_truth.parquet.
    """
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
    typer.echo(f"Bag: {out}\nTruth: {truth_path(out)}")


def _counted(film: Iterable[FilmFrame], progress: Progress, total: float) -> Iterator[FilmFrame]:
    for count, frame in enumerate(film, start=1):
        yield frame
        progress(count, round(total))
