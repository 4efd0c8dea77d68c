"""A picture of a film's worst frames: the truth in green, the midline found in orange."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.fold_films import FoldFilm

COLUMNS, ROWS, TILE_PX = 4, 3, 420
TRUE, FOUND, TEXT = (60, 200, 60), (0, 140, 255), (0, 0, 220)


def write_contact_sheet(
    folder: Path,
    film: FoldFilm,
    scores: list[Any],
    lines: list[NDArray[np.float64]],
    figures: dict[str, Any],
) -> None:
    """Write ``<worm>_<look>.png``: unmarked errors first, then folded and open ones not right.

    Parameters
    ----------
    folder : Path
    film : FoldFilm
    scores : list of FrameScore
    lines : list of ndarray, shape (n, 2)
        The midlines found.
    figures : dict
        Of `benchmarks.folds.figures`.
    """
    tiles: list[NDArray[np.uint8]] = []
    left = COLUMNS * ROWS
    chosen: list[int] = []
    for name in ("unmarked_frames", "open_frames_not_right", "folded_frames_not_right"):
        rest = [frame for frame in figures[name] if frame not in chosen]
        share = max(left // 2, 4) if name == "unmarked_frames" else left
        picked = np.linspace(0, len(rest) - 1, min(share, len(rest))).round().astype(int)
        chosen += [rest[k] for k in picked]
        left = COLUMNS * ROWS - len(chosen)
    for frame in sorted(chosen):
        mark = "UNMARKED " if frame in set(figures["unmarked_frames"]) else ""
        one = scores[frame]
        text = f"{frame} {mark}{one.status} c={one.certainty:.3f}"
        errors = f"head {one.head_px:.0f} line {one.midline_px:.0f} off {one.off_worm_px:.0f} px"
        tiles.append(_tile(film, frame, lines[frame], (text, errors)))
    if not tiles:
        return
    blank = np.full_like(tiles[0], 255)
    tiles += [blank] * (-len(tiles) % COLUMNS)
    rows = [np.hstack(tiles[k : k + COLUMNS]) for k in range(0, len(tiles), COLUMNS)]
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / f"{film.worm}_{film.look}.png"), np.vstack(rows))


def _tile(
    film: FoldFilm, frame: int, line: NDArray[np.float64], text: tuple[str, str]
) -> NDArray[np.uint8]:
    picture, true = film.picture(frame), film.midline_px[frame]
    line = line[np.isfinite(line).all(axis=1)] if len(line) else line
    seen = np.vstack([true, line]) if len(line) else true
    low, high = seen.min(axis=0) - film.width_px, seen.max(axis=0) + film.width_px
    side = float((high - low).max())
    scale = TILE_PX / side
    corner = 0.5 * (low + high - side)
    move = np.array([[scale, 0.0, -scale * corner[0]], [0.0, scale, -scale * corner[1]]])
    tile = cv2.warpAffine(picture, move, (TILE_PX, TILE_PX), flags=cv2.INTER_LINEAR)
    tile = cv2.cvtColor(tile, cv2.COLOR_GRAY2BGR)
    for points, colour in ((true, TRUE), (line, FOUND)):
        if len(points):
            at = np.rint(scale * (points - corner)).astype(np.int32)
            cv2.polylines(tile, [at], False, colour, 1, cv2.LINE_AA)
            cv2.circle(tile, (int(at[0][0]), int(at[0][1])), 5, colour, 2, cv2.LINE_AA)
    for row, words in enumerate(text):
        cv2.putText(tile, words, (6, 18 + 18 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.45, TEXT, 1)
    return np.asarray(tile, dtype=np.uint8)
