"""What one picture shows of the worm: which object it is, and where; or why there is none."""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats, Mask, Picture
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.blobs import (
    Blob,
    BlobSettings,
    Window,
    draw_blob,
    find_blobs,
    thickness,
    window_around,
    window_origin,
)
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.mask_centroid import mask_centroid

_RIM_PX = 2
"""What belongs to the edge of an object: its blur."""


@dataclass(frozen=True, eq=False, slots=True)
class DetectionPrior:
    """What is known of the worm before a picture is looked at.

    Attributes
    ----------
    model : BodyModel or None
        What its body is like.
    blob : Blob or None
        The object that it was in the last picture; None where it was not seen.
    body : ndarray, shape (TRACKED_POINTS, 2), or None
        Its last midline, as long as it has not been out of view.
    may_be_in_part : bool
        Whether what is known of it may be a part of it, or the worm laid double.
    """

    model: BodyModel | None = None
    blob: Blob | None = None
    body: Floats | None = None
    may_be_in_part: bool = False

    @property
    def area(self) -> float:
        """The worm's area, square pixels; 0 where it is not known."""
        return self.model.area if self.model else 0.0


@dataclass(frozen=True, slots=True)
class Missed:
    """A picture in which no worm was found.

    Attributes
    ----------
    status : Status
        Why.
    gain : float
        The picture's brightness over the background's.
    """

    status: Status
    gain: float


@dataclass(frozen=True, eq=False, slots=True)
class Occlusion:
    """Where a part of the body was occluded.

    Attributes
    ----------
    ends : ndarray, shape (2, 2)
        The first and the last point (u, v) of the body that is seen, in the picture's coordinates.
    occluded_ends : tuple of bool
        Whether the body goes on there, unseen.
    """

    ends: Floats
    occluded_ends: tuple[bool, bool]


