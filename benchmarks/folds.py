"""How the tracker comes through folds: `python -m benchmarks.folds [--worm W] [--look LOOK] …`.

Six worms that fold much, in four looks, and a few films more, all with exact truth; in three looks
that are drawn by other means; and worms of other motions, drawn in a third way.

A frame is *right* where it has a pose, its head is within one width, no part of the midline is more
than a width off the true one (Fréchet distance: in order along both), and the head's certainty is
at least 0.9. It is an *unmarked error* where a head is given with that certainty and is not right.
In a folded frame the *head is right* where it is given with that certainty and lies within a width.
An *end under the body* is one that lies there by a width of its length or more
(`hidden_ends.py`): of one shade, nothing shows where.
"""

import argparse
import json
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.fold_conditions import CONDITIONS
from benchmarks.fold_films import (
    FILMS,
    LINE_FILMS,
    MORE_FILMS,
    STEERED_FILMS,
    FoldFilm,
    fold_film,
)
from benchmarks.fold_overlays import write_contact_sheet
from benchmarks.hidden_ends import hides_end
from benchmarks.midline_distance import at_even_steps, frechet_px, largest, largest_of_parts_px
from worm_analysis.events.contact_state import tells_contact
from worm_msgs_py import TrackedFrame
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.paper import CONTACT_DISTANCE_WIDTHS as CONTACT_WIDTHS
from worm_msgs_py.units import MM_PER_M
from worm_tracker.parameters import MOST_HOLD_BACK_FRAMES, TrackerParameters
from worm_tracker.tracker import Tracker

MOST_LENGTH_ERROR = 0.02
OFF_WORM_PX = 2.0
"""A midline point is in clear water where the true outline is farther away than this."""
BEYOND_WALL_MM = 0.1
CERTAINTY_EDGES = (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0)

HEADINGS = (  # heading, figure, digits
    ("frames", "frames", 0),
    ("folded", "folded", 0),
    ("open right %", "open_right", 2),
    ("folded right %", "folded_right", 1),
    ("by arc %", "folded_right_by_arc", 1),
    ("head right %", "folded_head_right", 1),
    ("end under body %", "end_under_body", 1),
    ("right of others %", "folded_right_of_others", 1),
    ("unmarked % of folded", "folded_unmarked", 2),
    ("of all", "unmarked", 2),
    ("head px open", "head_px_open", 2),
    ("centroid open", "centroid_px_open", 2),
    ("folded", "centroid_px_folded", 2),
    ("swapped", "swapped_certain", 0),
    ("off worm", "off_worm", 0),
    ("in wall", "in_wall", 0),
    ("contact told %", "contact_told", 1),
    ("right %", "contact_right", 1),
    ("length open %", "length_right_open", 1),
    ("folded", "length_right_folded", 1),
    ("psi_b ° open", "psi_b_deg_open", 2),
    ("folded", "psi_b_deg_folded", 2),
    ("99 %", "psi_b_deg_folded_99", 1),
    ("ms open", "ms_open", 1),
    ("99 %", "ms_open_99", 1),
    ("ms folded", "ms_folded", 1),
    ("99 %", "ms_folded_99", 1),
)


@dataclass(frozen=True, slots=True)
class FrameScore:
    """One frame against its truth; NaN where nothing is given.

    Attributes
    ----------
    status : str
    certainty : float
    head_px, centroid_px : float
        Errors.
    midline_px, by_arc_px : float
        Largest distance of the midlines: in order, and at the same part of their lengths. Of a
        midline with a loop in doubt the first is that of what is told; for one with a hidden end
        it is how far it strays from the true one.
    off_worm_px : float
        How far the midline is out in the water.
    swapped, in_wall : bool
    has_pose : bool
    contact : bool or None
        Head within 0.3 widths of the wall, by the widths and places given; None where the head's
        place is not known well enough to tell.
    length : float
        What is told over the true one.
    psi_b_deg : float
        By how much the direction of the body vector, from the centroid to the head, is off.
    """

    status: str
    certainty: float
    has_pose: bool
    head_px: float = np.nan
    centroid_px: float = np.nan
    midline_px: float = np.nan
    by_arc_px: float = np.nan
    off_worm_px: float = np.nan
    swapped: bool = False
    in_wall: bool = False
    contact: bool | None = None
    length: float = np.nan
    psi_b_deg: float = np.nan


