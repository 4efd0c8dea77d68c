"""Draws the rig and the worm in it, as the camera sees them."""

from functools import lru_cache
from itertools import combinations, pairwise
from math import ceil, sqrt
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.geometry import Rig
from worm_model.simulator.rig.optics import FilmedPicture, Optics

SIXTEEN, STEPS_16 = 16, 257
"""Bits of a deep picture, and its steps for each grey level of a picture of 8 bits."""

TILE_PX = 16


class Coverage(NamedTuple):
    """The part of each pixel that the body covers, in a crop.

    Attributes
    ----------
    u0, v0 : int
        Picture coordinates of the crop's first pixel; may lie outside the picture.
    part : ndarray of float32, shape (height, width)
        0 to 1.
    """

    u0: int
    v0: int
    part: NDArray[np.float32]

    def centroid_px(self) -> tuple[float, float]:
        """Centroid (u, v) of the covered area."""
        part = self.part.astype(np.float64)
        columns, rows = part.sum(axis=0), part.sum(axis=1)
        area = columns.sum()
        u = float(columns @ np.arange(len(columns)) / area)
        v = float(rows @ np.arange(len(rows)) / area)
        return self.u0 + u, self.v0 + v


def draw(rig: Rig, body: Body | None, frame: int) -> FilmedPicture:
    """Draw one frame of the film.

    Parameters
    ----------
    rig : Rig
        The rig and its camera.
    body : Body or None
        The worm; None for the empty rig. What of it lies behind the wall is not seen.
    frame : int
        Number of the frame: chooses the noise.

    Returns
    -------
    ndarray of uint8 or uint16, shape (rig.height_px, rig.width_px)
        Grey levels. The same arguments give the same bytes.

    Notes
    -----
    Wall and worm are drawn by the share of each pixel that they cover; as their areas exclude each
    other, their absorptions add, and blur, being linear, can be applied to each. A straight edge
    is therefore at half its height exactly where it is in the rig. At an end of curvature radius ρ
    the blur of standard deviation σ draws that level inwards by about σ²/2ρ, as a lens does.
    """
    return expose(rig, clear_view(rig, body), frame)


def clear_view(rig: Rig, body: Body | None) -> NDArray[np.float32]:
    """Return the mean grey level of each pixel: the picture before noise and rounding.

    Parameters
    ----------
    rig : Rig
        The rig and its camera.
    body : Body or None
        The worm; None for the empty rig.

    Returns
    -------
    ndarray of float32, shape (rig.height_px, rig.width_px)
        A new array.
    """
    empty, light, open_part = _empty_rig(rig)
    picture = empty.copy()
    if body is not None:
        _absorb(rig, body, picture, light, open_part)
    return picture


def expose(rig: Rig, view: NDArray[np.float32], frame: int) -> FilmedPicture:
    """Take the picture of a view: add the noise of this frame and round to grey levels.

    Parameters
    ----------
    rig : Rig
        Gives the noise.
    view : ndarray of float32, shape (rig.height_px, rig.width_px)
        Mean grey levels, 0 to 255; changed in place.
    frame : int
        Number of the frame: chooses the noise.

    Returns
    -------
    ndarray of uint8 or uint16, as the optics have it
        In 16 bits a grey level is 257 steps.
    """
    optics = rig.optics
    if optics.shot_noise > 0.0:
        spread = np.maximum(view, 0.0)
        spread *= np.float32(optics.shot_noise)
        spread += np.float32(optics.noise**2)
        cv2.sqrt(spread, dst=spread)
        spread *= optics.noise_of_frame(frame, view.shape)
        view += spread
    elif optics.noise > 0.0:
        noise = optics.noise_of_frame(frame, view.shape)
        noise *= np.float32(optics.noise)
        view += noise
    np.clip(view, 0.0, 255.0, out=view)
    deep = optics.bits == SIXTEEN
    if deep:
        view *= np.float32(STEPS_16)
    np.rint(view, out=view)
    return view.astype(np.uint16) if deep else view.astype(np.uint8)


def add_worm(rig: Rig, absorbed: Coverage) -> NDArray[np.float32]:
    """Return the mean grey level of each pixel of the rig with a worm drawn by other means.

    Parameters
    ----------
    rig : Rig
        The rig and its camera.
    absorbed : Coverage
        The share of each pixel's light that the worm absorbs, sharp; none of it behind the wall.
    """
    empty, light, open_part = _empty_rig(rig)
    picture, margin = empty.copy(), ceil(4.0 * rig.optics.blur_px) + 1
    left, top = absorbed.u0 - margin, absorbed.v0 - margin
    part = np.pad(absorbed.part, margin)
    bottom, right = top + part.shape[0], left + part.shape[1]
    if top >= rig.height_px or left >= rig.width_px or bottom <= 0 or right <= 0:
        return picture
    cut = np.s_[max(-top, 0) : rig.height_px - top, max(-left, 0) : rig.width_px - left]
    here = np.s_[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)]
    seen = np.minimum(part[cut], open_part[here])
    picture[here] -= light[here] * _blurred(seen, rig.optics.blur_px)
    return picture


