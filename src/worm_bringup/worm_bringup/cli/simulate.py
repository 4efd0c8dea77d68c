"""`worm simulate`: trials of a simulated worm, filmed or as tables, with all of their truth."""

import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from math import isclose, nan
from pathlib import Path
from typing import Annotated, Any

import pyarrow.parquet as pq
import typer

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli import options
from worm_bringup.cli.number_options import number
from worm_bringup.cli.option_groups import grouped
from worm_bringup.cli.progress import progress_bar
from worm_bringup.cli.simulation_options import FilmOptions, Model, WormOptions
from worm_bringup.cli.terminal import say
from worm_bringup.freed_memory import keep_freed_memory
from worm_bringup.graph.in_process import Progress
from worm_bringup.outputs.results_directory import check_out, results_directory
from worm_bringup.rig.rig_file import read_rig
from worm_bringup.tracks.simulated_tracks import as_a_tracker_knows, track_table
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import TableRig
from worm_bringup.tracks.track_table import TrackTable
from worm_model.filament.parameters import LEAST_EXIT_WIDTHS
from worm_model.filament.rig import FilamentRig
from worm_model.simulator.film import truth_path, write_film
from worm_model.simulator.worm import Walker, midlines_mm
from worm_msgs_py import limits, paper
from worm_msgs_py.arrays import Floats
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.units import MM_PER_M

_RIG, _MANY = "The rig", "Many trials"
DURATION, TRIALS = Limit(0.005, 10_080.0, "min"), Limit(1, 1000)
FILM_EXIT_WIDTH = Limit(0.1, 15.0, "mm", or_zero=True)
FRAME_BYTES, ROW_BYTES = 100_000, 300
"""About what a picture of the simulated rig takes in the bag, and a row in the tables."""
MOST_FRAMES = 1_000_000


@grouped
def simulate(
    *,
    out: Annotated[
        Path,
        typer.Option(
            help="The bag to make; its truth is written beside it. A directory of many trials."
        ),
    ],
    minutes: Annotated[float, number(DURATION, help="Length of a trial.")] = 1.0,
    seed: Annotated[int, number(limits.SEED, help="Same seed, same trial.")] = 0,
    model: Annotated[
        Model,
        typer.Option(
            help="An elastic filament that crawls through both chambers, or a worm that follows "
            "the wall of one by the walk's own rules until it is out, where the trial ends."
        ),
    ] = Model.FILAMENT,
    exit_width_mm: Annotated[
        list[float] | None,
        number(
            FILM_EXIT_WIDTH,
            help="W; 0: no exit; 2 where not given. Given several times, the trials take turns.",
            rich_help_panel=_RIG,
        ),
    ] = None,
    rig: options.RigFiles = None,
    trials: Annotated[int, number(TRIALS, help="Their seeds count up.", rich_help_panel=_MANY)] = 1,
    tracks_only: Annotated[
        bool,
        typer.Option(
            "--tracks-only",
            help="No pictures: write what a perfect tracker and the analysis make of them, for "
            "`worm report`.",
            rich_help_panel=_MANY,
        ),
    ] = False,
    worm: WormOptions,
    camera: FilmOptions,
) -> None:
    """Simulate a worm in the rig: a bag like the camera's, and exact truth beside it.

    Try the whole path with known answers: `worm simulate --out crawl`, then `worm replay crawl
    --out results`, and compare with crawl_truth.parquet by `worm evaluate`.
    """
    # Compiled code is slow to import, and most commands simulate nothing.
    from worm_model.simulator.filming import film

    widths_mm = exit_width_mm or [_width_mm(read_rig(rig).of("tracker"))]
    if len(widths_mm) > trials:
        raise BadInput(f"--exit-width-mm is given {len(widths_mm)} times: give --trials, too")
    frames = 60.0 * minutes * camera.fps
    if model is Model.FILAMENT:
        worm.refuse_walk_options()
    _refuse_huge(out, trials * frames, ROW_BYTES if tracks_only else FRAME_BYTES)
    keep_freed_memory()
    for index in range(trials):
        place = out / f"trial_{index:02d}" if trials > 1 else out
        width_mm = widths_mm[index % len(widths_mm)]
        one = _Trial(model, worm, camera, seed + index, width_mm, minutes)
        with progress_bar(place.name) as progress:
            if tracks_only:
                _write_results_tables(one, place, progress)
            else:
                lines = one.counted_midlines(progress)
                pictures = film(lines, one.rig, camera.filming(worm.body_width_mm))
                write_film(place, pictures, jpeg_quality=camera.jpeg_quality)
        if one.escaped:
            say(f"The worm is out after {one.frames / one.fps:.1f} s: the trial ends there.")
        if tracks_only:
            say(f"Results: {place}")
        else:
            say(f"Bag: {place}\nTruth: {truth_path(place)}")