def score(tracked: TrackedFrame, film: FoldFilm, frame: int) -> FrameScore:
    """Compare a frame with its truth."""
    state, line = tracked.state, tracked.midline
    true, half = film.midline_px[frame], film.half_width_px[frame]
    centroid = np.array([state.centroid.u_px, state.centroid.v_px])
    centroid_px = float(np.hypot(*(centroid - film.centroid_px[frame])))
    head = np.array([state.head.u_px, state.head.v_px])
    status, certainty = state.status.label, state.head_certainty
    if not np.isfinite(head).all():
        return FrameScore(status, certainty, state.status.has_pose, centroid_px=centroid_px)
    given = np.c_[line.u_px, line.v_px]
    told = np.isfinite(given).all(axis=1)
    found = given[told]
    head_px = float(np.hypot(*(head - true[0])))
    strays = np.hypot(*np.moveaxis(found[:, np.newaxis] - true, 2, 0))
    whole = state.status.has_pose and told.all()
    in_parts = state.status.has_pose and not whole
    even, even_true = (at_even_steps(found), at_even_steps(true)) if whole else (found, true)
    if whole:
        midline_px = frechet_px(even, even_true)
    else:
        midline_px = largest_of_parts_px(given, true) if in_parts else largest(strays.min(axis=1))
    x_mm, y_mm = 1e3 * state.head.x_m, 1e3 * state.head.y_m
    at_exit = x_mm > 0 and abs(y_mm) < 0.5 * film.exit_width_mm
    r_mm = float(np.hypot(x_mm, y_mm))
    gap_m, threshold_m = (film.radius_mm - r_mm) / MM_PER_M, CONTACT_WIDTHS * state.width_m
    tells = np.isfinite(gap_m) and tells_contact(state.head_sd_m, threshold_m)
    return FrameScore(
        status=status,
        certainty=certainty,
        has_pose=state.status.has_pose,
        head_px=head_px,
        centroid_px=centroid_px,
        midline_px=midline_px,
        by_arc_px=float(np.hypot(*(even - even_true).T).max()) if whole else np.nan,
        off_worm_px=largest((strays - half).min(axis=1)),
        swapped=bool(np.hypot(*(head - true[-1])) < head_px),
        in_wall=bool(r_mm > film.radius_mm + BEYOND_WALL_MM and not at_exit),
        contact=gap_m < threshold_m if tells else None,
        length=state.length_px / float(np.hypot(*np.diff(true, axis=0).T).sum()),
        psi_b_deg=_degrees_between(head - centroid, true[0] - film.centroid_px[frame]),
    )


def _degrees_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return abs(float(np.degrees(np.angle(complex(*a) / complex(*b)))))


def track(film: FoldFilm, frames: int) -> tuple[list[FrameScore], list[float], list[Any]]:
    """Track the film's first frames; return scores, processor ms of each push, midlines given."""
    tracker = Tracker(TrackerParameters(hold_back_frames=MOST_HOLD_BACK_FRAMES))
    given: list[TrackedFrame] = []
    ms: list[float] = []
    for frame in range(frames):
        picture = film.picture(frame)
        start = time.process_time()
        given += tracker.push(picture, int(film.stamp_ns[frame]))
        ms.append(1e3 * (time.process_time() - start))
    given += tracker.finish()
    scores = [score(tracked, film, frame) for frame, tracked in enumerate(given)]
    return scores, ms, [np.c_[each.midline.u_px, each.midline.v_px] for each in given]


