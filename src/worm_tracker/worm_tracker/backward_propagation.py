"""Gives frames without a midline one from the frames after: a worm that opens tells how it lay.

Where a body cannot be followed into a coil, or the film begins with one, the midline is carried
backwards in time from the first frame that has one again.
"""

from collections.abc import Iterator, Sequence

from worm_tracker.body_model import Known
from worm_tracker.detection.detector import Sight
from worm_tracker.midline.contour_midline import Floats
from worm_tracker.midline.path import trail_of
from worm_tracker.observation import Observation
from worm_tracker.propagation import Carried, carry, observed, slide_on

LEAST_WORTH = 0.75
"""What a midline that was carried backwards must be worth."""
MOST_LOST = 0.04
"""How much less than the one after it may be worth."""
MOST_FITS = 12
"""Pictures in which a body may be fitted that does not slide there: many would take too long."""


def carried_back(
    known: Known, opened: Observation, sights: Sequence[Sight]
) -> Iterator[Observation]:
    """Carry a midline back through the pictures before it.

    Parameters
    ----------
    known : Known
        The worm.
    opened : Observation
        The frame that has a midline, in the order of what is known of the worm.
    sights : sequence of Sight
        The object in the pictures before, the latest first.

    Yields
    ------
    Observation
        For each of these pictures, until the body no longer explains the object.
    """
    last = Carried(trail_of(opened.points, None, known.width), opened.confidence, opened.confidence)
    before: Floats | None = None
    fits = 0
    for sight in sights:
        found = slide_on(sight, known, last)
        if (found is None or found.worth < last.expected - MOST_LOST) and fits < MOST_FITS:
            fits += 1
            found = carry(sight, known, last, before, 1, None)
        if found is None or found.worth < max(LEAST_WORTH, last.expected - MOST_LOST):
            return
        yield observed(sight, found.points, known, found.worth)
        before, last = last.points, found