@dataclass(frozen=True, eq=False, slots=True)
class SignalView:
    """How much darker than the background a window of a picture is.

    Attributes
    ----------
    window : Window
        Where in the picture the rest lies.
    signal, smooth : ndarray of uint8
        Background minus picture in the window, as it is and without the noise of single pixels.
    threshold : float
        Of `smooth`: what lies above is object.
    gain : float
        The picture's brightness over the background's.
    settings : BlobSettings
        What counts as an object.
    noise : float
        Standard deviation of a pixel of `signal`, grey levels.
    raised : ndarray of uint8 or None
        `smooth`, made stronger where an end is paler than the threshold: objects are found in it.
        None where there is no such end.
    dim : ndarray of uint8 or None
        Not zero where dirt was known to make the background dim; None where there was none.
    """

    window: Window
    signal: Picture
    smooth: Picture
    threshold: float
    gain: float
    settings: BlobSettings
    noise: float = 0.0
    raised: Picture | None = None
    dim: Picture | None = None

    @property
    def found_in(self) -> Picture:
        """What objects are found in: `smooth`, or what it was raised to."""
        return self.smooth if self.raised is None else self.raised

    def blobs(self) -> list[Blob]:
        """Return the objects, in the picture's coordinates, the largest first."""
        return find_blobs(self.found_in, self.threshold, self.window, self.settings)

    @property
    def origin(self) -> tuple[int, int]:
        """(u, v) of the window's first pixel."""
        return window_origin(self.window)

    def in_window(self, points: Floats) -> Floats:
        """Return points (n, 2) of the picture in the window's coordinates."""
        return np.asarray(points - np.array(self.origin))

    def in_picture(self, points: Floats) -> Floats:
        """Return points (n, 2) of the window in the picture's coordinates."""
        return np.asarray(points + np.array(self.origin))

    def above_threshold(self) -> Picture:
        """Return what stands out in the window; 0 or 255."""
        _, above = cv2.threshold(self.found_in, self.threshold, 255, cv2.THRESH_BINARY)
        return np.asarray(above, np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class Detection:
    """The worm in one picture, and its surroundings.

    Attributes
    ----------
    view : SignalView
        The window that it was found in.
    blob : Blob
        The object that is the worm, in the picture's coordinates.
    crowded : bool
        Whether there are other objects, or the worm is larger than it was.
    occlusion : Occlusion or None
        Where a part of the worm is occluded; the view then shows it as it is supposed to be.
    occluder : ndarray of uint8, or None
        Not zero where glare leaves the body's width untold; None where there is none near it.
    dirt : ndarray of uint8, or None
        Not zero where dirt lies by what is known since; None where nothing is known since.
    """

    view: SignalView
    blob: Blob
    crowded: bool = False
    occlusion: Occlusion | None = None
    occluder: Picture | None = None
    dirt: Picture | None = None

    @property
    def gain(self) -> float:
        """The picture's brightness over the background's."""
        return self.view.gain

    @property
    def dirt_in_window(self) -> Picture | None:
        """Where dirt is known to lie, not zero there; None where there is none."""
        return self.view.dim if self.dirt is None else self.dirt

    def object_pixels(self) -> Picture:
        """Return the object in its window, the holes of its loops open; 0 or 255.

        Specks that lie by themselves in such a hole are none of it.
        """
        return _pixels_of(self.blob, self.view)

    def centroid(self) -> tuple[float, float]:
        """Return the centroid (u, v) of the object's pixels, in the picture."""
        u, v = mask_centroid(self.object_pixels())
        return u + self.view.origin[0], v + self.view.origin[1]

    def thickness(self) -> float:
        """Return a first guess of the body's width, pixels, from the distance to the contour."""
        return thickness(draw_blob(self.blob, self.view.window))

    def is_occluder_at(self, points: Floats) -> Mask:
        """Return at which points (n, 2) of the picture glare may occlude the body's edges."""
        if self.occluder is None:
            return np.zeros(len(points), bool)
        height, width = self.occluder.shape
        u, v = np.rint(self.view.in_window(points)).astype(int).T
        return np.asarray(self.occluder[v.clip(0, height - 1), u.clip(0, width - 1)] > 0)

    def goes_on_at(self, points: Floats, distance: float) -> bool:
        """Tell whether the object goes on, within this many pixels, where a midline on it ends."""
        return any(self.goes_on_at_ends(points, distance, self.object_pixels()))

    def goes_on_at_ends(self, points: Floats, distance: float, part: Picture) -> tuple[bool, bool]:
        """Tell of each end of a midline whether a part of the object, a mask, goes on there."""
        height, width = part.shape
        points, goes_on = self.view.in_window(points), []
        for tip, within in (points[:2], points[:-3:-1]):
            onwards = (tip - within) / max(float(np.hypot(*(tip - within))), 1e-9)
            ahead = tip + distance * np.linspace(0.5, 1.0, 4)[:, None] * onwards
            u, v = np.rint(ahead).astype(int).T
            seen = (u >= 0) & (v >= 0) & (u < width) & (v < height)
            goes_on.append(bool(part[v[seen], u[seen]].any()))
        return goes_on[0], goes_on[1]

    def with_dirt(self, dirt: Picture, window: Window) -> "Detection":
        """Return the object with dirt under it that has become known of since.

        Parameters
        ----------
        dirt : ndarray of uint8
            Not zero where dirt lies.
        window : Window
            Where in the picture that mask lies; the object's own window is a part of it.
        """
        (v0, u0), (rows, columns) = (part.start for part in window), self.view.window
        here = dirt[rows.start - v0 : rows.stop - v0, columns.start - u0 : columns.stop - u0]
        return replace(self, dirt=here)

    def restricted_to(self, mask: Picture) -> "Detection | None":
        """Return the largest object within a mask of the window; what is outside is no signal."""
        wide = cv2.dilate(mask, np.ones((2 * _RIM_PX + 1, 2 * _RIM_PX + 1), np.uint8))
        signal = np.asarray(cv2.bitwise_and(self.view.signal, wide), np.uint8)
        smooth, raised = np.asarray(cv2.bitwise_and(self.view.smooth, mask), np.uint8), None
        if self.view.raised is not None:
            raised = np.asarray(cv2.bitwise_and(self.view.raised, mask), np.uint8)
        view = replace(self.view, signal=signal, smooth=smooth, raised=raised)
        blobs = view.blobs()
        return replace(self, view=view, blob=blobs[0]) if blobs else None

    def cropped(self, margin_px: int, box: tuple[int, int, int, int] | None = None) -> "Detection":
        """Return the object in a small window around it, or around a box (u0, v0, u1, v1)."""
        rows, columns = self.view.window
        u0, v0 = self.view.origin
        window = window_around(box or self.blob.box, margin_px, (rows.stop, columns.stop))
        rows = slice(max(window[0].start, v0), window[0].stop)
        columns = slice(max(window[1].start, u0), window[1].stop)
        part = np.s_[rows.start - v0 : rows.stop - v0, columns.start - u0 : columns.stop - u0]
        signal, smooth = self.view.signal[part].copy(), self.view.smooth[part].copy()
        raised = None if self.view.raised is None else self.view.raised[part].copy()
        window = rows, columns
        dim = None if self.view.dim is None else self.view.dim[part].copy()
        view = replace(
            self.view, window=window, signal=signal, smooth=smooth, raised=raised, dim=dim
        )
        return replace(self, view=view, occluder=None, dirt=None)


@lru_cache(maxsize=2)  # a picture's object is asked for again and again, and seldom later
def _pixels_of(blob: Blob, view: SignalView) -> Picture:
    """Return an object in its window, as `Detection.object_pixels` does."""
    filled = draw_blob(blob, view.window)
    pixels = np.asarray(cv2.bitwise_and(filled, view.above_threshold()), np.uint8)
    if blob.hole_area:
        pixels = _joined_to(blob.contour - np.array(view.origin), pixels)
    pixels.flags.writeable = False
    return pixels


def _joined_to(outline: NDArray[np.int64], pixels: Picture) -> Picture:
    """Return the pieces of a mask, 0 or 255, that an outline (n, 2) in it runs along."""
    count, pieces = cv2.connectedComponents(pixels, connectivity=8)
    if count <= 2:
        return pixels
    height, width = pixels.shape
    u, v = outline.T
    kept = np.zeros(count, np.uint8)
    kept[pieces[v.clip(0, height - 1), u.clip(0, width - 1)]] = 255
    kept[0] = 0
    return np.asarray(kept[pieces], np.uint8)
