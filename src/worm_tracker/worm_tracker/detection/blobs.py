"""From the signal (background minus picture) to the one connected object that is the worm."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.intervals import SD_OF_MAD
from worm_tracker.midline.curve import transformed_points
from worm_tracker.midline.occupied_part import occupied_part

Window = tuple[slice, slice]
"""Rows and columns of a part of the picture."""


@dataclass(frozen=True, slots=True)
class BlobSettings:
    """What counts as an object."""

    threshold_over_body: float = 0.4
    """Signal, over that on the midline, of what is cut out as object: below the half-height, so
    that all of the edge is in it."""
    threshold_over_noise: float = 4.0
    """The same over the noise: four standard deviations."""
    least_threshold_grey: float = 4.0
    """The same in grey levels, before a worm has been seen: those of a picture are whole."""
    least_area_px2: float = 30.0
    """Smaller objects are noise, or dust."""
    least_hole_px2: float = 4.0
    """Smaller holes are noise, and no loop."""
    least_thickness_over_worm: float = 0.65
    least_area_over_thickness2: float = 3.0
    """What is at least as thick, and as long, may be a part of a worm: a bubble is as long as it is
    thick, a fibre thinner."""
    most_log_area_ratio_of_one_worm: float = 0.3
    """Log of the ratio of two areas that may be one worm's at two times."""


@dataclass(frozen=True, eq=False, slots=True)
class Blob:
    """One connected object.

    Attributes
    ----------
    contour : ndarray of int32, shape (n, 2)
        Outer pixels (u, v) in the whole picture's coordinates, in order.
    area : float
        Pixels, holes taken off.
    hole_area : float
        Pixels of the holes.
    u, v : float
        Centroid of the area.
    box : (int, int, int, int)
        First and last (u, v): u0, v0, u1, v1.
    """

    contour: NDArray[np.int32]
    area: float
    hole_area: float
    u: float
    v: float
    box: tuple[int, int, int, int]

    def touches(self, window: Window, margin: int = 1) -> bool:
        """Tell whether the object reaches the edge of a window."""
        u0, v0, u1, v1 = self.box
        return bool(
            u0 < window[1].start + margin
            or v0 < window[0].start + margin
            or u1 >= window[1].stop - margin
            or v1 >= window[0].stop - margin
        )

    def near(self, window: Window, margin: int) -> bool:
        """Tell whether any of the object, widened by a margin, may lie in a window."""
        u0, v0, u1, v1 = self.box
        return bool(
            u0 < window[1].stop + margin
            and v0 < window[0].stop + margin
            and u1 >= window[1].start - margin
            and v1 >= window[0].start - margin
        )

    def transformed(self, motion: Floats) -> "Blob":
        """Return the object where an affine map (2, 3) takes it."""
        contour = np.rint(transformed_points(self.contour, motion)).astype(np.int32)
        (u, v), *_ = transformed_points(np.array([[self.u, self.v]]), motion)
        u0, v0, width, height = cv2.boundingRect(contour)
        box = (u0, v0, u0 + width - 1, v0 + height - 1)
        return replace(self, contour=contour, u=float(u), v=float(v), box=box)


def whole_picture(shape: tuple[int, ...]) -> Window:
    """Return the window that holds all of a picture."""
    return slice(0, shape[0]), slice(0, shape[1])


def around_all(windows: Sequence[Window]) -> Window:
    """Return the smallest window that holds some windows."""
    rows, columns = (
        slice(min(part.start for part in parts), max(part.stop for part in parts))
        for parts in zip(*windows, strict=True)
    )
    return rows, columns


def window_origin(window: Window) -> tuple[int, int]:
    """Return (u, v) of a window's first pixel."""
    return window[1].start, window[0].start


def window_around(box: tuple[int, int, int, int], margin: int, shape: tuple[int, ...]) -> Window:
    """Return the window of a box (u0, v0, u1, v1), widened by a margin and cut to the picture."""
    u0, v0 = max(0, box[0] - margin), max(0, box[1] - margin)
    u1, v1 = min(shape[1], box[2] + margin + 1), min(shape[0], box[3] + margin + 1)
    return slice(v0, max(v1, v0 + 1)), slice(u0, max(u1, u0 + 1))


def find_blobs(
    signal: Picture, threshold: float, window: Window, settings: BlobSettings
) -> list[Blob]:
    """Find the connected objects above a threshold, the largest first.

    Parameters
    ----------
    signal : ndarray of uint8
        The signal in the window, smoothed.
    threshold : float
        Grey levels.
    window : Window
        Where in the picture the signal lies.
    settings : BlobSettings
    """
    if threshold >= 255:
        return []
    _, mask = cv2.threshold(signal, threshold, 255, cv2.THRESH_BINARY)
    contours, tree = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    blobs = []
    offset = np.array([window[1].start, window[0].start], np.int32)
    for k, contour in enumerate(contours):
        if tree[0][k][3] >= 0 or len(contour) < 8:
            continue
        moments = cv2.moments(contour)
        # The polygon runs through pixel centres: half a pixel all round is missing from its area.
        area = moments["m00"] + len(contour) / 2 + 1
        if area < settings.least_area_px2 or moments["m00"] <= 0:
            continue
        holes = _hole_area(contours, tree[0], k, settings.least_hole_px2)
        u, v = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
        shifted = np.asarray(contour[:, 0, :] + offset, np.int32)
        u0, v0, width, height = cv2.boundingRect(shifted)
        box = (u0, v0, u0 + width - 1, v0 + height - 1)
        at = (float(u + offset[0]), float(v + offset[1]))
        blobs.append(Blob(shifted, area - holes, holes, *at, box))
    return sorted(blobs, key=lambda blob: -blob.area)


