"""Films of worms that fold on themselves, with exact truth, drawn once and kept as JPEG files."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from benchmarks.drawn_by_distance import EXIT_WIDTH_MM as STEERED_EXIT_WIDTH_MM
from benchmarks.drawn_by_distance import STEERED_LOOKS, steered_pictures
from benchmarks.drawn_lines import (
    EXIT_WIDTH_MM,
    LINE_LOOKS,
    RADIUS_MM,
    light_and_wall,
    picture_of,
    true_line_px,
)
from benchmarks.drawn_lines import is_folded as is_folded_line
from benchmarks.steered_worm import FPS as STEERED_FPS
from benchmarks.steered_worm import steered_worm
from worm_model.simulator import folded_worms
from worm_model.simulator.film import FilmFrame, encode
from worm_model.simulator.folded_worms import LOOKS, FoldedWorm, Look, film_worm, rig_for
from worm_model.simulator.rig import Body, Rig
from worm_model.simulator.rig.skins import read_skins
from worm_model.simulator.rig.strands import Skin, is_folded
from worm_model.simulator.worm import Walker, midlines_mm
from worm_msgs_py.files.whole_files import whole_file

SOURCE = Path(__file__).parents[1] / "bags" / "source"
WORMS_FILE = SOURCE / "folded_worms.npz"
WORMS = ("4001", "4002", "4003", "4004", "4005", "4006")
OPEN = "open"
"""A worm that walks along the wall and never folds, to wear the real skins."""
OPEN_FRAMES, OPEN_FPS = 1000, 25.0
MIDLINE_POINTS = 241
LINE_QUALITY = 95
PER_FRAME = ("stamp_ns", "midline_px", "half_width_px", "centroid_px", "folded", "contact")

FILMS = tuple(
    (worm, look)
    for index, worm in enumerate(WORMS)
    for look in ("one_shade", "darker", "coarse", ("skin_w4", "skin_w5")[index % 2])
)
"""Six worms in four looks."""
LINE_FILMS = tuple((worm, look) for worm in WORMS for look in LINE_LOOKS)
"""The same motions, drawn by other means than the rig's."""
STEERED_FILMS = tuple(
    (f"s{seed}", look)
    for look, seeds in {
        "steered": (
            *(3, 9, 25, 28, 31, 35, 38, 41, 47, 49, 57, 60, 63, 65, 68, 71),
            *(
                73,
                77,
                81,
                86,
                90,
                92,
                96,
                100,
                104,
                108,
                109,
                113,
                117,
                211,
                221,
                234,
                237,
                256,
                291,
            ),
        ),
        "steered_coarse": (
            *(5, 8, 22, 26, 32, 37, 40, 42, 45, 48, 50, 53, 56, 58, 61, 66, 69),
            *(74, 78, 82, 87, 91, 93, 97, 101, 105, 110, 118, 215, 228, 235, 238),
        ),
        "steered_pale": (
            *(7, 12, 24, 33, 36, 39, 43, 46, 52, 54, 59, 67, 75, 79, 84, 88),
            *(94, 98, 102, 106, 111, 115, 119, 222, 232, 236, 239, 257),
        ),
        "steered_one_shade": (
            *(1, 10, 23, 34, 51, 55, 64, 70, 72, 76, 80, 85, 89),
            *(95, 99, 103, 107, 112, 116, 120, 251, 254, 258, 267, 289),
        ),
        "skin_w4": (
            *(180, 192, 194, 200, 212, 216, 223, 240, 242, 244, 246, 260, 264),
            *(270, 274, 276, 280),
        ),
        "skin_w5": (
            *(183, 185, 187, 201, 214, 218, 226, 241, 243, 245, 247, 262, 265),
            *(269, 271, 279, 287),
        ),
    }.items()
    for seed in seeds
)
"""Worms of other motions, drawn in a third way, or by the rig in a real skin; s and the seed: of 1
to 28, and from 57 on, those that fold."""
MORE_FILMS = ((OPEN, "skin_w4"), (OPEN, "skin_w5"), ("4002", "thin_tail"), ("4004", "thin_tail"))