def figures(film: FoldFilm, scores: list[FrameScore], ms: list[float]) -> dict[str, Any]:
    """Return all that is told of a film."""
    folded = film.folded[: len(scores)]
    table = {
        name: np.array([getattr(each, name) for each in scores], dtype=np.float64)
        for name in (
            "certainty",
            "head_px",
            "centroid_px",
            "midline_px",
            "by_arc_px",
            "length",
            "psi_b_deg",
        )
    } | {
        name: np.array([getattr(each, name) for each in scores], dtype=bool)
        for name in ("has_pose", "swapped", "in_wall")
    }
    pose, certain = table["has_pose"], table["certainty"] >= SURE_HEAD_CERTAINTY
    given = np.isfinite(table["head_px"])
    near = table["head_px"] <= film.width_px
    agrees = near & ~(table["midline_px"] > film.width_px)
    certain_pose = pose & certain
    right = certain_pose & agrees
    unmarked = given & certain & ~agrees
    off = np.array([each.off_worm_px for each in scores])
    said = [each.contact for each in scores]
    told = np.array([each is not None for each in said]) & right
    agreed = np.array([bool(each) for each in said]) == film.contact[: len(scores)]
    measured_length = pose & np.isfinite(table["length"])
    near_length = np.abs(table["length"] - 1.0) < MOST_LENGTH_ERROR
    spent = np.array(ms)
    truth = film.midline_px, film.half_width_px
    hidden = np.array([hides_end(*each, film.width_px) for each in zip(*truth, strict=True)])
    hidden = hidden[: len(scores)]
    return {
        "worm": film.worm,
        "look": film.look,
        "frames": len(scores),
        "folded": int(folded.sum()),
        "open_right": _percent(right[~folded]),
        "folded_right": _percent(right[folded]),
        "folded_right_by_arc": _percent((right & (table["by_arc_px"] <= film.width_px))[folded]),
        "folded_head_right": _percent((given & certain & near)[folded]),
        "end_under_body": _percent(hidden[folded]),
        "folded_right_of_others": _percent(right[folded & ~hidden]),
        "folded_unmarked": _percent(unmarked[folded]),
        "unmarked": _percent(unmarked),
        "head_px_open": _quantile(table["head_px"][right & ~folded]),
        "centroid_px_open": _quantile(table["centroid_px"][~folded]),
        "centroid_px_folded": _quantile(table["centroid_px"][folded]),
        "swapped_certain": int((given & certain & table["swapped"]).sum()),
        "off_worm": int((pose & (off > OFF_WORM_PX)).sum()),
        "in_wall": int(table["in_wall"].sum()),
        "contact_told": _percent(told[right]),
        "contact_right": _percent(agreed[told]),
        "length_right_open": _percent(near_length[measured_length & ~folded]),
        "length_right_folded": _percent(near_length[measured_length & folded]),
        "psi_b_deg_open": _quantile(table["psi_b_deg"][certain_pose & ~folded]),
        "psi_b_deg_folded": _quantile(table["psi_b_deg"][certain_pose & folded]),
        "psi_b_deg_folded_99": _quantile(table["psi_b_deg"][certain_pose & folded], 0.99),
        **_times("open", spent[~folded]),
        **_times("folded", spent[folded]),
        "statuses": dict(Counter(each.status for each in scores)),
        "reliability": reliability(table["certainty"][given], near[given]),
        "unmarked_frames": np.flatnonzero(unmarked).tolist(),
        "open_frames_not_right": np.flatnonzero(~right & ~folded).tolist(),
        "folded_frames_not_right": np.flatnonzero(~right & folded).tolist(),
    }


def _percent(hits: NDArray[np.bool_]) -> float | None:
    return 100.0 * float(hits.mean()) if len(hits) else None


def _quantile(values: NDArray[np.float64], part: float = 0.5) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.quantile(known, part)) if len(known) else None


def _times(which: str, ms: NDArray[np.float64]) -> dict[str, float | None]:
    quantiles = np.quantile(ms, [0.5, 0.99]).tolist() if len(ms) else [None, None]
    return {f"ms_{which}": quantiles[0], f"ms_{which}_99": quantiles[1]}


