"""Carries a midline on to the next picture, where the outline gives none: slid, else fitted."""

from dataclasses import dataclass
from math import log

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.body_fit import fit_body, overlap
from worm_tracker.finding import Sight
from worm_tracker.known import Known, end_displacement, length_of
from worm_tracker.outline import Floats
from worm_tracker.refinement import Fine, refine
from worm_tracker.segmentation import draw_blob
from worm_tracker.sliding import Slender, slide
from worm_tracker.trail import Trail

WAY_COST, STRETCH_COST = 0.3, 1.0
"""What moving an end by a length, and a unit of log stretch, take off a carried body's overlap."""
FREE_STRETCH = 0.05
"""Log of the length that costs nothing."""
GOOD_OVERLAP = 0.93
"""Overlap of a body slid along itself from which on nothing else is tried."""
LENGTH_RECALL = 0.05
"""How fast an unseen tip lets the length return to the known one."""
MOST_STRETCH = 0.15
"""Log of the length over the known one beyond which a sharper midline is not believed."""


@dataclass(frozen=True, eq=False, slots=True)
class Carried:
    """A midline carried on.

    Attributes
    ----------
    points : ndarray, shape (POINTS, 2)
        In the picture's coordinates, in the order of the last midline.
    overlap : float
        Intersection over union of body and object: what it is worth.
    trail : Trail or None
        The fine curve that carries it on from here; None where it was not found by sliding.
    """

    points: Floats
    overlap: float
    trail: Trail | None = None


def carry(
    sight: Sight,
    known: Known,
    trail: Trail,
    last: Floats,
    before: Floats | None,
    frames: int,
    fine: Fine | None,
) -> Carried:
    """Fit the worm's body to an object that touches itself, from where the body was.

    Parameters
    ----------
    sight : Sight
        The object.
    known : Known
        The worm.
    trail : Trail
        Where it was, as a fine curve, in the order of `last`.
    last, before : ndarray, shape (POINTS, 2)
        Its midline in the last picture that gave one, and in the one before that.
    frames : int
        How many frames ago the last one was, 1 for the next.
    fine : Fine or None
        A midline that the outline gave, and that cannot continue the last one: the better of both
        is taken.
    """
    offset = np.array([sight.window[1].start, sight.window[0].start], np.float64)
    mask = _mask(sight)
    slid = _slid(sight, mask, known, trail, frames)
    if (
        slid is not None
        and slid.overlap >= GOOD_OVERLAP
        and not known.leaps(slid.points, last, frames)
    ):
        return slid
    starts = [last - offset]
    if before is not None:
        starts.append(2 * last - before - offset)

    def merit(found: Carried) -> float:
        """Return the overlap, less what the ends' way and the length cost."""
        way = end_displacement(found.points, last) / known.length / frames
        stretch = abs(log(length_of(found.points) / known.length))
        return found.overlap - WAY_COST * way - STRETCH_COST * max(stretch - FREE_STRETCH, 0.0)

    fits = [fit_body(mask, start, known.widths, known.length) for start in starts]
    found = [Carried(fit.points + offset, fit.overlap) for fit in fits]
    best = max(found, key=merit)
    sharp = refine(sight.signal, (0, 0), best.points - offset, known.width)
    sharper = overlap(mask, sharp.points, sharp.widths)
    if (
        sharper >= best.overlap - 0.02
        and abs(log(length_of(sharp.points) / known.length)) < MOST_STRETCH
        and not known.leaps(sharp.points + offset, last, frames)
    ):
        best = Carried(sharp.points + offset, sharper)
    others = [best]
    if slid is not None:
        others.append(slid)
    if fine is not None:
        open_body = overlap(mask, fine.points - offset, fine.widths)
        others.append(Carried(fine.points, open_body))
    return max(others, key=merit)


def _slid(
    sight: Sight, mask: NDArray[np.uint8], known: Known, trail: Trail, frames: int
) -> Carried | None:
    """Return the body slid along itself."""
    offset = complex(sight.window[1].start, sight.window[0].start)
    expected = trail.length * (known.length / trail.length) ** LENGTH_RECALL
    body = Slender(known.widths, known.level, expected)
    slid = slide(sight.signal, trail.shifted(-offset), body, frames)
    if slid is None:
        return None
    worth = overlap(mask, slid.points, known.widths)
    slid = slid.shifted(offset)
    return Carried(slid.points, worth, slid)


def _mask(sight: Sight) -> NDArray[np.uint8]:
    """Return the object's pixels in its window, holes open."""
    _, above = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    return np.asarray(cv2.bitwise_and(draw_blob(sight.blob, sight.window), above), np.uint8)