@dataclass(frozen=True, eq=False, slots=True)
class FoldFilm:
    """A film and its truth, an item a frame.

    Attributes
    ----------
    worm, look : str
    px_per_mm, radius_mm, exit_width_mm, width_px : float
        Scale, R, W, and the mean width of the body's middle half.
    jpeg : ndarray of uint8, jpeg_end : ndarray of int
        The pictures one behind the other, and where each ends.
    stamp_ns : ndarray of int
    midline_px : ndarray, shape (frames, MIDLINE_POINTS, 2)
        At even steps of arc length, head first, straight between the points.
    half_width_px : ndarray, shape (frames, MIDLINE_POINTS)
    centroid_px : ndarray, shape (frames, 2)
        Of the area that the body covers.
    folded, contact : ndarray of bool
    """

    worm: str
    look: str
    px_per_mm: float
    radius_mm: float
    exit_width_mm: float
    width_px: float
    jpeg: NDArray[np.uint8]
    jpeg_end: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    midline_px: NDArray[np.float64]
    half_width_px: NDArray[np.float64]
    centroid_px: NDArray[np.float64]
    folded: NDArray[np.bool_]
    contact: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def jpeg_of(self, frame: int) -> NDArray[np.uint8]:
        """Return a picture's file."""
        start = int(self.jpeg_end[frame - 1]) if frame else 0
        return self.jpeg[start : int(self.jpeg_end[frame])]

    def picture(self, frame: int) -> NDArray[np.uint8]:
        """Decode a picture."""
        decoded = cv2.imdecode(self.jpeg_of(frame), cv2.IMREAD_GRAYSCALE)
        return np.asarray(decoded, dtype=np.uint8)


def fold_film(worm: str, look: str, cache: Path) -> FoldFilm:
    """Return a film from the cache, or draw it and keep it there (300 MB, two minutes).

    The first frame is drawn each time: a kept film whose first frame is another is drawn anew.
    """
    kept = cache / f"{worm}_{look}.npz"
    if kept.exists():
        film_kept, first = read_film(kept), _drawn(worm, look, 1)
        if np.array_equal(film_kept.jpeg[: film_kept.jpeg_end[0]], first["jpeg"]):
            return film_kept
    cache.mkdir(parents=True, exist_ok=True)
    with whole_file(kept) as unfinished, unfinished.open("wb") as file:
        np.savez(file, **_drawn(worm, look))
    return read_film(kept)


def read_film(kept: Path) -> FoldFilm:
    """Read a film that `fold_film` keeps."""
    with np.load(kept) as data:
        arrays = {name: data[name] for name in data.files}
    plain = {name: values.item() for name, values in arrays.items() if values.ndim == 0}
    return FoldFilm(**(arrays | plain))


def _motion(worm: str) -> FoldedWorm:
    if worm.startswith("s"):
        return _steered_motion(int(worm[1:]))
    if worm != OPEN:
        return folded_worms.read_folded_worms(WORMS_FILE)[worm]
    walker = Walker(speed_mm_s=4.0, mean_slide_mm=4.0, mean_hop_mm=1.2, seed=5)
    lines = np.stack(list(midlines_mm(walker, 10.0, OPEN_FRAMES / OPEN_FPS, OPEN_FPS)))
    fine = np.linspace(0.0, lines.shape[1] - 1.0, 121)
    whole = np.arange(lines.shape[1])
    smooth = [[np.interp(fine, whole, line[:, k]) for k in (0, 1)] for line in lines]
    return FoldedWorm(np.swapaxes(np.array(smooth), 1, 2), np.full(121, 0.4), OPEN_FPS)


def _steered_motion(seed: int) -> FoldedWorm:
    """Return the motion of a worm that steers by a programme, for the rig to film."""
    worm = steered_worm(seed)
    node = np.arange(worm.midlines_mm.shape[1])
    at = np.linspace(0, node[-1], 121)
    fewer = make_interp_spline(node, worm.midlines_mm, k=1, axis=1)(at)
    return FoldedWorm(fewer, np.interp(at, node, worm.width_mm), STEERED_FPS)


def filmed(
    name: str, look_name: str, frames: int | None = None
) -> Iterator[tuple[FilmFrame, Body]]:
    """Film a worm in a look, and yield its true body with each frame."""
    look, worm = LOOKS[look_name], _motion(name)
    worm = replace(worm, midlines_mm=worm.midlines_mm[:frames])
    skin: Skin | None = read_skins()[look.skin] if look.skin else None
    return film_worm(_rig(name, look), worm, look, skin)


def _rig(name: str, look: Look) -> Rig:
    return rig_for(look, seed=int(name) if name.isdigit() else 0)