def worm_coverage(body: Body, margin_px: int = 1) -> Coverage:
    """Return the part of each pixel that the body covers, sharp (before any blur).

    Parameters
    ----------
    body : Body
        The worm.
    margin_px : int
        Empty pixels around it.

    Notes
    -----
    The body is a union of tapered capsules; the share of a pixel is ½ − (signed distance of its
    centre from the outline), cut to 0…1, which is exact where the outline is parallel to an axis
    and exact at one half everywhere.
    """
    return _coverage(*body.discs(), margin_px)


def crossings(body: Body, coverage: Coverage) -> NDArray[np.float32] | None:
    """Return the part of each pixel that the body covers a second time, where it crosses itself.

    Parameters
    ----------
    body : Body
        The worm.
    coverage : Coverage
        Its coverage.

    Returns
    -------
    ndarray of float32, shape of ``coverage.part``, or None
        None where no part of the body lies over another.

    Notes
    -----
    The body is cut into pieces of three widths. Neighbours overlap at their common end by
    construction; any other two overlap only where the body lies over itself.
    """
    centres, radius = body.discs()
    count = max(ceil(body.length_px / (3.0 * float(body.width_px.max()))), 1)
    cuts = np.linspace(0, len(centres) - 1, count + 1).astype(int)
    pieces = [np.s_[a : b + 1] for a, b in pairwise(cuts.tolist()) if b > a]
    boxes = [_box(centres[piece], radius[piece]) for piece in pieces]
    twice: NDArray[np.float32] | None = None
    for (i, one), (j, other) in combinations(enumerate(pieces), 2):
        if j < i + 2 or not _boxes_meet(boxes[i], boxes[j]):
            continue
        if twice is None:
            twice = np.zeros_like(coverage.part)
        both = [_placed(_coverage(centres[p], radius[p], 1), coverage) for p in (one, other)]
        np.maximum(twice, np.minimum(*both), out=twice)
    return twice


def _box(centres: NDArray[np.float64], radius: NDArray[np.float64]) -> NDArray[np.float64]:
    reach = radius.max() + 1.0
    return np.stack([centres.min(axis=0) - reach, centres.max(axis=0) + reach])


