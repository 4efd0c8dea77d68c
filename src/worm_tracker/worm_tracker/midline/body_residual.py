"""What of an object a body with this midline does not explain, and what of the body is not there.

Every point of a worm's picture lies on some part of its body, and every part of its body is in the
picture. What is left over, in squared widths, is a sign of a midline that is wrong however much of
the object it explains: a tip that sticks out, a strand taken for two, a body drawn into clear
water. Where overlaps are darker, a dark place under one strand alone, or two strands in a place
that is not dark, tell as much.
"""

from dataclasses import dataclass, field
from functools import cache, cached_property
from math import ceil, floor
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.midline.body_shade import (
    BodyShadeSettings,
    ShadedObject,
    misjudged_layers,
)
from worm_tracker.midline.mask_centroid import mask_centroid
from worm_tracker.midline.occupied_part import occupied_part
from worm_tracker.midline.path import sharp_turns
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands

Image = cv2.typing.MatLike
_SPECK = np.ones((2, 2), np.uint8)


@dataclass(frozen=True, slots=True)
class BodyResidualSettings:
    """Which pixels count as left over."""

    rim_widths: float = 0.12
    """How near to an edge object and body need not agree: edges are blurred, widths vary."""
    least_rim_px: float = 1.0
    """The same at least."""
    dark_over_darkening: float = 0.5
    """Part of the darkening of an overlap from which on a place is dark."""
    most_left_over: float = 0.2
    most_overlap: float = 0.3
    """What may be left over of an object, and of its dark places, for a propagated midline to be
    believed, squared widths."""
    most_in_water_px2: float = 65.0
    """What of a body may lie in the water, pixels, where that is more: a narrow body's width is
    known the less well."""
    most_of_contour_body: float = 1.2
    most_of_folded_body: float = 0.5
    """What a body found by its contour may leave unexplained, squared widths: an open one, whose
    sharp corners a first midline cuts; and one that lies near itself."""
    most_lacked_at_end_widths2: float = 0.2
    """What of that may lie beside an end of a body that the contour gives: of 108 bodies that
    lacked more there, dark places counted, 62 were wrong; of 91 that lacked 0.1 to 0.2, 21."""
    broad_end_widths: float = 2.0
    most_broader_at_end_widths2: float = 0.15
    most_broader_at_marked_end_widths2: float = 0.2
    """How far from an end a body that the contour gives may be broader than the worm, and by what
    area, without marks and with them, whose pale rims come and go: in eight films the head of 21 of
    60 bodies beyond 0.2 was more than 0.6 widths off, of 4604 others of 4; a head that curls up
    beside its neck is broader by 0.18 to 0.23 while it comes to lie a width off."""
    sd_of_broad_end_widths: float = 0.5
    least_log_shortening_of_bent: float = 0.03
    """How unsure such an end is, and by how much a body is shorter of which it is hidden."""
    end_widths: float = 1.5
    bend_rad: float = 0.8
    """How far from its ends, and from bends that turn by so much within a width, something beside
    an open body is no part of it: a midline that leaves out a short hairpin has a kink there."""
    least_dark_widths2: float = 0.4
    """Area that is dark from which on overlaps are darker."""
    dark_open_over_folded: float = 4.0
    """How many times that where a body does not lie near itself: debris on it is dark, too."""
    most_darkening: float = 0.7
    """What is darker than that is no overlap: the worm itself takes away part of the light."""
    least_darkening: float = 0.2
    """Darkening from which on overlaps are told by it."""
    drawing: StrandDrawingSettings = field(default_factory=StrandDrawingSettings)
    shade: BodyShadeSettings = field(default_factory=BodyShadeSettings)


