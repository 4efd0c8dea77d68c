"""The illumination behind a worm that was there from the first frame: the picture without it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from worm_msgs_py.arrays import Floats, Floats32, Mask, Picture
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.intervals import SD_OF_MAD

_HUNDRED = 100.0
WALL_REACH_PX = 12
"""How far to either side of the wall its blurred profile is modelled: that of any lens in use."""


@dataclass(frozen=True, slots=True)
class IlluminationSettings:
    """Which pixels are clear water, and which are the worm's, walls' or debris's."""

    darkest_left_out: float = 0.25
    """Part of the pixels that the first fit leaves out: most worms are less of the view."""
    field_samples: int = 20000
    """Pixels that the smooth field is fitted to."""
    most_darker_sd: float = 2.5
    most_brighter_sd: float = 4.0
    """Pixels farther from the field than so many robust deviations are not clear water."""
    rounds: int = 12
    """Most times that the field is fitted until it settles."""
    wall_profile_quantile: float = 0.6
    """Of the pixels at one distance from the wall: above the median, as a worm along the wall makes
    some of them darker."""
    clear_over_brightest: float = 0.85
    """Brightness over that of its brightest pixels from which a passage's pixel is clear water."""
    most_evening: float = 2.0
    """The most that a signal is made stronger or weaker for uneven light."""
    lit_over_entrance: float = 0.6
    """Brightness over that of its entrance from which a place is taken to be in the passage."""
    passage_rim_px: float = 4.0
    """How near to a passage's wall it may be blurred."""


