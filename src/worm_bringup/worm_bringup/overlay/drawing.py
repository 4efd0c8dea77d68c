"""Draws shapes over a picture, to a sixteenth of a pixel."""

from collections.abc import Iterable
from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_bringup.overlay.shapes import Circle, Polyline, Shapes, circle_points
from worm_msgs_py.arrays import Picture

_SHIFT = 4
"""OpenCV takes places in units of 2⁻⁴ px."""
_TEXT_AT, _TEXT_SIZE = (6, 18), 0.45
_FACE = cv2.FONT_HERSHEY_SIMPLEX


def draw_over(grey: Picture, shapes: Shapes) -> NDArray[np.uint8]:
    """Return the picture in colour with shapes over it.

    Parameters
    ----------
    grey : ndarray of uint8, shape (h, w)
    shapes : Shapes

    Returns
    -------
    ndarray of uint8, shape (h, w, 3)
        Blue, green, red.
    """
    picture = np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)
    for opacity, items in groupby(shapes.items, lambda item: item.ink.opacity):
        layer = picture if opacity == 1.0 else picture.copy()
        _draw_all(layer, items)
        if layer is not picture:
            blended = cv2.addWeighted(layer, opacity, picture, 1.0 - opacity, 0.0)
            picture = np.asarray(blended, np.uint8)
    if shapes.text:
        _write_text(picture, shapes.text)
    return picture


def _draw_all(picture: NDArray[np.uint8], items: Iterable[Polyline | Circle]) -> None:
    for item in items:
        red, green, blue = bytes.fromhex(item.ink.colour[1:])
        colour, thick = (blue, green, red), max(1, round(item.thick_px))
        closed = isinstance(item, Circle)  # OpenCV's own circles have corners of a pixel
        points = _in_sixteenths(circle_points(item) if isinstance(item, Circle) else item.points_px)
        if isinstance(item, Circle) and item.filled:
            cv2.fillPoly(picture, [points], colour, cv2.LINE_AA, _SHIFT)
        cv2.polylines(picture, [points], closed, colour, thick, cv2.LINE_AA, _SHIFT)


def _write_text(picture: NDArray[np.uint8], text: str) -> None:
    """Write white on black into the upper left corner."""
    (wide, high), below = cv2.getTextSize(text, _FACE, _TEXT_SIZE, 1)
    u, v = _TEXT_AT
    corners = (u - 4, v - high - 4), (u + wide + 4, v + below + 2)
    cv2.rectangle(picture, *corners, (0, 0, 0), cv2.FILLED)
    cv2.putText(picture, text, _TEXT_AT, _FACE, _TEXT_SIZE, (255, 255, 255), 1, cv2.LINE_AA)


def _in_sixteenths(places: NDArray[np.float64]) -> NDArray[np.int32]:
    return np.rint(places * (1 << _SHIFT)).astype(np.int32)