def _boxes_meet(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool((one[0] <= other[1]).all() and (other[0] <= one[1]).all())


def _placed(piece: Coverage, whole: Coverage) -> NDArray[np.float32]:
    """Return a piece's coverage in the crop of the whole body, which holds it."""
    out = np.zeros_like(whole.part)
    left, top = piece.u0 - whole.u0, piece.v0 - whole.v0
    source_left, source_top = max(-left, 0), max(-top, 0)
    left, top = max(left, 0), max(top, 0)
    part = piece.part[source_top:, source_left:][: out.shape[0] - top, : out.shape[1] - left]
    out[top : top + part.shape[0], left : left + part.shape[1]] = part
    return out


def _coverage(
    centres: NDArray[np.float64], radius: NDArray[np.float64], margin_px: int
) -> Coverage:
    reach = ceil(float(radius.max()) + 2.0) + margin_px
    first = np.floor(centres.min(axis=0)).astype(int) - reach
    last = np.ceil(centres.max(axis=0)).astype(int) + reach
    width, height = (last - first + 1).tolist()
    distance = np.full((height, width), np.inf, dtype=np.float32)
    _union_of_capsules(distance, centres - first, radius)
    part = np.clip(np.float32(0.5) - distance, 0.0, 1.0)
    return Coverage(int(first[0]), int(first[1]), part)


def _union_of_capsules(
    distance: NDArray[np.float32], centres: NDArray[np.float64], radius: NDArray[np.float64]
) -> None:
    """Lower `distance` to the signed distance of the capsules between consecutive discs."""
    p, q = centres[:-1], centres[1:]
    step = np.hypot(*(q - p).T)
    half = ceil(float(radius.max() + 0.5 * step.max()) + 1.5)
    middle = np.rint(0.5 * (p + q)).astype(int)
    offset = np.arange(-half, half + 1)
    # Coordinates of every pixel of every capsule's patch, along and across the capsule's axis.
    du = (middle[:, 0] - p[:, 0])[:, np.newaxis] + offset
    dv = (middle[:, 1] - p[:, 1])[:, np.newaxis] + offset
    axis = (q - p) / step[:, np.newaxis]
    du, dv, axis = du.astype(np.float32), dv.astype(np.float32), axis.astype(np.float32)
    patch = _capsule_distance(
        (axis[:, 0, None] * du)[:, None, :] + (axis[:, 1, None] * dv)[:, :, None],
        np.abs((axis[:, 0, None] * dv)[:, :, None] - (axis[:, 1, None] * du)[:, None, :]),
        step,
        radius,
    )
    for (column, row), values in zip((middle - half).tolist(), patch, strict=True):
        # The crop's margin is wide enough for every patch, save for what is farther than a pixel.
        top, left = max(row, 0), max(column, 0)
        view = distance[top : row + 2 * half + 1, left : column + 2 * half + 1]
        shown = values[top - row :, left - column :][: view.shape[0], : view.shape[1]]
        np.minimum(view, shown, out=view)


def _capsule_distance(
    along: NDArray[np.float32],
    across: NDArray[np.float32],
    step: NDArray[np.float64],
    radius: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Signed distance from capsules with a disc of another radius at each end."""

    def each(values: NDArray[np.float64]) -> NDArray[np.float32]:
        return np.asarray(values, dtype=np.float32)[:, None, None]

    # At a slope of ±1 one disc lies within the other and the flank has no length.
    slope = np.clip((radius[:-1] - radius[1:]) / step, -0.9999, 0.9999)
    flank = np.sqrt(1.0 - slope**2)
    place = each(flank) * along - each(slope) * across
    first = np.hypot(along, across) - each(radius[:-1])
    second = np.hypot(along - each(step), across) - each(radius[1:])
    side = each(slope) * along + each(flank) * across - each(radius[:-1])
    inner = np.where(place > each(flank * step), second, side)
    return np.asarray(np.where(place < 0.0, first, inner), dtype=np.float32)


def _absorb(
    rig: Rig,
    body: Body,
    picture: NDArray[np.float32],
    light: NDArray[np.float32],
    open_part: NDArray[np.float32],
) -> None:
    """Take from `picture` the light that the worm absorbs."""
    coverage = worm_coverage(body, margin_px=ceil(4.0 * rig.optics.blur_px) + 1)
    u0, v0, part = coverage
    transmission = np.float32(rig.optics.worm_transmission)
    if rig.optics.crossings_absorb:
        twice = crossings(body, coverage)
        if twice is not None:
            part = part + transmission * twice  # of the light that the first layer let pass
    top, left = max(v0, 0), max(u0, 0)
    bottom, right = min(v0 + part.shape[0], rig.height_px), min(u0 + part.shape[1], rig.width_px)
    if top >= bottom or left >= right:
        return
    here = np.s_[top:bottom, left:right]
    most = open_part[here] * np.float32(max(1.0, part.max()))
    seen = np.minimum(part[top - v0 : bottom - v0, left - u0 : right - u0], most)
    absorbed = np.float32(1.0 - rig.optics.worm_transmission) * _blurred(seen, rig.optics.blur_px)
    picture[here] -= light[here] * absorbed


@lru_cache(maxsize=4)
def _empty_rig(
    rig: Rig,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Return the picture without worm and noise, the light, and the open part of each pixel."""
    open_part, light = _open_part(rig), _light(rig.optics, rig.width_px, rig.height_px)
    wall = np.float32(rig.optics.wall_transmission)
    empty = (1 - wall) * _blurred(open_part, rig.optics.blur_px)
    empty += wall
    empty *= light
    return empty, light, open_part


@lru_cache(maxsize=4)
def _light(optics: Optics, width_px: int, height_px: int) -> NDArray[np.float32]:
    return optics.light_field(width_px, height_px)


def _open_part(rig: Rig) -> NDArray[np.float32]:
    """Return the part of each pixel that is water.

    The wall's distance is asked for in the tiles that an edge may pass through; any other is all
    water or all wall, as its middle is.
    """
    rows, columns = -(-rig.height_px // TILE_PX), -(-rig.width_px // TILE_PX)
    within = np.arange(TILE_PX, dtype=np.float64)
    u = np.arange(columns, dtype=np.float64) * TILE_PX
    v = np.arange(rows, dtype=np.float64) * TILE_PX
    half = 0.5 * (TILE_PX - 1)
    middle = rig.wall_distance_px(u + half, v[:, np.newaxis] + half)
    tiles = np.empty((rows, columns, TILE_PX, TILE_PX), dtype=np.float32)
    tiles[:] = (middle < 0.0)[..., np.newaxis, np.newaxis]
    at_edge = np.nonzero(np.abs(middle) < half * sqrt(2.0) + 0.5)
    down, right = at_edge
    distance = rig.wall_distance_px(
        u[right, np.newaxis, np.newaxis] + within,
        v[down, np.newaxis, np.newaxis] + within[:, np.newaxis],
    )
    tiles[at_edge] = np.clip(0.5 - distance, 0.0, 1.0)
    whole = tiles.swapaxes(1, 2).reshape(rows * TILE_PX, columns * TILE_PX)
    return np.ascontiguousarray(whole[: rig.height_px, : rig.width_px])


def _blurred(values: NDArray[np.float32], sd_px: float) -> NDArray[np.float32]:
    if sd_px <= 0.0:
        return values
    blurred = cv2.GaussianBlur(values, (0, 0), sd_px, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(blurred, dtype=np.float32)