@dataclass(frozen=True, eq=False)
class ObjectMasks:
    """An object that bodies are compared with; what all of them need of it is drawn once.

    Attributes
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, holes open; 0 or 255.
    dark : ndarray of uint8, shape (h, w), or None
        Where it is darker than one layer; None where overlaps are not known to be darker.
    width : float
        The body's, pixels.
    settings : BodyResidualSettings
    shaded : ShadedObject or None
        What one layer of the body looks like, place by place, where that is known.
    dirt : ndarray of uint8, shape (h, w), or None
        Not zero where dirt lies, which shows nothing of a body on it.
    """

    mask: Picture
    dark: Picture | None
    width: float
    settings: BodyResidualSettings
    shaded: ShadedObject | None = None
    dirt: Picture | None = None

    @property
    def rim(self) -> float:
        """How near to an edge object and body need not agree, pixels."""
        return max(self.settings.rim_widths * self.width, self.settings.least_rim_px)

    @cached_property
    def beyond(self) -> Image:
        """Where there is no object, not even by its rim."""
        return cv2.bitwise_not(_grown(self.mask, self.rim))

    @cached_property
    def beyond_dark(self) -> Image:
        """Where it is not dark, not even by a rim."""
        return cv2.bitwise_not(_grown(cast(Picture, self.dark), self.rim))

    def beside_dirt(self, mask: Image) -> Picture:
        """Return what of a mask lies on no dirt."""
        if self.dirt is not None:
            mask = cv2.bitwise_and(mask, cv2.bitwise_not(self.dirt))
        return np.asarray(mask, np.uint8)


@dataclass(frozen=True, eq=False)
class Unexplained:
    """What does not agree, the largest connected piece of each kind, in squared widths.

    Attributes
    ----------
    left_over : float
        Object where there is no body.
    in_water : float
        Body where there is no object.
    overlap : float
        Dark places under one strand, or two strands on each other in places that are not dark.
    agreement : float
        Intersection over union of body and object.
    wanted : ndarray of uint8, shape (h, w)
        Not zero where a part of the body is missing: objects left over, dark places under one
        strand.
    body : ndarray of uint8, shape (h, w)
        Where the body is; 0 or 255.
    seen : ObjectMasks
        The object.
    """

    left_over: float
    in_water: float
    overlap: float
    agreement: float
    wanted: Picture
    body: Picture
    seen: ObjectMasks

    @cached_property
    def near(self) -> Picture:
        """What of the object is near the body; not zero there."""
        near = cv2.bitwise_and(self.seen.mask, _grown(self.body, self.seen.rim))
        return np.asarray(near, np.uint8)

    @cached_property
    def beside(self) -> Picture:
        """Where the object lies beside the body, by more than a pixel; not zero there."""
        beyond = cv2.bitwise_not(_grown(self.body, 1.0))
        return self.seen.beside_dirt(cv2.bitwise_and(self.seen.mask, beyond))

    @property
    def total(self) -> float:
        """All of it."""
        return self.left_over + self.in_water + self.overlap

    def centroid(self, *, is_marked: bool) -> complex:
        """Return that of the body's area, u + iv in the masks' coordinates.

        The object's near the body; of a skin with marks the body's own, as it is drawn: the object
        is narrower where the skin is pale, which moves the centroid by up to a width and a half.
        """
        return complex(*mask_centroid(self.body if is_marked else self.near))

    def over_limits(self, width: float, settings: BodyResidualSettings) -> float:
        """Return how many times what may be left over is, for a body of some width in pixels."""
        water = settings.most_in_water_px2 / width**2
        return max(
            self.left_over / settings.most_left_over,
            self.in_water / max(settings.most_left_over, water),
            self.overlap / settings.most_overlap,
        )

    def wants_near(self, points: Floats, distance: float) -> bool:
        """Tell whether something is missing as near as this to one of some points (n, 2)."""
        return any(self.missing_px2(point, distance) > 0 for point in points)

    def missing_px2(self, point: Floats, distance: float) -> int:
        """Return the area in which body is missing as near as this to a point (2,), pixels."""
        return px2_near(self.wanted, point, distance)


def px2_near(mask: Picture, point: Floats, distance: float) -> int:
    """Return how many pixels of a mask are as near as this to a point (2,)."""
    u, v = point.tolist()
    part = part_near(point, distance)
    rows, columns = np.nonzero(mask[part])
    away = np.hypot(columns + part[1].start - u, rows + part[0].start - v)
    return int((away < distance).sum())