def fit_illumination(picture: Picture, arena: Mask, settings: IlluminationSettings) -> Floats32:
    """Fit a smooth field to the bright background of a picture, dark objects left out.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
    arena : ndarray of bool, shape (h, w)
        Where the background is in view.
    settings : IlluminationSettings

    Returns
    -------
    ndarray of float32, shape (h, w)
        A polynomial of third order; pixels too dark or too bright for it are dropped and the fit
        repeated until it settles.
    """
    h, w = picture.shape
    v, u = np.nonzero(arena)
    stride = max(1, len(v) // settings.field_samples)
    v, u = v[::stride], u[::stride]
    values = picture[v, u].astype(np.float64)
    basis = _polynomial(u / w, v / h)
    keep = values >= np.quantile(values, settings.darkest_left_out)
    field: NDArray[np.floating] = np.zeros(basis.shape[1])
    for _ in range(settings.rounds):
        field, *_ = np.linalg.lstsq(basis[keep], values[keep], rcond=None)
        off = values - basis @ field
        sd = max(SD_OF_MAD * float(np.median(np.abs(off[keep]))), 0.5)
        again = (off > -settings.most_darker_sd * sd) & (off < settings.most_brighter_sd * sd)
        if (again == keep).all() or again.sum() < 4 * basis.shape[1]:
            break
        keep = again
    rows, columns = np.arange(h) / h, np.arange(w) / w
    grid = _polynomial(columns[None, :], rows[:, None])
    return np.asarray(np.clip(grid @ field, 0, 255), np.float32)


def empty_rig(
    picture: Picture, geometry: Geometry, settings: IlluminationSettings
) -> tuple[Floats32, Mask, Floats32]:
    """Return what the picture would show without a worm, and where the worm can be.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        Dark worm on bright background.
    geometry : Geometry
        The rig; without chambers all of the picture is background.
    settings : IlluminationSettings

    Returns
    -------
    background : ndarray of float32, shape (h, w)
        The smooth illumination in the chambers, the wall's usual profile about each circle and
        along the passage, whose walls are like it, and elsewhere the picture itself.
    arena : ndarray of bool, shape (h, w)
        Chambers up to just beyond the wall, and passages.
    light : ndarray of float32, shape (h, w)
        The smooth light of the lamp.
    """
    if not geometry.chambers:
        arena = np.ones(picture.shape, bool)
        light = fit_illumination(picture, arena, settings)
        return light, arena, light
    rigs = _regions(picture, geometry, settings)
    arena = _arena(rigs, picture.shape)
    water = np.zeros(picture.shape, bool)
    clear = np.zeros(picture.shape, bool)
    for region in rigs:
        water |= region.out < -WALL_REACH_PX / 2
        clear |= region.passage & (region.depth > WALL_REACH_PX / 4)
    light = fit_illumination(picture, water | clear, settings)
    background = picture.astype(np.float32)
    background[water] = light[water]
    relative = np.asarray(picture / np.maximum(light, 1.0), np.float32)
    for region in rigs:
        band = (np.abs(region.out) < WALL_REACH_PX) & ~region.passage
        if not band.any():
            continue
        away, part = _wall_profile(relative[band], region.out[band], settings)
        background[band] = light[band] * np.interp(region.out[band], away, part)
        inner = region.passage & (region.out > -WALL_REACH_PX / 2)
        across = np.minimum(region.out, -region.depth)[inner]
        open_water = region.passage & (region.depth > WALL_REACH_PX / 4)
        level = _passage_level(relative[open_water], settings)
        background[inner] = light[inner] * level * np.interp(across, away, part)
    return background, arena, light


def clear_water(arena: Mask, geometry: Geometry) -> Mask:
    """Return where clear water is sure to be bright: away from the walls of the rig."""
    if not geometry.chambers:
        return np.zeros_like(arena)
    size = 2 * (WALL_REACH_PX + 3) + 1
    return cv2.erode(arena.astype(np.uint8), np.ones((size, size), np.uint8)) > 0


def passage_rims(picture: Picture, geometry: Geometry, settings: IlluminationSettings) -> Mask:
    """Return where the walls of a passage blur its edges, shape (h, w)."""
    rims = np.zeros(picture.shape, bool)
    for rig in _regions(picture, geometry, settings):
        rims |= rig.passage & (np.abs(rig.depth) < settings.passage_rim_px) & (rig.out > 0)
    return rims


def evening_of(light: Floats32, arena: Mask, settings: IlluminationSettings) -> Picture:
    """Return what a signal is multiplied by, in hundredths, for light that is the same everywhere.

    A worm takes away a part of the light: where it is dim, it is less dark than the water by fewer
    grey levels.

    Parameters
    ----------
    light : ndarray of float32, shape (h, w)
        See `empty_rig`.
    arena : ndarray of bool, shape (h, w)
        Where a worm can be; the light is made as its mean there.
    settings : IlluminationSettings

    Returns
    -------
    ndarray of uint8, shape (h, w)
    """
    mean = float(light[arena].mean())
    most = settings.most_evening
    even = np.clip(mean / np.maximum(light, 1.0), 1 / most, most)
    return np.asarray(np.rint(_HUNDRED * even), np.uint8)


def evened(signal: Picture, evening: Picture) -> Picture:
    """Return a signal as it would be in light that is the same everywhere; see `evening_of`."""
    return np.asarray(cv2.multiply(signal, evening, scale=1 / _HUNDRED), np.uint8)


def arena_of(picture: Picture, geometry: Geometry, settings: IlluminationSettings) -> Mask:
    """Return where in the picture a worm can be, shape (h, w); see `empty_rig`."""
    if not geometry.chambers:
        return np.ones(picture.shape, bool)
    return _arena(_regions(picture, geometry, settings), picture.shape)


@dataclass(frozen=True, eq=False, slots=True)
class _Regions:
    """One chamber's regions of the picture, pixel by pixel.

    Attributes
    ----------
    out : ndarray of float32
        Distance from the wall's circle, negative in the chamber.
    depth : ndarray of float32
        Distance from the nearer wall of the passage, positive between them.
    passage : ndarray of bool
        The passage, its blurred walls included.
    """

    out: Floats32
    depth: Floats32
    passage: Mask

    @classmethod
    def of(cls, chamber: Chamber, end_m: float, u: Floats32, v: Floats32) -> "_Regions":
        out = np.hypot(u - chamber.centre_u_px, v - chamber.centre_v_px) - chamber.radius_px
        if not np.isfinite(chamber.exit_width_m):
            none = np.zeros(u.shape, bool)
            return cls(out.astype(np.float32), np.full(u.shape, -np.inf, np.float32), none)
        x, y = chamber.to_metres(u.astype(np.float64), v.astype(np.float64))
        half = chamber.exit_width_m / 2 * chamber.px_per_m
        depth = half - np.abs(y) * chamber.px_per_m
        passage = (depth > -3) & (x > 0) & (out > -half) & (x < end_m)
        return cls(out.astype(np.float32), depth.astype(np.float32), passage)


def passage_end(
    picture: Picture,
    geometry: Geometry,
    chamber: Chamber,
    settings: IlluminationSettings,
) -> float:
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
    entrance = np.quantile(brightest[: max(1, len(x) // 8)], 0.9)
    lit = np.flatnonzero(brightest > settings.lit_over_entrance * entrance)
    return float(x[lit[-1]]) if len(lit) else chamber.radius_m


def _regions(
    picture: Picture, geometry: Geometry, settings: IlluminationSettings
) -> list[_Regions]:
    v, u = np.mgrid[0 : picture.shape[0], 0 : picture.shape[1]].astype(np.float32)
    return [
        _Regions.of(chamber, passage_end(picture, geometry, chamber, settings), u, v)
        for chamber in geometry.chambers
    ]


def _arena(rigs: list[_Regions], shape: tuple[int, ...]) -> Mask:
    arena = np.zeros(shape, bool)
    for region in rigs:
        arena |= (region.out < 3) | region.passage
    return arena


def _wall_profile(
    relative: Floats32, away: Floats32, settings: IlluminationSettings
) -> tuple[Floats, Floats]:
    """Return distances from the wall, and the part of the light that is usual at each."""
    step = 0.25
    bins = np.floor(away / step).astype(np.int64)
    index = np.arange(bins.min(), bins.max() + 1)
    at = settings.wall_profile_quantile
    profile = ndimage.labeled_comprehension(
        relative, bins, index, lambda x: np.quantile(x, at), np.float64, np.nan
    )
    known = np.isfinite(profile)
    return (index[known] + 0.5) * step, profile[known]


def _passage_level(relative: Floats32, settings: IlluminationSettings) -> float:
    """Return the brightness of a passage's water over the light's, even if a worm fills most."""
    if not len(relative):
        return 1.0
    return float(
        np.median(relative[relative > settings.clear_over_brightest * np.quantile(relative, 0.95)])
    )


def _polynomial(x: Floats, y: Floats) -> Floats:
    """Return the monomials up to third order, last axis."""
    x, y = np.broadcast_arrays(2 * x - 1, 2 * y - 1)
    terms = [x**i * y**j for i in range(4) for j in range(4 - i)]
    return np.stack(terms, axis=-1)
