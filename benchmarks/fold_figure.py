"""The figure of docs/folds.md: `python -m benchmarks.fold_figure FILM FIGURES…`.

FILM is a film that `benchmarks.folds` keeps as `.npz`; FIGURES are what it wrote with `--json`.
Drawn are pictures of one fold with the midlines told, how many of the folded frames of each film
are right, and how often a head told with some certainty is not within a width of the truth.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray
from scipy.stats import binomtest

from benchmarks.fold_films import WORMS, FoldFilm, read_film
from benchmarks.folds import track
from worm_analysis.report.theme import COLOURS, INK, PAPER_STYLE, new_figure, say_n, style

PAGE = Path(__file__).parents[1] / "docs" / "folds.png"
SIDE_MM = 11.0
ALONG_BODY = LinearSegmentedColormap.from_list("along body", [COLOURS["head"], COLOURS["tail"]])
LOOKS = {
    "darker": "darker",
    "coarse": "25 px/mm",
    "skin_w": "skins",
    "lines": "lines, darker",
    "lines_coarse": "lines, 25 px/mm",
    "one_shade": "one shade",
    "lines_one_shade": "lines, one shade",
    "steered": "other motions",
    "steered_skin": "the same, in skins",
    "steered_one_shade": "the same, one shade",
}
BAR = 95.0


def main(
    film: Annotated[Path, typer.Argument(help="A film of folds.")],
    figures: Annotated[list[Path], typer.Argument(help="Figures of films, JSON.")],
    first: Annotated[int, typer.Option(help="The first frame shown.")] = 0,
    every: Annotated[int, typer.Option(help="Frames from one shown to the next.")] = 12,
) -> None:
    """Draw it."""
    results = [each for path in figures for each in _figures_of(path)]
    shown = [first + every * k for k in range(5)]
    kept = read_film(film)
    _, _, lines = track(kept, min(shown[-1] + 200, len(kept)))
    with style():
        page = new_figure(7.0, 4.0)
        above, below = page.subfigures(2, 1, height_ratios=[1.0, 1.5])
        for letter, frame, axes in zip("a    ", shown, above.subplots(1, len(shown)), strict=True):
            _picture(axes, kept, frame, lines[frame], shown[0])
            axes.set_title(f"({letter})" if letter != " " else "", loc="left")
        left, right = below.subplots(1, 2, width_ratios=[1.5, 1.0])
        _films(left, results)
        left.set_title("(b)", loc="left")
        _certainty(right, results)
        right.set_title("(c)", loc="left")
        page.savefig(PAGE, dpi=200, metadata={"Software": None})


def _figures_of(path: Path) -> Sequence[Mapping[str, Any]]:
    figures: Sequence[Mapping[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    return figures


def _picture(axes: Any, film: FoldFilm, frame: int, line: NDArray[np.float64], first: int) -> None:
    """Draw a frame about its worm, the midline told from head to tail, and a scale."""
    side = SIDE_MM * film.px_per_mm
    middle = film.midline_px[frame].mean(axis=0)
    axes.imshow(film.picture(frame), cmap="gray", vmin=0, vmax=255)
    pieces = np.stack([line[:-1], line[1:]], axis=1)
    coloured = LineCollection(list(pieces), cmap=ALONG_BODY, linewidth=1.2)
    coloured.set_array(np.linspace(0.0, 1.0, len(pieces)))
    axes.add_collection(coloured)
    axes.plot(*line[0], "o", color=COLOURS["head"], ms=3.5, mec="white", mew=0.5)
    height, width = film.picture(frame).shape
    left, top = np.clip(middle - side / 2, 0, np.array([width, height]) - side)
    axes.set(xlim=(left, left + side), ylim=(top + side, top), xticks=[], yticks=[])
    seconds = 1e-9 * float(film.stamp_ns[frame] - film.stamp_ns[first])
    say_n(axes, f"{seconds:.2f} s", x=0.03)
    if frame == first:
        start, low = left + 0.05 * side, top + 0.95 * side
        axes.plot([start, start + 2 * film.px_per_mm], [low] * 2, color=INK, linewidth=1.5)
        axes.text(start, low - 0.03 * side, "2 mm", fontsize=7)


def _look(result: Mapping[str, Any]) -> str:
    name = str(result["look"])
    if name.startswith("skin") and result["worm"] not in WORMS:
        name = f"steered_{name}"
    return next(
        label
        for key, label in sorted(LOOKS.items(), key=lambda item: -len(item[0]))
        if name.startswith(key)
    )


def _films(axes: Any, results: Sequence[Mapping[str, Any]]) -> None:
    """Draw the share of folded frames that are right: a dot a film, a line for all of a look."""
    told = [each for each in results if each["folded"] and not each["look"].startswith("thin")]
    labels = list(dict.fromkeys(LOOKS.values()))
    for row, label in enumerate(labels):
        films = [each for each in told if _look(each) == label]
        folded = np.array([each["folded"] for each in films])
        right = np.array([each["folded_right"] for each in films])
        spread = row + np.linspace(-0.22, 0.22, len(films))
        axes.plot(right, spread, "o", ms=3, color=COLOURS["head"], alpha=0.7, mew=0)
        axes.plot([right @ folded / folded.sum()] * 2, [row - 0.38, row + 0.38], color=INK, lw=1.6)
        say = f"{len(films)} films, n = {folded.sum():,}"
        axes.text(2, row, say, fontsize=6.5, va="center", color=INK)
    axes.axvline(BAR, **PAPER_STYLE)
    axes.set(xlim=(0, 101), ylim=(len(labels) - 0.4, -0.6), xlabel="folded frames right (%)")
    axes.set_yticks(range(len(labels)), labels)
    axes.tick_params(axis="y", length=0)


def _certainty(axes: Any, results: Sequence[Mapping[str, Any]]) -> None:
    """Draw how often a head is off by more than a width, against how often by what it was told."""
    sums = np.sum([each["reliability"] for each in results], axis=0)
    for frames, told, near in sums.tolist():
        if frames < 20:
            continue
        off = round(frames - near)
        doubt = max(1 - told / frames, 1e-7)
        low, high = binomtest(off, round(frames)).proportion_ci(0.95, method="exact")
        if off:
            around = [[off / frames - low], [high - off / frames]]
            axes.errorbar(doubt, off / frames, around, fmt="o", ms=3.5, color=COLOURS["head"])
        else:
            axes.errorbar(doubt, high, [[0.6 * high], [0]], uplims=True, color=COLOURS["head"])
    ends = np.array([1e-6, 0.6])
    axes.plot(ends, ends, **PAPER_STYLE)
    axes.set(xscale="log", yscale="log", xlim=(2e-6, 0.7), ylim=(2e-6, 0.7))
    axes.set(xlabel="1 − certainty told", ylabel="heads off by more than a width")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    say_n(axes, f"n = {sums[:, 0].sum():,.0f} heads", x=0.03)


if __name__ == "__main__":
    typer.run(main)
