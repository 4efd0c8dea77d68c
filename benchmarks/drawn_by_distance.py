"""Pictures of steered worms, drawn pixel by pixel from the distance to the midline.

A third way to draw, beside the rig's and OpenCV's lines: a body is a cylinder of dye, deepest on
its axis, with a tone that changes along it. Where the body comes back over itself the depths add up
(or no more than one counts, in one shade); within a bend it is counted once.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.steered_path import RADIUS_MM, Floats
from benchmarks.steered_worm import SteeredWorm

EXIT_WIDTH_MM = 2.0
SPECKS = 6
PIECE = 20
Floats32 = NDArray[np.float32]
Corners = tuple[NDArray[np.int64], NDArray[np.int64]]


@dataclass(frozen=True, slots=True)
class DistanceLook:
    """How a steered worm is filmed.

    Attributes
    ----------
    px_per_mm : float
    depth : float
        Optical depth of one layer of worm on its axis.
    noise : float
        Standard deviation at a grey level of 200.
    jpeg_quality : int
    is_one_shade : bool
        Whether two layers are no darker than one.
    """

    px_per_mm: float = 40.0
    depth: float = 1.0
    noise: float = 3.0
    jpeg_quality: int = 85
    is_one_shade: bool = False

    @property
    def size(self) -> int:
        """Side of the pictures, pixels."""
        return int(24 * self.px_per_mm) // 2 * 2

    @property
    def centre(self) -> Floats:
        """Of the chamber (u, v)."""
        return np.array([11.6, 12.1]) * self.px_per_mm


STEERED_LOOKS = {
    "steered": DistanceLook(),
    "steered_coarse": DistanceLook(px_per_mm=28.0, depth=0.9),
    "steered_one_shade": DistanceLook(36.0, 1.2, 4.0, 90, is_one_shade=True),
    "steered_pale": DistanceLook(32.0, 0.7, 5.0, 90),
}


def steered_pictures(
    worm: SteeredWorm, look: DistanceLook, seed: int
) -> Iterator[tuple[NDArray[np.uint8], Floats]]:
    """Yield the pictures, and the midline (n, 2) in each, u and v.

    Parameters
    ----------
    worm : SteeredWorm
    look : DistanceLook
    seed : int
        Of specks and noise.
    """
    rng = np.random.default_rng(1000 + seed)
    ground = _ground(look, rng)
    fixed = rng.normal(0, 1, ground.shape)
    width_px = worm.width_mm * look.px_per_mm
    for frame, midline_mm in enumerate(worm.midlines_mm):
        line = look.centre + midline_mm * [look.px_per_mm, -look.px_per_mm]
        seen = ground * np.exp(-_depth(line, width_px, worm.tone, look))
        seen = cv2.GaussianBlur(seen, (0, 0), max(0.7, look.px_per_mm * 0.022))
        noise = np.random.default_rng((seed, frame)).normal(0, 1, seen.shape)
        seen = seen + 0.6 * fixed + look.noise * noise * np.sqrt(np.clip(seen, 1, 255) / 200)
        yield np.clip(np.rint(seen), 0, 255).astype(np.uint8), line


def _ground(look: DistanceLook, rng: np.random.Generator) -> Floats:
    """Return the chamber without worm: an uneven lamp, a dark wall with a soft rim, and specks."""
    size, scale, centre = look.size, look.px_per_mm, look.centre
    v, u = np.mgrid[:size, :size].astype(float)
    beyond = np.hypot(u - centre[0], v - centre[1]) - RADIUS_MM * scale
    half = EXIT_WIDTH_MM / 2 * scale
    passage = np.clip(half - abs(v - centre[1]) + 0.5, 0, 1) * (u > centre[0])
    wall = np.minimum(np.clip(beyond + 0.5, 0, 1), 1 - passage)
    light = 200 - 20 * ((u / size - 0.4) ** 2 + (v / size - 0.6) ** 2) * 2
    light += 3 * np.sin(u / 90) * np.cos(v / 70)
    light *= 1 - 0.84 * cv2.GaussianBlur(wall, (0, 0), scale * 0.03)
    light *= 1 - 0.08 * cv2.GaussianBlur(wall, (0, 0), scale * 0.3)
    for _ in range(SPECKS):
        at = centre + rng.uniform(-8, 8, 2) * scale
        light *= 1 - 0.4 * np.exp(-((np.hypot(u - at[0], v - at[1]) / (scale * 0.08)) ** 2))
    return np.asarray(light)


def _depth(line: Floats, width_px: Floats, tone: Floats, look: DistanceLook) -> Floats32:
    """Return the optical depth in each pixel."""
    shape = (look.size, look.size)
    past, here = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    last: Corners | None = None
    for (low, high), piece in _pieces(line, width_px, tone, shape):
        if look.is_one_shade:
            part = here[low[1] : high[1], low[0] : high[0]]
            np.maximum(part, piece, out=part)
            continue
        first = low if last is None else np.minimum(low, last[0])
        end = high if last is None else np.maximum(high, last[1])
        drawn = np.zeros((end[1] - first[1], end[0] - first[0]), np.float32)
        inside = np.s_[
            low[1] - first[1] : high[1] - first[1], low[0] - first[0] : high[0] - first[0]
        ]
        drawn[inside] = piece
        window = np.s_[first[1] : end[1], first[0] : end[0]]
        before = here[window]  # of the pieces just before this one: those cover a pixel once
        past[window] += np.where(drawn <= 0, before, 0)
        here[window] = np.where(drawn > 0, np.maximum(before, drawn), 0)
        last = low, high
    return np.asarray((past + here) * look.depth, np.float32)


def _pieces(
    line: Floats, width_px: Floats, tone: Floats, shape: tuple[int, int]
) -> Iterator[tuple[Corners, Floats32]]:
    """Yield each piece of the body: the corners of its box, and how deep it is there."""
    points, widths, tones = (a.astype(np.float32) for a in (line, width_px, tone))
    for first in range(0, len(points) - 1, PIECE):
        end = min(first + PIECE, len(points) - 1)
        some, reach = points[first : end + 1], widths[first : end + 1].max() / 2 + 2
        low = np.maximum(np.floor(some.min(0) - reach).astype(int), 0)
        high = np.minimum(np.ceil(some.max(0) + reach).astype(int) + 1, shape[::-1])
        if not (high > low).all():
            continue
        u = np.arange(low[0], high[0], dtype=np.float32)[None]
        v = np.arange(low[1], high[1], dtype=np.float32)[:, None]
        deepest = np.zeros((high[1] - low[1], high[0] - low[0]), np.float32)
        for k in range(first, end):
            begin, way = points[k], points[k + 1] - points[k]
            part = ((u - begin[0]) * way[0] + (v - begin[1]) * way[1]) / ((way**2).sum() + 1e-9)
            part = np.clip(part, 0, 1)
            away = np.hypot(u - begin[0] - part * way[0], v - begin[1] - part * way[1])
            half = (widths[k] + (widths[k + 1] - widths[k]) * part) / 2
            round_ = np.sqrt(np.clip(1 - (away / np.maximum(half, 0.5)) ** 2, 0, 1))
            deep = np.clip(half - away + 0.5, 0, 1) * (0.35 + 0.65 * round_)
            deep *= tones[k] + (tones[k + 1] - tones[k]) * part
            np.maximum(deepest, deep, out=deepest)
        yield (low, high), deepest
