"""Draws a body that folds on itself, strand by strand, in subpixels."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.drawing import Coverage, add_worm
from worm_model.simulator.rig.geometry import Rig
from worm_model.simulator.rig.strand_layers import SUBPIXELS, Layers, Strip, sum_strands
from worm_msgs_py.arrays import Floats

TIP_STEPS = 5


@dataclass(frozen=True, slots=True)
class Shade:
    """A worm of one grey.

    Attributes
    ----------
    overlap_darker : bool
        Whether each strand absorbs its share of what the others let pass, as in transmitted light;
        else the body is one dark area.
    """

    overlap_darker: bool


@dataclass(frozen=True, eq=False, slots=True)
class Skin:
    """What a worm lets pass, as a straightened strip, head first.

    Attributes
    ----------
    transmission : ndarray, shape (n, m)
        By arc length (rows) and offset across (columns, the midline in the middle one); 1 in the
        water. The midline lies half-way between the edges.
    first_s_mm, per_mm : float
        Arc length from the head tip of the first row; samples a millimetre, both ways.
    length_mm : float
        From tip to tip.
    width_mm : ndarray, shape (k,)
        Full width between the half-height edges, evenly spaced from tip to tip.
    """

    transmission: Floats
    first_s_mm: float
    per_mm: float
    length_mm: float
    width_mm: Floats


def polyline_body(points_px: Floats, width_px: Floats) -> Body:
    """Return the body along a midline that may have sharp folds, where a smooth curve would stray.

    Parameters
    ----------
    points_px : ndarray, shape (n, 2)
        Midline (u, v), head first, taken as straight between its points.
    width_px : ndarray, shape (n,)
        Full width there. Each end is rounded as a half circle that is as wide as the body at
        its centre, and whose outermost point is the midline's end.
    """
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points_px, axis=0).T))]
    length = float(s[-1])
    ends = [_end_radius(s, width_px), _end_radius(length - s[::-1], width_px[::-1])]
    bend = 1.0 - np.cos(np.linspace(0.0, 0.5 * np.pi, TIP_STEPS + 1))
    at = np.unique(np.round(np.r_[s[:-1], ends[0] * bend, length - ends[1] * bend], 4))
    at = np.r_[at[at < length - 1e-3], length].astype(np.float64)
    half = np.asarray(0.5 * np.interp(at, s, width_px), dtype=np.float64)
    for radius, from_tip in zip(ends, (at, length - at), strict=True):
        inside = np.maximum(radius - from_tip, 0.0)
        near = from_tip < radius
        half[near] = np.sqrt(np.maximum(radius**2 - inside[near] ** 2, 0.0))
    points = np.stack([np.interp(at, s, points_px[:, k]) for k in (0, 1)], axis=1)
    return Body(points, at, 2.0 * half)


def _end_radius(from_tip: Floats, width_px: Floats) -> float:
    """Return the radius of the half circle that ends the body: half of the width at its centre."""
    radius, before = 0.0, -1.0
    for _ in range(50):
        if radius == before:
            break
        radius, before = 0.5 * float(np.interp(radius, from_tip, width_px)), radius
    return radius


def _spine(body: Body) -> slice:
    """Return the midline's points between the centres of the half circles at its ends."""
    half, s = 0.5 * body.width_px, body.s_px
    inside = (half <= s + 1e-3) & (half <= body.length_px - s + 1e-3)
    where = np.flatnonzero(inside & (half > 1e-3))
    return slice(int(where[0]), int(where[-1]) + 1)


def strands_over(body: Body, subpixels: int = SUBPIXELS) -> Layers:
    """Count the strands over each subpixel: the stretches of the midline that reach it.

    A stretch is a run of midline points within half a width of the subpixel; it counts once,
    however sharply it bends, so that a hairpin counts twice only from about half a width behind
    its turn on.
    """
    spine = _spine(body)
    return sum_strands(
        body.points_px[spine], body.s_px[spine], 0.5 * body.width_px[spine], subpixels=subpixels
    )


def covered(layers: Layers) -> Coverage:
    """Return the part of each pixel that lies under any strand."""
    return Coverage(
        layers.u0, layers.v0, _subpixel_means(np.minimum(layers.total, 1.0), layers.subpixels)
    )


