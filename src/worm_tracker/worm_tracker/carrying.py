"""Carries a midline on to the next picture, where the outline gives none: slid, else fitted."""

from dataclasses import dataclass
from math import log

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.body_fit import fit_body, overlap
from worm_tracker.finding import Sight
from worm_tracker.known import Known, end_displacement
from worm_tracker.outline import Floats, as_points
from worm_tracker.refinement import Fine
from worm_tracker.segmentation import draw_blob
from worm_tracker.sliding import Slender, slide
from worm_tracker.trail import Trail, sharpest_turn, trail_of

WAY_COST, STRETCH_COST = 0.3, 1.0
"""What moving an end by a length, and a unit of log stretch, take off a carried body's overlap."""
FREE_STRETCH = 0.05
"""Log of the length that costs nothing."""
LESS = 0.02
"""How much less than expected a body slid along itself may be worth before others are tried."""
FORGET = 0.005
"""What the expected worth loses in a frame."""
SHARP_LESS = 0.02
"""How much less a body below a pixel may be worth than the fitted one that it was made of."""
MOST_TURN, KINK_COST = 2.0, 0.15
"""Turn over a width (radians) beyond which a midline has a kink, and what a radian more takes off:
half a turn in a width is that of a body laid double."""
LENGTH_RECALL = 0.05
"""How fast an unseen tip lets the length return to the known one."""


@dataclass(frozen=True, eq=False, slots=True)
class Carried:
    """A midline carried on.

    Attributes
    ----------
    trail : Trail
        The midline, in the picture's coordinates and in the order of the last one.
    worth : float
        Intersection over union of body and object, less what its kinks cost.
    expected : float
        What the next one should be worth: it falls slowly where this one was worth more.
    """

    trail: Trail
    worth: float
    expected: float = 1.0

    @property
    def points(self) -> Floats:
        """The midline, shape (POINTS, 2)."""
        return self.trail.points


def carry(
    sight: Sight,
    known: Known,
    last: Carried,
    before: Floats | None,
    frames: int,
    fine: Fine | None,
) -> Carried:
    """Carry the worm's body on to an object that touches itself, from where the body was.

    Parameters
    ----------
    sight : Sight
        The object.
    known : Known
        The worm.
    last : Carried
        Its midline in the last picture that gave one.
    before : ndarray, shape (POINTS, 2), or None
        That in the one before, in the same order.
    frames : int
        How many frames ago that was, 1 for the next.
    fine : Fine or None
        A midline that the outline gave, and that cannot continue the last one: the better of both
        is taken.

    Notes
    -----
    Where the body, slid along itself, explains the object about as well as it did before, nothing
    else is tried. Else a deformable body is fitted from there, and slid once more where it was
    found, which brings it below a pixel.
    """
    offset = complex(sight.window[1].start, sight.window[0].start)
    scene = _Scene(sight.signal, _mask(sight), known, last.trail.shifted(-offset), frames)
    found = scene.slid(scene.last)
    if found is None or found.worth < last.expected - LESS or scene.leaps(found):
        starts = [scene.last.points]
        if before is not None:
            starts.append(2 * last.points - before - as_points(np.array([offset])))
        found = scene.best(found, starts, fine, offset)
    expected = max(found.worth, last.expected - FORGET)
    return Carried(found.trail.shifted(offset), found.worth, expected)


@dataclass(frozen=True, eq=False, slots=True)
class _Scene:
    """An object in its window, and the worm that is to explain it."""

    signal: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    known: Known
    last: Trail
    frames: int

    def slid(self, trail: Trail) -> Carried | None:
        """Return a body slid along itself."""
        known = self.known
        length = trail.length * (known.length / trail.length) ** LENGTH_RECALL
        slid = slide(self.signal, trail, Slender(known.widths, known.level, length), self.frames)
        return None if slid is None else self.judged(slid, known.widths)

    def best(
        self, slid: Carried | None, starts: list[Floats], fine: Fine | None, offset: complex
    ) -> Carried:
        """Return the best of all that can be tried, fits from some starts among them."""
        known = self.known
        starts = starts if slid is None else [*starts, slid.points]
        fits = [fit_body(self.mask, start, known.widths, known.length) for start in starts]
        fitted = [
            self.judged(trail_of(fit.points, None, known.width), known.widths) for fit in fits
        ]
        others = [max(fitted, key=self.merit)]
        sharper = self.slid(others[0].trail)
        if sharper is not None and sharper.worth >= others[0].worth - SHARP_LESS:
            others = [sharper]
        if slid is not None:
            others.append(slid)
        if fine is not None:
            trail = trail_of(fine.points, None, known.width).shifted(-offset)
            others.append(self.judged(trail, fine.widths))
        return max(others, key=self.merit)

    def judged(self, trail: Trail, widths: Floats) -> Carried:
        """Return a body with what it is worth."""
        kink = max(sharpest_turn(trail, self.known.width) - MOST_TURN, 0.0)
        return Carried(trail, overlap(self.mask, trail.points, widths) - KINK_COST * kink)

    def merit(self, found: Carried) -> float:
        """Return the overlap, less what the ends' way and the length cost."""
        known = self.known
        way = end_displacement(found.points, self.last.points) / known.length / self.frames
        stretch = abs(log(found.trail.length / known.length))
        return found.worth - WAY_COST * way - STRETCH_COST * max(stretch - FREE_STRETCH, 0.0)

    def leaps(self, found: Carried) -> bool:
        """Tell whether an end is farther from where it was than it can have got."""
        return self.known.leaps(found.points, self.last.points, self.frames)


def centroid_of(sight: Sight) -> tuple[float, float]:
    """Return the centroid (u, v) of an object's pixels, holes left out."""
    moments = cv2.moments(_mask(sight), binaryImage=True)
    area = max(moments["m00"], 1.0)
    u, v = moments["m10"] / area, moments["m01"] / area
    return u + sight.window[1].start, v + sight.window[0].start


def _mask(sight: Sight) -> NDArray[np.uint8]:
    """Return the object's pixels in its window, holes open."""
    _, above = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    return np.asarray(cv2.bitwise_and(draw_blob(sight.blob, sight.window), above), np.uint8)
