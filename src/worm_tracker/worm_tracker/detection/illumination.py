"""The light behind a worm that was there from the first frame: what one would see without it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from worm_msgs_py.chamber import Chamber, Geometry

Picture = NDArray[np.uint8]
Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]

SAMPLES = 20000
"""Pixels that the smooth field is fitted to."""
WALL_REACH_PX = 12
"""How far to either side of the wall its blurred profile is modelled."""


def fit_light(picture: Picture, arena: NDArray[np.bool_]) -> Floats:
    """Fit a smooth field to the bright ground of a picture, dark objects left out.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
    arena : ndarray of bool, shape (h, w)
        Where the ground is in view.

    Returns
    -------
    ndarray of float32, shape (h, w)
        A polynomial of third order; pixels darker than 2.5 robust deviations, or brighter than
        four, are dropped and the fit repeated until it settles.
    """
    h, w = picture.shape
    v, u = np.nonzero(arena)
    stride = max(1, len(v) // SAMPLES)
    v, u = v[::stride], u[::stride]
    values = picture[v, u].astype(np.float64)
    basis = _polynomial(u / w, v / h)
    keep = values >= np.quantile(values, 0.25)  # most worms are less than a quarter of the view
    field: NDArray[np.floating] = np.zeros(basis.shape[1])
    for _ in range(12):
        field, *_ = np.linalg.lstsq(basis[keep], values[keep], rcond=None)
        off = values - basis @ field
        sd = max(1.4826 * float(np.median(np.abs(off[keep]))), 0.5)
        again = (off > -2.5 * sd) & (off < 4 * sd)
        if (again == keep).all() or again.sum() < 4 * basis.shape[1]:
            break
        keep = again
    rows, columns = np.arange(h) / h, np.arange(w) / w
    grid = _polynomial(columns[None, :], rows[:, None])
    return np.asarray(np.clip(grid @ field, 0, 255), np.float32)


def empty_rig(picture: Picture, geometry: Geometry) -> tuple[Floats, NDArray[np.bool_]]:
    """Return what the picture would show without a worm, and where the worm can be.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        Dark worm on bright ground.
    geometry : Geometry
        The rig; without chambers all of the picture is ground.

    Returns
    -------
    ground : ndarray of float32, shape (h, w)
        The smooth light in the chambers, the wall's usual profile about each circle and along the
        passage, whose walls are like it, and elsewhere the picture itself.
    arena : ndarray of bool, shape (h, w)
        Chambers up to just beyond the wall, and passages.
    """
    if not geometry.chambers:
        arena = np.ones(picture.shape, bool)
        return fit_light(picture, arena), arena
    rigs = _parts_of(picture, geometry)
    arena = _arena(rigs, picture.shape)
    water = np.zeros(picture.shape, bool)
    clear = np.zeros(picture.shape, bool)
    for parts in rigs:
        water |= parts.out < -WALL_REACH_PX / 2
        clear |= parts.passage & (parts.depth > WALL_REACH_PX / 4)
    light = fit_light(picture, water | clear)
    ground = picture.astype(np.float32)
    ground[water] = light[water]
    relative = np.asarray(picture / np.maximum(light, 1.0), np.float32)
    for parts in rigs:
        band = (np.abs(parts.out) < WALL_REACH_PX) & ~parts.passage
        if not band.any():
            continue
        away, part = _wall_profile(relative[band], parts.out[band])
        ground[band] = light[band] * np.interp(parts.out[band], away, part)
        inner = parts.passage & (parts.out > -WALL_REACH_PX / 2)
        across = np.minimum(parts.out, -parts.depth)[inner]
        level = _level(relative[parts.passage & (parts.depth > WALL_REACH_PX / 4)])
        ground[inner] = light[inner] * level * np.interp(across, away, part)
    return ground, arena


def arena_of(picture: Picture, geometry: Geometry) -> NDArray[np.bool_]:
    """Return where in the picture a worm can be, shape (h, w); see `empty_rig`."""
    if not geometry.chambers:
        return np.ones(picture.shape, bool)
    return _arena(_parts_of(picture, geometry), picture.shape)


@dataclass(frozen=True, eq=False, slots=True)
class _Parts:
    """One chamber's parts of the picture, pixel by pixel.

    Attributes
    ----------
    out : ndarray of float32
        Distance from the wall's circle, negative in the chamber.
    depth : ndarray of float32
        Distance from the nearer wall of the passage, positive between them.
    passage : ndarray of bool
        The passage, its blurred walls included.
    """

    out: Floats
    depth: Floats
    passage: NDArray[np.bool_]

    @classmethod
    def of(cls, chamber: Chamber, end_m: float, u: Floats, v: Floats) -> "_Parts":
        out = np.hypot(u - chamber.centre_u_px, v - chamber.centre_v_px) - chamber.radius_px
        if not np.isfinite(chamber.exit_width_m):
            none = np.zeros(u.shape, bool)
            return cls(out.astype(np.float32), np.full(u.shape, -np.inf, np.float32), none)
        x, y = chamber.to_metres(u.astype(np.float64), v.astype(np.float64))
        half = chamber.exit_width_m / 2 * chamber.px_per_m
        depth = half - np.abs(y) * chamber.px_per_m
        passage = (depth > -3) & (x > 0) & (out > -half) & (x < end_m)
        return cls(out.astype(np.float32), depth.astype(np.float32), passage)


def passage_end(picture: Picture, geometry: Geometry, chamber: Chamber) -> float:
    """Return how far along a chamber's x axis its passage goes, metres; NaN without an exit.

    To the other chamber's wall where that is in view; otherwise as far as light comes through
    anywhere across the passage, because what is behind its end, or the picture's, is not water.
    """
    if not np.isfinite(chamber.exit_width_m):
        return float("nan")
    half = chamber.exit_width_m / 2
    for other in geometry.chambers:
        if other.name != chamber.name:
            apart, _ = chamber.to_metres(other.centre_u_px, other.centre_v_px)
            return apart - other.radius_m + half
    x = np.arange(chamber.radius_m, 3 * max(picture.shape) / chamber.px_per_m, 1 / chamber.px_per_m)
    y = np.linspace(-half, half, max(3, round(chamber.exit_width_m * chamber.px_per_m)))
    u, v = chamber.to_pixels(x[:, None], y[None])
    across = cv2.remap(
        picture, u.astype(np.float32), v.astype(np.float32), cv2.INTER_NEAREST, borderValue=(0,) * 4
    )
    brightest = np.asarray(across, np.float64).max(axis=1)
    lit = np.flatnonzero(brightest > 0.6 * np.quantile(brightest[: max(1, len(x) // 8)], 0.9))
    return float(x[lit[-1]]) if len(lit) else chamber.radius_m


def _parts_of(picture: Picture, geometry: Geometry) -> list[_Parts]:
    v, u = np.mgrid[0 : picture.shape[0], 0 : picture.shape[1]].astype(np.float32)
    return [
        _Parts.of(chamber, passage_end(picture, geometry, chamber), u, v)
        for chamber in geometry.chambers
    ]


def _arena(rigs: list[_Parts], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    arena = np.zeros(shape, bool)
    for parts in rigs:
        arena |= (parts.out < 3) | parts.passage
    return arena


def _wall_profile(relative: Floats, away: Floats) -> tuple[Doubles, Doubles]:
    """Return distances from the wall, and the part of the light that is usual at each."""
    step = 0.25
    bins = np.floor(away / step).astype(np.int64)
    index = np.arange(bins.min(), bins.max() + 1)
    # Above the median: where a worm lies along the wall the pixels are darker than without it.
    profile = ndimage.labeled_comprehension(
        relative, bins, index, lambda x: np.quantile(x, 0.6), np.float64, np.nan
    )
    known = np.isfinite(profile)
    return (index[known] + 0.5) * step, profile[known]


def _level(relative: Floats) -> float:
    """Return the brightness of a passage's water over the light's, even if a worm fills most."""
    if not len(relative):
        return 1.0
    return float(np.median(relative[relative > 0.85 * np.quantile(relative, 0.95)]))


def _polynomial(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the monomials up to third order, last axis."""
    x, y = np.broadcast_arrays(2 * x - 1, 2 * y - 1)
    terms = [x**i * y**j for i in range(4) for j in range(4 - i)]
    return np.stack(terms, axis=-1)