def is_folded(body: Body, apart_widths: float = 3.0, near_widths: float = 1.0) -> bool:
    """Tell whether two parts of the body lie on or beside each other.

    Parameters
    ----------
    body : Body
        The worm.
    apart_widths, near_widths : float
        The parts are more than the one apart along the body, and less than the other in the
        picture, from midline to midline, in mean widths.
    """
    width = body.mean_width_px
    count = max(int(np.ceil(body.length_px / (0.25 * width))), 2)
    s = np.linspace(0.0, body.length_px, count)
    at = body.at(s)
    away = np.hypot(*np.moveaxis(at[:, np.newaxis] - at, 2, 0))
    along = np.abs(s[:, np.newaxis] - s)
    return bool(((along > apart_widths * width) & (away < near_widths * width)).any())


def shaded_view(rig: Rig, layers: Layers, shade: Shade) -> NDArray[np.float32]:
    """Return the mean grey levels of a picture with a worm of one grey."""
    return add_worm(rig, absorbed_by_shade(rig, layers, shade))


def absorbed_by_shade(rig: Rig, layers: Layers, shade: Shade) -> Coverage:
    """Return the share of each pixel's light that a worm of one grey absorbs."""
    strands = layers.total if shade.overlap_darker else np.minimum(layers.total, 1.0)
    one = np.float32(rig.optics.worm_transmission)
    here = strands > 0
    whole = np.floor(strands[here])
    absorbed = np.zeros_like(strands)
    absorbed[here] = 1.0 - one**whole * (1.0 - (1.0 - one) * (strands[here] - whole))
    return Coverage(layers.u0, layers.v0, _subpixel_means(absorbed, layers.subpixels))


def skinned_view(rig: Rig, body: Body, skin: Skin) -> NDArray[np.float32]:
    """Return the mean grey levels of a picture with a skin laid along the midline."""
    return add_worm(rig, absorbed_by_skin(rig, body, skin))


def absorbed_by_skin(rig: Rig, body: Body, skin: Skin, subpixels: int = SUBPIXELS) -> Coverage:
    """Return the share of each pixel's light that a skin absorbs which lies along the midline.

    The skin is stretched to the body's length; across, it keeps its millimetres. Where strands
    lie over each other their transmissions multiply.
    """
    density = _skin_density(skin)
    stretch = skin.length_mm / body.length_px
    middle, scale = density.shape[1] // 2, skin.per_mm / rig.px_per_mm
    reach_px = (middle - 1) / scale
    beyond_px = -skin.first_s_mm / stretch

    ahead, behind = (
        end + beyond_px * (end - inner) / np.hypot(*(end - inner))
        for end, inner in (
            (body.points_px[0], body.at(reach_px)),
            (body.points_px[-1], body.at(body.length_px - reach_px)),
        )
    )
    points = np.vstack([ahead, body.points_px, behind])
    s = np.r_[-beyond_px, body.s_px, body.length_px + beyond_px]
    rows_per_px = stretch * skin.per_mm
    strip = Strip(density, rows_per_px, skin.first_s_mm * skin.per_mm, scale)
    reach = np.full(len(s), reach_px)
    u0, v0, total, _ = sum_strands(points, s, reach, strip, subpixels)
    passes = cv2.exp(np.negative(total, out=total), dst=total)
    return Coverage(u0, v0, _subpixel_means(1.0 - passes, subpixels))


@lru_cache(maxsize=4)
def _skin_density(skin: Skin) -> NDArray[np.float32]:
    """Return −ln of the transmission, faded to nothing at the strip's borders."""
    density = -np.log(np.maximum(skin.transmission, 0.02))
    rows, columns = density.shape
    fade = 0.1 * skin.per_mm
    across = np.minimum(np.arange(columns), columns - 1 - np.arange(columns)) / fade
    along = np.minimum(np.arange(rows), rows - 1 - np.arange(rows)) / fade
    faded = density * np.minimum(across, 1.0) * np.minimum(along, 1.0)[:, np.newaxis]
    return np.asarray(faded, dtype=np.float32)


def _subpixel_means(fine: NDArray[np.float32], subpixels: int) -> NDArray[np.float32]:
    """Return the mean of each pixel's subpixels."""
    rows, columns = fine.shape[0] // subpixels, fine.shape[1] // subpixels
    mean = cv2.resize(fine, (columns, rows), interpolation=cv2.INTER_AREA)
    return np.asarray(mean, dtype=np.float32)
