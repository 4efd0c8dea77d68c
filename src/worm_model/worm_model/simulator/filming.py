"""Films a worm's midlines as the rig's camera sees them: lamp, water, dirt, shutter and sensor."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import ceil

import numpy as np
from scipy.interpolate import CubicSpline

from worm_model.simulator.body_width import tapered
from worm_model.simulator.film import FilmFrame, frame_stamp_ns
from worm_model.simulator.rig import Body, Rig, expose, truth_of
from worm_model.simulator.rig import disturbances as seen
from worm_model.simulator.rig.drawing import Coverage, add_worm
from worm_model.simulator.rig.strand_layers import Layers
from worm_model.simulator.rig.strands import (
    Shade,
    Skin,
    absorbed_by_shade,
    absorbed_by_skin,
    covered,
    polyline_body,
    strands_over,
)
from worm_msgs_py.arrays import Floats

DRAWN_STEP_WIDTHS = 0.4
DRAWN_SUBPIXELS = 2
"""How finely a body is drawn: in steps along it, and in parts of a pixel."""


@dataclass(frozen=True, eq=False, slots=True)
class Filming:
    """How a worm is filmed, beside what the rig and its optics say.

    Attributes
    ----------
    frames_per_s : float
    body_width_mm : float
        Full width of the body's middle; the ends taper. Of a worm without a skin.
    skin : Skin, optional
        A real worm's look and width profile, stretched to the body's length.
    overlap_darker : bool
        Whether a part of the body that lies over another takes its share of the light, too.
    exposure_s : float
        How long the shutter is open, around the frame's stamp; 0 for no motion blur. A frame's
        time at most.
    flicker : float
        The lamp's brightness is uniform in 1 ± this, anew in each frame.
    debris, bubbles, glare : int
        Specks that lie in the chamber, bubbles in it, and bright spots over it.
    drift_mm_per_min : tuple of float
        How fast the rig moves in the picture, right and down.
    specks_mm, bubbles_mm, glare_mm : (float, float)
        Smallest and largest radius; of glare the standard deviation.
    glare_grey : float
        Grey levels of glare in its middle.
    least_moments : int
        An exposure is the mean of so many moments at least, and a point moves by a pixel at most
        between two of them: its smear is off by less than 1/12 px² in its variance, of a lens by
        about 1.
    drift_step_px : float
        A drifting camera moves in such steps: the empty rig is drawn anew for each.

    Raises
    ------
    ValueError
        An exposure longer than a frame.
    """

    frames_per_s: float = 30.0
    body_width_mm: float = 0.5
    skin: Skin | None = None
    overlap_darker: bool = True
    exposure_s: float = 0.0
    flicker: float = 0.0
    debris: int = 0
    bubbles: int = 0
    glare: int = 0
    drift_mm_per_min: tuple[float, float] = (0.0, 0.0)
    specks_mm: tuple[float, float] = (0.06, 0.25)
    bubbles_mm: tuple[float, float] = (0.4, 1.1)
    glare_mm: tuple[float, float] = (0.4, 1.0)
    glare_grey: float = 60.0
    least_moments: int = 2
    drift_step_px: float = 0.125

    def __post_init__(self) -> None:
        if self.exposure_s * self.frames_per_s > 1.0:
            frame_ms = 1e3 / self.frames_per_s
            raise ValueError(
                f"{1e3 * self.exposure_s:g} ms of exposure are longer than a frame, {frame_ms:g} ms"
            )


def film(midlines_mm: Iterable[Floats], rig: Rig, filming: Filming) -> Iterator[FilmFrame]:
    """Film midlines, one a frame.

    Parameters
    ----------
    midlines_mm : iterable of ndarray, shape (n, 2)
        x, y in the frame of chamber a, head tip first; smooth curves through these points.
    rig : Rig
        The rig, its camera and its optics; the same seed gives the same bytes.
    filming : Filming
        The worm's look, and what disturbs the picture.

    Yields
    ------
    FilmFrame
        Stamp (from 0), picture, and the truth at the stamp. The centroid is that of the area that
        the body covers; what it covers twice counts once. A worm that is out of the picture has a
        truth all the same.
    """
    dirt = _Dirt.scattered(rig, filming)
    stained, stains = rig, dirt.stains(rig, filming.glare_grey)
    for frame, (line, before, after) in enumerate(_with_neighbours(midlines_mm)):
        stamp_ns = frame_stamp_ns(frame, filming.frames_per_s)
        now = _drifted(rig, filming, frame)
        body = _body(now, line, filming)
        strands = strands_over(body, DRAWN_SUBPIXELS)
        if filming.exposure_s > 0.0:
            absorbed = _smeared(now, line, before, after, filming)
        else:
            absorbed = _absorbed(now, body, filming, strands)
        view = add_worm(now, absorbed)
        if now != stained:
            stained, stains = now, dirt.stains(now, filming.glare_grey)
        for stain in stains:
            stain.draw(view)
        if filming.flicker > 0.0:
            view *= np.float32(seen.flicker_gain(frame, filming.flicker, rig.optics.seed))
        truth = truth_of(now, body, frame, stamp_ns, covered(strands))
        yield FilmFrame(stamp_ns, expose(now, view, frame), truth)


@dataclass(frozen=True, slots=True)
class _Dirt:
    """What lies in the chambers and over them, in the frame of chamber a."""

    specks: list[seen.Spot] = field(default_factory=list)
    bubbles: list[seen.Spot] = field(default_factory=list)
    glare: list[seen.Spot] = field(default_factory=list)

    @classmethod
    def scattered(cls, rig: Rig, filming: Filming) -> "_Dirt":
        within, seed = 0.95 * rig.radius_mm, rig.optics.seed
        inner = within - filming.bubbles_mm[1]
        return cls(
            seen.scattered(filming.debris, within, *filming.specks_mm, seed),
            seen.scattered(filming.bubbles, inner, *filming.bubbles_mm, seed + 1),
            seen.scattered(filming.glare, within, *filming.glare_mm, seed + 2),
        )

    def stains(self, rig: Rig, glare_grey: float) -> list[seen.Stain]:
        return [
            *(seen.speck_stain(rig, speck) for speck in self.specks),
            *(seen.bubble_stain(rig, bubble) for bubble in self.bubbles),
            *(seen.glare_stain(rig, spot, glare_grey) for spot in self.glare),
        ]


def _with_neighbours(lines: Iterable[Floats]) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Yield each midline with those before and after it; at the film's ends with itself."""
    before = None
    for line, after in pairwise(_once_more(lines)):
        yield line, line if before is None else before, after
        before = line


