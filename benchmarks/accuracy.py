"""How near the tracker comes to the truth, on each film of `worm_model.simulator.scenes`.

Pictures of 1024 × 1024 px at 40 px/mm (the whole rig: 1280 × 480 px at 16 px/mm), noise of 3 grey
levels. The figures are those of `worm evaluate`; a star marks one that misses its bar. Three more
films show a worm that walks along the wall and never folds: in two real skins, and with a tail that
tapers to a tenth of the width.
`python -m benchmarks.accuracy SCENE…` measures only these.
"""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from math import degrees
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.fold_films import OPEN, filmed
from worm_analysis.analysis import Analysis
from worm_analysis.results.tracks import track_row
from worm_model.evaluation import ChamberCircle, Evaluation, evaluate_tracks, frame_table_of
from worm_model.simulator.film import FilmFrame
from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Geometry, TrackedFrame
from worm_msgs_py.errors import TrackerError
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

FIGURES = (  # heading, figure, bar, whether the figure must be at least (+1) or at most (-1) that
    ("head px", "head_error_median", 0.5, -1),
    ("95 %", "head_error_95", 1.5, -1),
    ("tips 95 %", "tip_nearer_end_error_95", 1.5, -1),
    ("centroid", "centroid_error_median", 0.3, -1),
    ("midline", "midline_rms_median", 0.5, -1),
    ("shape", "midline_shape_rms_median", 0.5, -1),
    ("right end", "right_end_for_head", 0.995, 1),
    ("if certain", "right_end_where_certain", 1.0, 1),
    ("certain", "certain_of_the_head", 0.0, 1),
    ("tracked", "tracked", 0.95, 1),
    ("contact", "contact_agreement_where_told", 0.97, 1),
    ("told", "contact_told", 0.0, 1),
    ("F1", "contact_episode_f1", 0.95, 1),
    ("where", "where_agreement", 1.0, 1),
    ("centre px", "chamber_a_centre_error", 0.15, -1),
    ("R %", "chamber_a_radius_error", 0.1, -1),
    ("exit °", "chamber_a_exit_error", 0.3, -1),
    ("b: centre", "chamber_b_centre_error", 0.15, -1),
    ("R %", "chamber_b_radius_error", 0.1, -1),
    ("exit °", "chamber_b_exit_error", 0.3, -1),
)

LOOKS = {f"{OPEN}_{look}": look for look in ("skin_w4", "skin_w5", "thin_tail")}
"""More films, by name: how the worm looks in them."""
MOST_LENGTH_ERROR = 0.02


def frames_of(name: str, take: Take) -> Iterator[FilmFrame]:
    """Film a scene, or a look."""
    if name in SCENES:
        return SCENES[name](take)
    return (frame for frame, _ in filmed(OPEN, LOOKS[name], take.frames))


def measured(scene: str, take: Take) -> tuple[Evaluation, float, float]:
    """Track a scene as the graph would, and compare its tracks with the truth.

    Returns
    -------
    Evaluation
    float
        Median of the width over the true one.
    float
        Part of the lengths that are given that are within 2 % of the true one.
    """
    tracker, analysis = Tracker(TrackerParameters()), Analysis()
    rows: list[dict[str, Any]] = []
    truth: list[dict[str, Any]] = []

    def keep(given: list[TrackedFrame]) -> None:
        for tracked in given:
            observables, _ = analysis.push(tracked)
            rows.append(dict(track_row(tracked.state, tracked.midline, observables)))

    for frame in frames_of(scene, take):
        truth.append(asdict(frame.truth))
        keep(tracker.push(frame.picture, frame.stamp_ns))
    keep(tracker.finish())
    evaluation = evaluate_tracks(
        frame_table_of("tracks", columns(rows), circles(tracker.geometry)),
        frame_table_of("truth", columns(truth)),
    )
    width, length = (
        np.array([row[name] for row in rows], float) / [row[name] for row in truth]
        for name in ("width_mm", "length_mm")
    )
    known = length[np.isfinite(length)]
    right = float((np.abs(known - 1) < MOST_LENGTH_ERROR).mean()) if len(known) else np.nan
    return evaluation, float(np.nanmedian(width)), right


def columns(rows: list[dict[str, Any]]) -> dict[str, list[Any]]:
    return {name: [row[name] for row in rows] for name in rows[0]}


def circles(geometry: Geometry | None) -> dict[str, ChamberCircle]:
    return {
        chamber.name: ChamberCircle(
            chamber.centre_u_px, chamber.centre_v_px, chamber.radius_px, degrees(chamber.exit_rad)
        )
        for chamber in (geometry.chambers if geometry else ())
    }


def cells(evaluation: Evaluation, width: float, length: float) -> list[str]:
    """Return the figures as text, a star where a bar is missed, a dash where there is none."""
    found = {figure.name: figure.value for figure in evaluation.figures}
    texts = []
    for _, name, bar, sense in FIGURES:
        value = found.get(name)
        if value is None:
            texts.append("–")
            continue
        text = f"{value:.3f}" + ("*" if sense * value < sense * bar else "")
        if name == "contact_episode_f1":
            text += f" ({evaluation['contact_episode_recall'].n})"
        texts.append(text)
    return [*texts, f"{width:.3f}", f"{length:.3f}"]


def main(arguments: list[str] | None = None) -> None:
    """Print a row for each scene; of the program's own arguments, those that are named there."""
    known = [*SCENES, *LOOKS]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(known))
    scenes = parser.parse_args(arguments).scenes
    for scene in scenes:
        if scene not in known:
            parser.error(f"no scene {scene!r}: there are {', '.join(known)}")
    take = Take()
    table = Table("scene", title=f"{take.frames} frames a scene, {take.px_per_mm:g} px/mm")
    for heading, *_ in FIGURES:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("width", justify="right")
    table.add_column("length", justify="right")
    for scene in track(scenes or known, "tracking the scenes"):
        try:
            table.add_row(scene, *cells(*measured(scene, take)))
        except TrackerError as error:
            table.add_row(scene, str(error))
    Console(width=240).print(table)
    bars = ", ".join(f"{heading} {bar:g}" for heading, _, bar, _ in FIGURES[:16] if bar)
    print(f"* misses its bar: {bars}. F1: of (…) true contacts. –: none, or too little.")
    print("width: over the true one; length: part within 2 % of the true one.")


if __name__ == "__main__":
    main()
