"""Carries a midline on to the next picture, where the outline gives none: slid, else fitted."""

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.status import Status
from worm_tracker.body_model import Known, end_displacement, mean_width
from worm_tracker.detection.detector import Sight
from worm_tracker.detection.object_mask import centroid_of, object_mask
from worm_tracker.midline.contour_midline import Floats, as_points
from worm_tracker.midline.deformable_fit import fit_body, overlap
from worm_tracker.midline.path import Trail, sharpest_turn, trail_of
from worm_tracker.midline.path_following import Slender, slide
from worm_tracker.midline.refine import Fine
from worm_tracker.observation import Observation

WAY_COST, STRETCH_COST = 0.3, 1.0
"""What moving an end by a length, and a unit of log stretch, take off a carried body's overlap."""
FREE_STRETCH = 0.05
"""Log of the length that costs nothing."""
LESS = 0.02
"""How much less than expected a body slid along itself may be worth before others are tried."""
EXPECTED = 0.95
"""What a body is expected to be worth that touches itself for the first time."""
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
    expected: float = EXPECTED

    @property
    def points(self) -> Floats:
        """The midline, shape (POINTS, 2)."""
        return self.trail.points

    def after(self, last: "Carried", offset: complex) -> "Carried":
        """Return it in the picture's coordinates, and with what is expected of the next one."""
        expected = max(self.worth, last.expected - FORGET)
        return Carried(self.trail.shifted(offset), self.worth, expected)


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
    scene, offset = _scene(sight, known, last, frames)
    found = scene.slid(scene.last)
    if found is not None and found.worth >= last.expected - LESS and not scene.leaps(found):
        return found.after(last, offset)
    starts = [scene.last.points]
    if before is not None:
        starts.append(2 * last.points - before - as_points(np.array([offset])))
    found = scene.best(found, starts, fine, offset)
    return found.after(last, offset)


def observed(sight: Sight, points: Floats, known: Known, confidence: float) -> Observation:
    """Return the observation of a carried midline; the centroid is that of what is seen."""
    u, v = centroid_of(sight)
    width = mean_width(known.widths)
    return Observation(Status.TRACKED, u, v, points, known.widths, confidence, width)


def slide_on(sight: Sight, known: Known, last: Carried) -> Carried | None:
    """Slide the worm's body along itself, and try nothing else; None where that leads nowhere.

    Parameters
    ----------
    sight : Sight
        The object.
    known : Known
        The worm.
    last : Carried
        Its midline a frame before, or a frame after.
    """
    scene, offset = _scene(sight, known, last, 1)
    found = scene.slid(scene.last)
    return None if found is None or scene.leaps(found) else found.after(last, offset)


def _scene(sight: Sight, known: Known, last: Carried, frames: int) -> "tuple[_Scene, complex]":
    """Return an object in its window, and the window's first pixel."""
    offset = complex(sight.window[1].start, sight.window[0].start)
    trail = last.trail.shifted(-offset)
    return _Scene(sight.signal, object_mask(sight), known, trail, frames), offset


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
        best = max(fitted, key=self.merit)
        sharper = self.slid(best.trail)
        if sharper is not None and sharper.worth >= best.worth - SHARP_LESS:
            best = sharper
        others = [best] if slid is None else [slid, best]
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