def part_near(point: Floats, distance: float) -> tuple[slice, slice]:
    """Return rows and columns of a mask that hold all that is as near as this to a point (2,)."""
    u, v = point.tolist()
    u0, v0 = max(floor(u - distance), 0), max(floor(v - distance), 0)
    u1, v1 = max(ceil(u + distance), 0), max(ceil(v + distance), 0)
    return slice(v0, v1 + 1), slice(u0, u1 + 1)


def ends_and_bends(points: Floats, width: float, settings: BodyResidualSettings) -> Floats:
    """Return the points (n, 2) of a body beside which what is left over may be a part of it."""
    return np.concatenate([points[[0, -1]], sharp_turns(points, width, settings.bend_rad)])


def unexplained(seen: ObjectMasks, points: Floats, widths: Floats) -> Unexplained:
    """Compare a body with the object that it is to be.

    Parameters
    ----------
    seen : ObjectMasks
    points : ndarray, shape (n, 2)
        The midline in the masks' coordinates.
    widths : ndarray, shape (n,)
    """
    mask, dark, rim = seen.mask, seen.dark, seen.rim
    drawing = seen.settings.drawing
    body, twice, layered, _ = drawn_strands(mask.shape, points, widths, seen.width, drawing)
    left_over = seen.beside_dirt(cv2.bitwise_and(mask, cv2.bitwise_not(_grown(body, rim))))
    wanted: Image = left_over
    in_water = cv2.bitwise_and(body, seen.beyond)
    overlap = 0.0
    if dark is not None:
        once = seen.beside_dirt(cv2.bitwise_not(_grown(twice, 1.5 * rim)))
        layered = seen.beside_dirt(_shrunk(layered, rim))
        single = cv2.bitwise_and(dark, once)
        wanted = cv2.bitwise_or(wanted, single)
        if seen.shaded is not None:
            overlap = misjudged_layers(
                seen.shaded, points, widths, once, layered, seen.settings.shade
            )
        else:
            pale = cv2.bitwise_and(layered, seen.beyond_dark)
            overlap = _largest_area(_shrunk(single, rim)) + _largest_area(pale)
    scale = seen.width**-2
    return Unexplained(
        _largest_area(left_over, without_specks=True) * scale,
        _largest_area(in_water, without_specks=True) * scale,
        overlap * scale,
        cv2.countNonZero(mask & body) / max(cv2.countNonZero(mask | body), 1),
        np.asarray(wanted, np.uint8),
        body,
        seen,
    )


def dark_places(
    signal: Picture, level: float, darkening: float, settings: BodyResidualSettings
) -> Picture:
    """Return where a signal is that of two layers rather than of one; 0 or 255."""
    threshold = level * (1 + settings.dark_over_darkening * darkening)
    _, dark = cv2.threshold(signal, threshold, 255, cv2.THRESH_BINARY)
    return np.asarray(dark, np.uint8)


@cache
def _kernel(half: int) -> NDArray[np.uint8]:
    size = 2 * half + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)), np.uint8)


def _grown(mask: Image, radius: float) -> Image:
    return cv2.dilate(mask, _kernel(max(1, round(radius))))


def _shrunk(mask: Image, radius: float) -> Image:
    return cv2.erode(mask, _kernel(max(1, round(radius))))


def _largest_area(mask: Image, *, without_specks: bool = False) -> float:
    """Return the area of the largest connected piece of a mask, pixels.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
    without_specks : bool
        Leave out what is one pixel thin.
    """
    part = occupied_part(np.asarray(mask, np.uint8))
    shown: Image = part
    if without_specks:
        shown = cv2.morphologyEx(part, cv2.MORPH_OPEN, _SPECK)
    outlines, _ = cv2.findContours(shown, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    boxes = sorted(map(cv2.boundingRect, outlines), key=lambda box: -box[2] * box[3])
    largest = 0.0
    for u, v, w, h in boxes:
        if w * h <= largest:
            break
        piece = shown[v : v + h, u : u + w]
        _, _, stats, _ = cv2.connectedComponentsWithStats(piece, connectivity=8)
        largest = max(largest, float(stats[1:, cv2.CC_STAT_AREA].max()))
    return largest
