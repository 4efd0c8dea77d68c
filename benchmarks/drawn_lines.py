"""Pictures of worms that fold, drawn by other means than the rig's.

A benchmark that shares its assumptions with the code proves nothing. Here a body is fourteen
polylines of OpenCV, one behind the other, each as thick as the worm is there. What two of them that
are not neighbours cover is darker, as if the light passed both (or no darker); neighbours cover
each other once, however tight the bend: its strands lie beside each other. Wall, lens, lamp and
noise are plain formulas.
"""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.folded_worms import FoldedWorm

Floats = NDArray[np.float64]
PIECES, POINTS, SUB_BITS, FINER = 14, 700, 4, 4
RADIUS_MM, EXIT_WIDTH_MM = 10.0, 2.0
WALL_LIGHT = 0.15


@dataclass(frozen=True, slots=True)
class LineLook:
    """How a worm of lines is filmed.

    Attributes
    ----------
    px_per_mm : float
    light_passed : float
        Part of the light that passes one layer of worm.
    is_one_shade : bool
        Whether two layers are no darker than one.
    noise : float
        Standard deviation, grey levels.
    """

    px_per_mm: float = 36.0
    light_passed: float = 0.45
    is_one_shade: bool = False
    noise: float = 4.0

    @property
    def size(self) -> int:
        """Side of the pictures, pixels."""
        return int(25 * self.px_per_mm) // 2 * 2

    @property
    def centre(self) -> Floats:
        """Of the chamber (u, v)."""
        return np.array([11.9, 12.4]) * self.px_per_mm


LINE_LOOKS = {
    "lines": LineLook(),
    "lines_coarse": LineLook(px_per_mm=25.0, light_passed=0.5),
    "lines_one_shade": LineLook(is_one_shade=True),
}


def true_line_px(worm: FoldedWorm, frame: int, look: LineLook) -> tuple[Floats, Floats]:
    """Return the midline (POINTS, 2) at even steps, u and v, and the widths along it, pixels."""
    line = look.centre + worm.midlines_mm[frame] * [look.px_per_mm, -look.px_per_mm]
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))]
    at = np.linspace(0.0, s[-1], POINTS)
    widths = np.interp(at, s, worm.width_mm * look.px_per_mm)
    return np.stack([np.interp(at, s, line[:, k]) for k in (0, 1)], axis=1), widths


def light_and_wall(look: LineLook) -> tuple[Floats, Floats]:
    """Return the lamp's light, grey levels, and where the wall is, 0 to 1, both (size, size)."""
    v, u = np.mgrid[: look.size, : look.size].astype(np.float64)
    light = 205 - 25 * ((u / look.size - 0.5) * 2) ** 2 - 18 * v / look.size
    away = np.hypot(u - look.centre[0], v - look.centre[1])
    wall = np.clip(away - RADIUS_MM * look.px_per_mm + 0.5, 0, 1)
    half = EXIT_WIDTH_MM / 2 * look.px_per_mm
    passage = np.clip(half - abs(v - look.centre[1]) + 0.5, 0, 1) * (u > look.centre[0])
    return light, np.minimum(wall, 1 - passage)


def picture_of(
    line: Floats, widths: Floats, look: LineLook, light: Floats, wall: Floats, seed: int
) -> NDArray[np.uint8]:
    """Draw one frame."""
    cuts = np.linspace(0, POINTS - 1, PIECES + 1).astype(int)
    layers, before = np.zeros_like(light), np.zeros_like(light)
    for first, last in pairwise(cuts.tolist()):
        piece = coverage(line[first : last + 1], widths[first : last + 1], light.shape)
        layers += piece - np.minimum(piece, before)
        before = piece
    layers = np.minimum(layers, 1) if look.is_one_shade else layers
    seen = light * (1 - (1 - WALL_LIGHT) * wall) * look.light_passed ** (layers * (1 - wall))
    seen = cv2.GaussianBlur(seen, (0, 0), max(0.8, 1.1 * look.px_per_mm / 36))
    seen += np.random.default_rng(seed).normal(0, look.noise, seen.shape)
    return np.clip(seen, 0, 255).astype(np.uint8)


def is_folded(line: Floats, width: float, every: int = 7) -> bool:
    """Tell whether two parts more than three widths apart along a line are within a width.

    By every so many-th of its points.
    """
    thin = line[::every]
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(thin, axis=0).T))]
    apart = np.hypot(*np.moveaxis(thin[:, np.newaxis] - thin, 2, 0))
    return bool(((apart < width) & (abs(s[:, np.newaxis] - s) > 3 * width)).any())


def coverage(line: Floats, widths: Floats, shape: tuple[int, ...]) -> Floats:
    """Return how much of each pixel a polyline of some widths covers, 0 to 1.

    OpenCV's smooth lines come out two pixels and more too broad. Its plain ones are an odd number
    of pixels broad, 2 [t / 2] + 1 for a thickness t: drawn FINER times as large, that is as broad
    as it is said to be, to an eighth of a pixel to either side.
    """
    reach = int(widths.max()) // 2 + 3
    low = np.maximum(np.floor(line.min(axis=0)).astype(int) - reach, 0)
    high = np.minimum(np.ceil(line.max(axis=0)).astype(int) + reach, shape[::-1])
    across, down = (high - low).tolist()
    drawn = np.zeros((FINER * down, FINER * across), np.uint8)
    at = FINER * (line - low + 0.5) - 0.5
    fixed = np.rint(at * (1 << SUB_BITS)).astype(int).tolist()
    thick = np.maximum(2 * np.rint((FINER * widths - 1) / 2), 1).astype(int).tolist()
    for one, other, width in zip(fixed[:-1], fixed[1:], thick, strict=False):
        cv2.line(drawn, one, other, 255, width, cv2.LINE_8, SUB_BITS)
    covered = np.zeros(shape)
    part = cv2.resize(drawn, (across, down), interpolation=cv2.INTER_AREA)
    covered[low[1] : high[1], low[0] : high[0]] = part / 255.0
    return covered
