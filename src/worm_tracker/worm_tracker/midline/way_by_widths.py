"""Which way round a loop of a body is passed, by its widths: an end is thinner than its middle.

A loop passed the other way round covers much the same of the picture, but for the taper of the ends
that lie in it: where a thin tail goes on as a strand of full width, the other strand thins.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.midline.order_by_widths import area_of_body, intersection_over_union
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.strand_exchange import loops_otherwise
from worm_tracker.midline.strand_meetings import StrandExchangeSettings


@dataclass(frozen=True, slots=True)
class WayByWidthsSettings:
    """When widths tell which way round a loop is passed."""

    least_difference: float = 0.05
    """Part of a body's area that it must not share with itself where the loop is passed the other
    way."""
    most_score_of_wrong: float = 0.25
    """Score below which a loop may be passed the other way, which is slid and compared then. Of 582
    loops of six films that differ so much 7 that were passed right scored less, of 15 passed wrong
    all but one; of 59 passed wrong by a real worm all but seven."""
    least_score: float = 0.4
    """By how much the other way must cover the object better once it has been slid: half of what a
    body without a fault would."""


def score_of_way(
    mask: Picture, one: Picture, other: Picture, settings: WayByWidthsSettings
) -> float | None:
    """Return by how much better one way of a body covers its object than another.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, not zero there.
    one, other : ndarray of uint8, shape (h, w)
        The body's area either way, as `area_of_body` draws it.
    settings : WayByWidthsSettings

    Returns
    -------
    float or None
        Difference of the two intersections over union with the object, over what it is for a body
        without a fault; None where both ways are much the same.
    """
    difference = 1 - intersection_over_union(one, other)
    if difference < settings.least_difference:
        return None
    gain = intersection_over_union(mask, one) - intersection_over_union(mask, other)
    return gain / difference


def loops_by_widths(
    mask: Picture,
    path: BodyPath,
    widths: Floats,
    width: float,
    exchange: StrandExchangeSettings,
    least_breadth_widths: float,
    settings: WayByWidthsSettings,
) -> Iterator[tuple[float, BodyPath]]:
    """Yield the score of each loop against the other way past it, and the body that goes there.

    Of those broader than so many widths and of which widths tell something.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, not zero there.
    path : BodyPath
        In the mask's coordinates.
    widths : ndarray, shape (n,)
        Along the body, as it has been learned.
    width : float
        The body's, pixels.
    exchange : StrandExchangeSettings
    least_breadth_widths : float
    settings : WayByWidthsSettings
    """
    loops = loops_otherwise(path, width, exchange, least_breadth_widths)
    area = area_of_body(mask.shape, path.points, widths) if loops else mask
    for _, otherwise in loops:
        area_otherwise = area_of_body(mask.shape, otherwise.points, widths)
        score = score_of_way(mask, area, area_otherwise, settings)
        if score is not None:
            yield score, otherwise