def _drawn(name: str, look_name: str, frames: int | None = None) -> dict[str, NDArray[np.generic]]:
    if look_name in LINE_LOOKS:
        return _drawn_of_lines(name, look_name, frames)
    if look_name in STEERED_LOOKS:
        return _drawn_of_steered(name, look_name, frames)
    look = LOOKS[look_name]
    rig = _rig(name, look)
    part = np.linspace(0.0, 1.0, MIDLINE_POINTS)
    rows: dict[str, list[object]] = {key: [] for key in PER_FRAME}
    jpegs: list[bytes] = []
    width_px = 0.0
    for frame, true_body in filmed(name, look_name, frames):
        s = part * true_body.length_px
        jpegs.append(encode(frame.picture, look.jpeg_quality))
        rows["stamp_ns"].append(frame.stamp_ns)
        rows["midline_px"].append(true_body.at(s))
        rows["half_width_px"].append(0.5 * np.interp(s, true_body.s_px, true_body.width_px))
        rows["centroid_px"].append((frame.truth.centroid_u_px, frame.truth.centroid_v_px))
        rows["folded"].append(is_folded(true_body))
        rows["contact"].append(bool(frame.truth.contact))
        width_px = true_body.mean_width_px
    scale = {"px_per_mm": look.px_per_mm, "radius_mm": rig.radius_mm, "width_px": width_px}
    rig_figures = {**scale, "exit_width_mm": rig.exit_width_mm}
    return _as_arrays({"worm": name, "look": look_name, **rig_figures}, jpegs, rows)


def _drawn_of_lines(
    name: str, look_name: str, frames: int | None
) -> dict[str, NDArray[np.generic]]:
    """Draw a film of lines: everything of it is worked out anew."""
    worm, look = _motion(name), LINE_LOOKS[look_name]
    light, wall = light_and_wall(look)
    width_px = float(worm.width_mm[20:-20].mean()) * look.px_per_mm
    rows: dict[str, list[object]] = {key: [] for key in PER_FRAME}
    jpegs: list[bytes] = []
    for frame in range(len(worm.midlines_mm[:frames])):
        line, widths = true_line_px(worm, frame, look)
        jpegs.append(encode(picture_of(line, widths, look, light, wall, seed=frame), LINE_QUALITY))
        thin = np.linspace(0, len(line) - 1, MIDLINE_POINTS).round().astype(int)
        gap_px = RADIUS_MM * look.px_per_mm - float(np.hypot(*(line[0] - look.centre)))
        rows["stamp_ns"].append(round(frame * 1e9 / worm.fps))
        rows["midline_px"].append(line[thin])
        rows["half_width_px"].append(widths[thin] / 2)
        rows["centroid_px"].append(widths @ line / widths.sum())
        rows["folded"].append(is_folded_line(line, width_px))
        rows["contact"].append(gap_px < 0.3 * width_px)
    scale = {"px_per_mm": look.px_per_mm, "radius_mm": RADIUS_MM, "width_px": width_px}
    rig_figures = {**scale, "exit_width_mm": EXIT_WIDTH_MM}
    return _as_arrays({"worm": name, "look": look_name, **rig_figures}, jpegs, rows)


def _drawn_of_steered(
    name: str, look_name: str, frames: int | None
) -> dict[str, NDArray[np.generic]]:
    """Draw a film of a worm that steers by a programme."""
    seed, look = int(name[1:]), STEERED_LOOKS[look_name]
    worm = steered_worm(seed)
    worm = replace(worm, midlines_mm=worm.midlines_mm[:frames])
    width_px = float(worm.width_mm[100:300].mean()) * look.px_per_mm
    rows: dict[str, list[object]] = {key: [] for key in PER_FRAME}
    jpegs: list[bytes] = []
    for frame, (picture, line) in enumerate(steered_pictures(worm, look, seed)):
        jpegs.append(encode(picture, look.jpeg_quality))
        s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))]
        at = np.linspace(0.0, s[-1], MIDLINE_POINTS)
        even = np.stack([np.interp(at, s, line[:, k]) for k in (0, 1)], axis=1)
        widths = np.interp(at, s, worm.width_mm * look.px_per_mm)
        gap_px = RADIUS_MM * look.px_per_mm - float(np.hypot(*(even[0] - look.centre)))
        rows["stamp_ns"].append(round(frame * 1e9 / STEERED_FPS))
        rows["midline_px"].append(even)
        rows["half_width_px"].append(widths / 2)
        rows["centroid_px"].append(widths @ even / widths.sum())
        rows["folded"].append(is_folded_line(even, width_px, every=2))
        rows["contact"].append(gap_px < 0.3 * width_px)
    scale = {"px_per_mm": look.px_per_mm, "radius_mm": RADIUS_MM, "width_px": width_px}
    rig_figures = {**scale, "exit_width_mm": STEERED_EXIT_WIDTH_MM}
    return _as_arrays({"worm": name, "look": look_name, **rig_figures}, jpegs, rows)


def _as_arrays(
    plain: dict[str, str | float], jpegs: list[bytes], rows: dict[str, list[object]]
) -> dict[str, NDArray[np.generic]]:
    return {
        **{key: np.array(value) for key, value in plain.items()},
        "jpeg": np.frombuffer(b"".join(jpegs), dtype=np.uint8),
        "jpeg_end": np.cumsum([len(jpeg) for jpeg in jpegs]),
        **{key: np.array(values) for key, values in rows.items()},
    }