def _width_mm(seen: dict[str, Any]) -> float:
    """Return the exit's width of a rig file; refuse a rig that is not simulated."""
    fixed = {"radius_m": paper.RADIUS_MM, "passage_m": paper.PASSAGE_LENGTH_MM}
    for name, value_mm in fixed.items():
        if not isclose(seen.get(name, value_mm / MM_PER_M) * MM_PER_M, value_mm):
            raise BadInput(
                f"--rig: {name} is {seen[name]:g}: the simulated rig is the paper's, with "
                f"{value_mm / MM_PER_M:g} m: leave it out of the file, or simulate without --rig"
            )
    if seen.get("polarity") == "bright" or seen.get("no_chamber"):
        raise BadInput("--rig: a simulated worm is dark and in its chamber: leave out --rig")
    return float(seen["exit_width_m"] * MM_PER_M) if "exit_width_m" in seen else 2.0


class _Trial:
    """One worm in one rig."""

    def __init__(
        self,
        model: Model,
        worm: WormOptions,
        camera: FilmOptions,
        seed: int,
        exit_width_mm: float,
        minutes: float,
    ):
        self._seed, self.exit_width_mm = seed, exit_width_mm
        self.fps, self._duration_s = camera.fps, 60.0 * minutes
        self.frames = 0
        self.rig = camera.rig(exit_width_mm, seed)
        self.width_mm = worm.body_width_mm
        self._model = model
        self._worm = worm.walker(seed) if model is Model.WALK else worm.filament()
        if model is Model.FILAMENT and 0.0 < exit_width_mm < LEAST_EXIT_WIDTHS * self.width_mm:
            raise BadInput(
                f"--exit-width-mm is {exit_width_mm:g}: a body {self.width_mm:g} mm wide "
                f"(--body-width-mm) needs {LEAST_EXIT_WIDTHS * self.width_mm:g} or more"
            )

    @property
    def escaped(self) -> bool:
        """Whether the worm got out before the trial's time was over."""
        return self.frames < round(self._duration_s * self.fps)

    def counted_midlines(self, progress: Progress) -> Iterator[Floats]:
        """Yield the worm at every frame; `frames` counts them."""
        for line in self.midlines():
            yield line
            self.frames += 1
            progress(self.frames, round(self._duration_s * self.fps))
        progress(self.frames, self.frames)

    def midlines(self) -> Iterator[Floats]:
        """Yield the worm at every frame, in chamber a's frame, mm."""
        if isinstance(self._worm, Walker):
            return midlines_mm(
                self._worm, paper.RADIUS_MM, self._duration_s, self.fps, self.exit_width_mm
            )
        from worm_model.filament.trial import frames

        return frames(
            self._worm,
            FilamentRig(exit_width_mm=self.exit_width_mm),
            seed=self._seed,
            duration_s=self._duration_s,
            frames_per_s=self.fps,
        )

    def provenance(self) -> dict[str, Any]:
        """Return what makes the same trial again."""
        numbers = {"frames_per_s": self.fps, "duration_s": self._duration_s, **asdict(self._worm)}
        return {"simulated": self._model.value, "seed": self._seed, **numbers}


def _write_results_tables(one: _Trial, place: Path, progress: Progress) -> None:
    """Write a results directory without pictures, bag and report."""
    check_out(place)
    with results_directory(place) as partial, tempfile.TemporaryDirectory() as folder:
        tracks = Path(folder) / f"{place.name}.parquet"
        lines = one.counted_midlines(progress)
        table = track_table(lines, one.fps, one.width_mm)
        pq.write_table(as_a_tracker_knows(table), tracks)
        rig = TableRig(exit_width_mm=one.exit_width_mm or nan)
        analyse_tracks(
            TrackTable(tracks),
            rig,
            AnalysisParameters(),
            partial,
            source=one.provenance(),
            rounded=True,
        )


def _refuse_huge(out: Path, frames: float, frame_bytes: int) -> None:
    """Refuse trials that nobody would wait for, or that their disk cannot hold."""
    cure = "give fewer --minutes or --trials, or a lower --fps"
    if frames > MOST_FRAMES and frame_bytes == FRAME_BYTES:
        raise BadInput(f"--minutes times --fps is {frames:.0f} frames: {cure}")
    disk = next(folder for folder in out.absolute().parents if folder.exists())
    free = shutil.disk_usage(disk).free
    if frames * frame_bytes > free:
        raise BadInput(
            f"--out {out}: {frames:.0f} frames take about {frames * frame_bytes / 1e9:.1f} GB, "
            f"{free / 1e9:.1f} GB are free: {cure}"
        )