def draw_blob(blob: Blob, window: Window, widen: int = 0) -> Picture:
    """Return a mask of the object in a window, its holes filled, widened by some pixels."""
    mask = np.zeros((window[0].stop - window[0].start, window[1].stop - window[1].start), np.uint8)
    offset = (-window[1].start, -window[0].start)
    # Where it is widened by more than that, the corners of a coarser contour do not show.
    coarse = [np.ascontiguousarray(blob.contour[:: max(1, widen - 1), None, :])]
    cv2.drawContours(mask, coarse, -1, 255, cv2.FILLED, offset=offset)
    if widen:
        cv2.drawContours(mask, coarse, -1, 255, 2 * widen + 1, offset=offset)
    return mask


def most_likely_worm(
    blobs: list[Blob], area: float, u: float, v: float, reach: float
) -> Blob | None:
    """Return the object that continues the worm seen last; None where nothing is there.

    Parameters
    ----------
    blobs : list of Blob
    area : float
        Area of the worm so far; 0 where it is not known yet.
    u, v, reach : float
        Where it was, and how far it can have got: a penalty grows with the distance.
    """
    best, least = None, float("inf")
    for blob in blobs:
        distance = 0.0 if reach <= 0 else float(np.hypot(blob.u - u, blob.v - v)) / reach
        size = abs(np.log(max(blob.area, 1.0) / area)) if area > 0 else -np.log(blob.area)
        if size + distance < least:
            best, least = blob, size + distance
    return best


def several_of_area(blobs: list[Blob], area: float, settings: BlobSettings) -> bool:
    """Tell whether several objects have the worm's area (False where that is 0, not known)."""
    most = settings.most_log_area_ratio_of_one_worm
    return sum(abs(log(blob.area / area)) < most for blob in blobs) > 1 if area > 0 else False


def thickness(mask: Picture) -> float:
    """Return the width of what is thickest in a mask, at least 3 pixels."""
    away = cv2.distanceTransform(occupied_part(mask), cv2.DIST_L2, 5)
    return max(2 * float(away.max()) - 1, 3.0)


def holds_wormlike_piece(mask: Picture, width: float, settings: BlobSettings) -> bool:
    """Tell whether a piece of an object is long, and as thick as a worm: debris hardly is both.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The pieces, not zero there.
    width : float
        The worm's, pixels.
    settings : BlobSettings
    """
    least = settings.least_thickness_over_worm * width
    if cv2.countNonZero(mask) < settings.least_area_over_thickness2 * least**2:
        return False
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * round(least / 2) + 1,) * 2)
    thick = cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel)
    count, labels = cv2.connectedComponents(thick)
    for k in range(1, count):
        piece = np.asarray(np.pad(labels == k, 1).view(np.uint8) * 255, np.uint8)
        longest = settings.least_area_over_thickness2 * thickness(piece) ** 2
        if cv2.countNonZero(piece) > longest:
            return True
    return False


def smoothed(signal: Picture) -> Picture:
    """Return the signal with the noise of single pixels taken off."""
    return np.asarray(cv2.GaussianBlur(signal, (3, 3), 0), np.uint8)


def noise_sd(signal: NDArray[np.int16]) -> float:
    """Return the robust standard deviation of a signal that is mostly noise about zero."""
    sparse = signal.ravel()[:: max(1, signal.size // 20000)].astype(np.float64)
    return max(SD_OF_MAD * float(np.median(np.abs(sparse - np.median(sparse)))), 0.5)


def first_threshold(signal: Picture, noise: float, settings: BlobSettings) -> float:
    """Return the signal's level between noise and worm, by Otsu's method above the noise.

    Infinity where nothing stands out.
    """
    least = max(settings.threshold_over_noise * noise, settings.least_threshold_grey)
    above = signal[signal > least]
    if len(above) < settings.least_area_px2:
        return float("inf")
    otsu, _ = cv2.threshold(above.reshape(1, -1), 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    body = float(np.median(above[above > otsu])) if (above > otsu).any() else float(otsu)
    return max(settings.threshold_over_body * body, least)


def _hole_area(contours: object, tree: NDArray[np.int32], k: int, least: float) -> float:
    """Return the area of the holes in one outer contour."""
    total, child = 0.0, int(tree[k][2])
    while child >= 0:
        hole = contours[child]  # type: ignore[index]
        # A hole's contour runs through the pixels around it.
        area = cv2.contourArea(hole) - len(hole) / 2 + 1
        total += area if area >= least else 0.0
        child = int(tree[child][0])
    return total