def _once_more(lines: Iterable[Floats]) -> Iterator[Floats]:
    last = None
    for last in lines:
        yield last
    if last is not None:
        yield last


def _drifted(rig: Rig, filming: Filming, frame: int) -> Rig:
    """Return the rig where the camera has it in this frame."""
    if not any(filming.drift_mm_per_min):
        return rig
    minutes = frame / filming.frames_per_s / 60.0
    way = np.array(filming.drift_mm_per_min) * minutes * rig.px_per_mm
    step_px = filming.drift_step_px
    u, v = np.array(rig.centre_px) + step_px * np.rint(way / step_px)
    return replace(rig, centre_px=(float(u), float(v)))


def _body(rig: Rig, line_mm: Floats, filming: Filming) -> Body:
    """Return the body in the picture: its true outline."""
    u, v = rig.chambers[0].to_pixels(line_mm[:, 0] * 1e-3, line_mm[:, 1] * 1e-3)
    points = np.c_[u, v]
    chord = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    skin, full = filming.skin, filming.body_width_mm * rig.px_per_mm
    if skin is not None:
        full = float(np.median(skin.width_mm)) * rig.px_per_mm
    count = round(chord[-1] / (DRAWN_STEP_WIDTHS * full)) + 2
    at = np.linspace(0.0, chord[-1], count)
    part = at / chord[-1]
    if skin is not None:
        given = np.linspace(0.0, 1.0, len(skin.width_mm))
        width = np.interp(part, given, skin.width_mm) * rig.px_per_mm
    else:
        width = full * tapered(at / full)
    return polyline_body(np.asarray(CubicSpline(chord, points)(at)), width)


def _absorbed(rig: Rig, body: Body, filming: Filming, strands: Layers | None = None) -> Coverage:
    """Return what the worm absorbs; its strands may be at hand already."""
    if filming.skin is not None:
        return absorbed_by_skin(rig, body, filming.skin, DRAWN_SUBPIXELS)
    strands = strands or strands_over(body, DRAWN_SUBPIXELS)
    return absorbed_by_shade(rig, strands, Shade(filming.overlap_darker))


def _smeared(rig: Rig, line: Floats, before: Floats, after: Floats, filming: Filming) -> Coverage:
    """Return what the worm absorbs while the shutter is open: the mean over its moments."""
    reach = 0.5 * filming.exposure_s * filming.frames_per_s
    way_mm = reach * (np.hypot(*(line - before).T) + np.hypot(*(after - line).T))
    count = max(filming.least_moments, ceil(float(way_mm.max()) * rig.px_per_mm))
    moments = []
    for part in reach * (np.arange(1 - count, count, 2) / count):
        neighbour = after if part > 0.0 else before
        body = _body(rig, line + abs(part) * (neighbour - line), filming)
        moments.append(_absorbed(rig, body, filming))
    return _mean_coverage(moments)


def _mean_coverage(parts: list[Coverage]) -> Coverage:
    """Return the mean over crops of different places."""
    u0, v0 = min(part.u0 for part in parts), min(part.v0 for part in parts)
    right = max(part.u0 + part.part.shape[1] for part in parts)
    bottom = max(part.v0 + part.part.shape[0] for part in parts)
    total = np.zeros((bottom - v0, right - u0), dtype=np.float32)
    for one in parts:
        top, left = one.v0 - v0, one.u0 - u0
        total[top : top + one.part.shape[0], left : left + one.part.shape[1]] += one.part
    total /= np.float32(len(parts))
    return Coverage(u0, v0, total)
