"""Which end of a body is which, by its widths: the head is broader than the tail.

A body drawn the wrong way round covers its object less well, wherever it lies and however it is
folded. So each picture tells the order of the ends by itself, with no way there to go wrong.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.midline.curve import as_complex, as_points, tangents


@dataclass(frozen=True, slots=True)
class OrderSettings:
    """When widths tell which end is which."""

    least_difference: float = 0.02
    """Part of a body's area that it must not share with itself the other way round."""
    least_score: float = 0.4
    """Score from which on the widths tell the order. Of 6400 bodies that explain their picture and
    lie right (ten films of five worms), drawn the right way round all but two scored more, by half
    above 0.8; of 53 the wrong way round all but two less than -0.4."""
    least_score_of_part: float = 0.7
    """The same where a part may be passed the other way round, and only the rest counts. Of 923
    bodies with loops in doubt that scored more all were right, of 27 that scored 0.4 to 0.7 five
    were wrong (two films): what is in doubt told another order than the ends beside it."""


def order_score(
    mask: Picture,
    points: Floats,
    widths: Floats,
    settings: OrderSettings,
    in_doubt: tuple[float, float] | None = None,
) -> float:
    """Return by how much better a body covers its object than the other way round.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, not zero there.
    points : ndarray, shape (n, 2)
        The midline in the mask's coordinates.
    widths : ndarray, shape (n,)
        Along the body, as it has been learned.
    settings : OrderSettings
    in_doubt : tuple of float, or None
        The part of its length, from where to where, whose widths tell nothing of its ends: it may
        be passed the other way round.

    Returns
    -------
    float
        Difference of the two intersections over union with the object, over what it is for a body
        without a fault: 1 for the right order, -1 for the wrong one; 0 where the body is much the
        same both ways round.
    """
    turned = widths[::-1]
    if in_doubt is not None:
        part = np.linspace(0.0, 1.0, len(widths))
        untold = (part >= in_doubt[0]) & (part <= in_doubt[1])
        between = (widths + turned) / 2
        widths, turned = np.where(untold, between, widths), np.where(untold, between, turned)
    one, other = (area_of_body(mask.shape, points, along) for along in (widths, turned))
    difference = 1 - intersection_over_union(one, other)
    if difference < settings.least_difference:
        return 0.0
    return (intersection_over_union(mask, one) - intersection_over_union(mask, other)) / difference


def score_of_widths(widths: Floats, known: Floats, settings: OrderSettings) -> float:
    """Return by how much better an open body's widths agree with those known than turned round.

    Parameters
    ----------
    widths, known : ndarray, shape (n,)
        As measured in a picture, and as they have been learned.
    settings : OrderSettings

    Returns
    -------
    float
        As `order_score` does.
    """
    difference = float(abs(known - known[::-1]).sum())
    least = 2 * settings.least_difference * float(known.sum())  # measured widths scatter more
    if difference < least:
        return 0.0
    return float(abs(widths[::-1] - known).sum() - abs(widths - known).sum()) / difference


def intersection_over_union(one: Picture, other: Picture) -> float:
    """Return that of two masks, 0 to 1."""
    common = cv2.countNonZero(cv2.bitwise_and(one, other))
    return common / max(cv2.countNonZero(cv2.bitwise_or(one, other)), 1)


def area_of_body(shape: tuple[int, ...], points: Floats, widths: Floats) -> Picture:
    """Draw a body; 0 or 255."""
    line = as_complex(points)
    side = 0.5j * tangents(line) * np.maximum(widths, 1.0)
    left, right = as_points(line + side), as_points(line - side)
    corners = np.stack([left[:-1], left[1:], right[1:], right[:-1]], axis=1)
    drawn = np.zeros(shape, np.uint8)
    for quad in np.rint(16 * corners).astype(np.int32):
        cv2.fillConvexPoly(drawn, quad, 255, cv2.LINE_8, 4)
    return drawn
