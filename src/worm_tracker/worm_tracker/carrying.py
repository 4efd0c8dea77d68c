"""Carries a midline on to the next picture as a deformable body, where the outline gives none."""

from math import log

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.body_fit import Fit, fit_body, overlap
from worm_tracker.finding import Sight
from worm_tracker.known import Known, end_displacement, length_of, nearer_turned
from worm_tracker.outline import Floats
from worm_tracker.refinement import Fine, refine
from worm_tracker.segmentation import draw_blob

WAY_COST, STRETCH_COST = 0.3, 1.0
"""What moving an end by a length, and a unit of log stretch, take off a carried body's overlap."""
FREE_STRETCH = 0.05
"""Log of the length that costs nothing."""
MOST_STRETCH = 0.15
"""Log of the length over the known one beyond which a sharper midline is not believed."""


def carry(
    sight: Sight,
    known: Known,
    last: Floats,
    before: Floats | None,
    frames: int,
    fine: Fine | None,
) -> Fit:
    """Fit the worm's body to an object that touches itself, from where the body was.

    Parameters
    ----------
    sight : Sight
        The object.
    known : Known
        The worm.
    last, before : ndarray, shape (POINTS, 2)
        Its midline in the last picture that gave one, and in the one before that.
    frames : int
        How many frames ago the last one was, 1 for the next.
    fine : Fine or None
        A midline that the outline gave, and that cannot continue the last one: the better of both
        is taken.

    Returns
    -------
    Fit
        In the picture's coordinates; its overlap tells what it is worth.
    """
    offset = np.array([sight.window[1].start, sight.window[0].start], np.float64)
    mask = _mask(sight)
    starts = [last - offset]
    if before is not None:
        if nearer_turned(before, last):
            before = before[::-1]
        starts.append(2 * last - before - offset)

    def merit(fit: Fit) -> float:
        """Return the overlap, less what the ends' way and the length cost."""
        way = end_displacement(fit.points + offset, last) / known.length / frames
        stretch = abs(log(length_of(fit.points) / known.length))
        return fit.overlap - WAY_COST * way - STRETCH_COST * max(stretch - FREE_STRETCH, 0.0)

    fits = [fit_body(mask, start, known.widths, known.length) for start in starts]
    best = max(fits, key=merit)
    sharp = refine(sight.signal, (0, 0), best.points, known.width)
    sharper = overlap(mask, sharp.points, sharp.widths)
    if (
        sharper >= best.overlap - 0.02
        and abs(log(length_of(sharp.points) / known.length)) < MOST_STRETCH
        and not known.leaps(sharp.points + offset, last, frames)
    ):
        best = Fit(sharp.points, sharper)
    if fine is not None:
        points = fine.points - offset
        open_body = Fit(points, overlap(mask, points, fine.widths))
        best = max(best, open_body, key=merit)
    return Fit(best.points + offset, best.overlap)


def _mask(sight: Sight) -> NDArray[np.uint8]:
    """Return the object's pixels in its window, holes open."""
    _, above = cv2.threshold(sight.smooth, sight.threshold, 255, cv2.THRESH_BINARY)
    return np.asarray(cv2.bitwise_and(draw_blob(sight.blob, sight.window), above), np.uint8)