def reliability(certainty: NDArray[np.float64], near: NDArray[np.bool_]) -> list[list[float]]:
    """Return for each bin of certainty: frames, their summed certainty, heads within a width."""
    which = np.clip(np.digitize(certainty, CERTAINTY_EDGES) - 1, 0, len(CERTAINTY_EDGES) - 2)
    return [
        [int((which == k).sum()), float(certainty[which == k].sum()), int(near[which == k].sum())]
        for k in range(len(CERTAINTY_EDGES) - 1)
    ]


def measured(job: tuple[str, str, str, Path, int, Path | None]) -> dict[str, Any]:
    """Track one film and return its figures; write overlays where asked."""
    worm, look, condition, cache, frames, overlays = job
    film = fold_film(worm, look, cache)
    film = CONDITIONS[condition](film) if condition else film
    count = min(frames, len(film)) if frames else len(film)
    scores, ms, lines = track(film, count)
    result = figures(film, scores, ms)
    if overlays is not None:
        write_contact_sheet(overlays, film, scores, lines, result)
    return result


def show(results: list[dict[str, Any]], old: dict[str, dict[str, Any]]) -> None:
    """Print the table, the statuses and the reliability; older figures below each film's own."""
    table = Table("film")
    for heading, _, _ in HEADINGS:
        table.add_column(heading, justify="right")
    for each in results:
        name = f"{each['worm']} {each['look']}"
        table.add_row(name, *_cells(each))
        if name in old:
            table.add_row("  before", *_cells(old[name]), style="dim")
    console = Console(width=300)
    console.print(table)
    for each in results:
        console.print(f"{each['worm']} {each['look']}: {each['statuses']}")
    bins = Table("certainty", "frames", "mean told", "head within a width", title="reliability")
    sums = np.sum([each["reliability"] for each in results], axis=0)
    for k, (frames, told, near) in enumerate(sums.tolist()):
        if frames:
            edge = f"{CERTAINTY_EDGES[k]:g} … {CERTAINTY_EDGES[k + 1]:g}"
            bins.add_row(edge, f"{frames:.0f}", f"{told / frames:.4f}", f"{near / frames:.4f}")
    console.print(bins)


def _cells(figures_of_film: dict[str, Any]) -> list[str]:
    values = [(figures_of_film.get(name), digits) for _, name, digits in HEADINGS]
    return ["–" if value is None else f"{value:.{digits}f}" for value, digits in values]


def main() -> None:
    """Measure the films that are asked for, by default all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worm", help="4001 … 4006, open, or s and a seed")
    parser.add_argument(
        "--look", default="", help="one_shade, darker, coarse, skin, thin_tail, lines, steered"
    )
    parser.add_argument("--condition", default="", choices=CONDITIONS, help="in which it is shown")
    parser.add_argument("--frames", type=int, default=0, help="only the first so many")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1)
    parser.add_argument("--cache", type=Path, default=Path(gettempdir()) / "worm_fold_films")
    parser.add_argument("--overlays", type=Path, help="folder for a picture of the worst frames")
    parser.add_argument("--json", type=Path, help="write the figures")
    parser.add_argument("--compare", type=Path, help="figures of an earlier run")
    asked = parser.parse_args()
    films = [
        film
        for film in (*FILMS, *MORE_FILMS, *LINE_FILMS, *STEERED_FILMS)
        if asked.worm in (None, film[0]) and film[1].startswith(asked.look)
    ]
    if not films:
        parser.error("no such film")
    rest = (asked.condition, asked.cache, asked.frames, asked.overlays)
    jobs = [(*film, *rest) for film in films]
    with ProcessPoolExecutor(asked.jobs, mp_context=get_context("spawn")) as pool:
        results: list[dict[str, Any]] = []
        for result in pool.map(measured, jobs):
            results.append(result)
            if asked.json:  # film by film: all of them take an hour
                asked.json.write_text(json.dumps(results, indent=1))
    old = json.loads(asked.compare.read_text()) if asked.compare else []
    show(results, {f"{each['worm']} {each['look']}": each for each in old})


if __name__ == "__main__":
    main()
