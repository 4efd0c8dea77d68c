"""Films with truth for the tracker's tests: a worm on a known path in a drawn, back-lit chamber.

Everything is drawn at four times the resolution and averaged down, blurred, and given noise, so that
edges have sub-pixel positions that are known.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

SCALE = 4
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Film:
    """A chamber and a worm that crawls head-first along a path."""

    size: tuple[int, int] = (1024, 1024)
    centre: tuple[float, float] = (498.3, 517.6)
    radius: float = 400.0
    exit_deg: float = 27.0
    exit_width: float = 80.0
    chamber: bool = True
    light: float = 200.0
    wall: float = 30.0
    worm_light: float = 0.25
    length: float = 800.0
    width: float = 16.0
    blur: float = 1.0
    noise: float = 3.0
    seed: int = 0

    def ground(self) -> NDArray[np.float32]:
        """Return the sharp picture without a worm, light and walls."""
        h, w = self.size
        v, u = np.mgrid[0:h, 0:w].astype(np.float32)
        light = self.light * (1 + 0.15 * (u / w - 0.5) - 0.1 * (v / h - 0.5) ** 2)
        open_ = self.open_fraction()
        return (light * open_ + self.wall * (1 - open_)).astype(np.float32)

    def open_fraction(self) -> NDArray[np.float32]:
        """Return the fraction of each pixel that is water."""
        h, w = self.size
        if not self.chamber:
            return np.ones((h, w), np.float32)
        v, u = np.mgrid[0:h, 0:w].astype(np.float32)
        u, v = u - self.centre[0], self.centre[1] - v
        open_ = np.clip(self.radius - np.hypot(u, v) + 0.5, 0, 1)
        if self.exit_width > 0:
            c, s = np.cos(np.radians(self.exit_deg)), np.sin(np.radians(self.exit_deg))
            beside = np.clip(self.exit_width / 2 - np.abs(c * v - s * u) + 0.5, 0, 1)
            open_ = np.maximum(open_, beside * (c * u + s * v > 0))
        return open_.astype(np.float32)

    def draw(self, body: Array | None, frame: int, gain: float = 1.0) -> NDArray[np.uint8]:
        """Return the picture of a worm with this midline (n, 2), or of none."""
        scene = self._ground.copy()
        if body is not None:
            scene *= 1 - (1 - self.worm_light) * self.coverage(body)
        picture = cv2.GaussianBlur(scene, (0, 0), self.blur) * np.float32(gain)
        rng = np.random.default_rng((self.seed, frame))
        picture += self.noise * rng.standard_normal(picture.shape, np.float32)
        return np.clip(np.rint(picture), 0, 255).astype(np.uint8)

    def coverage(self, body: Array) -> NDArray[np.float32]:
        """Return the fraction of each pixel that the body covers."""
        h, w = self.size
        low = np.maximum(np.floor(body.min(0) - self.width), 0).astype(int)
        high = np.minimum(np.ceil(body.max(0) + self.width), (w, h)).astype(int)
        span = high - low
        big = np.zeros((span[1] * SCALE, span[0] * SCALE), np.uint8)
        radius = round(
            (self.width / 2 * SCALE - 0.5) * 256
        )  # OpenCV's discs are half a pixel large
        for point in inner(body, self.width / 2):
            cv2.circle(big, _fixed(_big(point - low)), radius, 255, -1, shift=8)
        out = np.zeros((h, w), np.float32)
        out[low[1] : high[1], low[0] : high[0]] = (
            cv2.resize(big, (int(span[0]), int(span[1])), interpolation=cv2.INTER_AREA) / 255.0
        )
        return out * self._open

    def __post_init__(self) -> None:
        object.__setattr__(self, "_open", self.open_fraction())
        object.__setattr__(self, "_ground", self.ground())

    def film(self, bodies: list[Array]) -> Iterator[NDArray[np.uint8]]:
        """Yield the picture of each body."""
        for k, body in enumerate(bodies):
            yield self.draw(body, k)


def inner(body: Array, margin: float) -> Array:
    """Return the part of a midline that is `margin` away from its tips along the arc, densely."""
    s = arc(body)
    grid = np.arange(margin, s[-1] - margin, 0.5)
    grid = np.append(grid, s[-1] - margin)
    return np.stack([np.interp(grid, s, body[:, k]) for k in (0, 1)], axis=1)


def arc(curve: Array) -> Array:
    """Return the arc length along a polyline."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])


def wall_path(film: Film, turns: float = 1.6, excursions: int = 5, depth: float = 60.0) -> Array:
    """Return a path that touches the wall and leaves it again and again."""
    phi = np.linspace(0, 2 * np.pi * turns, 20000)
    touch = film.radius - film.width / 2
    r = touch - depth * np.clip(np.sin(excursions * phi / turns), 0, None) ** 2
    return np.stack([film.centre[0] + r * np.cos(phi), film.centre[1] - r * np.sin(phi)], axis=1)


def wavy_path(film: Film) -> Array:
    """Return a path through the interior with bends much tighter than the chamber."""
    phi = np.linspace(0, 4 * np.pi, 40000)
    r = film.radius * (0.55 + 0.15 * np.sin(phi / 2) + 0.12 * np.sin(7 * phi))
    return np.stack([film.centre[0] + r * np.cos(phi), film.centre[1] - r * np.sin(phi)], axis=1)


def crawl(path: Array, length: float, frames: int, step: float, start: float = 0.0) -> list[Array]:
    """Return the midline, head first, of a worm that slides along a path head-first."""
    s = arc(path)
    bodies = []
    for k in range(frames):
        head = start + length + k * step
        if head > s[-1]:
            raise ValueError("the path is too short for this crawl")
        grid = np.linspace(head, head - length, 201)
        bodies.append(np.stack([np.interp(grid, s, path[:, j]) for j in (0, 1)], axis=1))
    return bodies


def centroid(body: Array) -> Array:
    """Return the centroid of the area of a body of constant width."""
    s = arc(body)
    weights = np.gradient(s)
    return (body * weights[:, None]).sum(0) / weights.sum()


def _big(point: Array) -> Array:
    return (point + 0.5) * SCALE - 0.5


def _fixed(point: Array) -> tuple[int, int]:
    return round(float(point[0]) * 256), round(float(point[1]) * 256)
