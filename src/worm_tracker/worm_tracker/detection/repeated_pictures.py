"""Tells which pictures repeat the one before, as films do that were made to have more of them."""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Picture


@dataclass(frozen=True, slots=True)
class RepeatedPicturesSettings:
    """What is repeated, and what merely stands still."""

    most_repeats: int = 3
    """How often a picture is repeated at most: what stands still for longer is a film of it."""
    stride_px: int = 32
    """Of pictures that differ every so many-th pixel of every so many-th row shows it."""
    most_unsaid: float = 0.05
    """Part of a film's pictures that may repeat the one before without a word."""


class RepeatedPictures:
    """Compares each picture with the one before, to the last grey level.

    No camera takes the same picture twice: its noise differs. A film that was converted to a higher
    frame rate has some twice, and so has a camera that falls behind. Nothing moves in them, and
    twice as far in the next one. Where pictures are the same on and on nothing is repeated: they
    may be drawn, of a worm at rest.

    Parameters
    ----------
    settings : RepeatedPicturesSettings

    Attributes
    ----------
    count : int
        Pictures taken so far that repeat the one before.
    """

    def __init__(self, settings: RepeatedPicturesSettings) -> None:
        self._settings = settings
        self._last: Picture | None = None
        self._differed = False
        self._in_a_row = 0
        self._pictures = 0
        self.count = 0

    @property
    def advice(self) -> str:
        """What to do about a film in which many are repeated; else empty."""
        if self.count <= self._settings.most_unsaid * self._pictures:
            return ""
        return (
            f"{self.count} of {self._pictures} pictures repeat the one before: the film was "
            "converted to a higher frame rate, or the camera fell behind; speeds are right on "
            "average alone, so film or import it at the rate at which its pictures were taken"
        )

    def push(self, picture: Picture) -> bool:
        """Take the next picture; tell whether it repeats the one before.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        """
        self._pictures += 1
        last = self._last
        is_same = last is not None and self._is_same(picture, last)
        if is_same and self._differed and self._in_a_row < self._settings.most_repeats:
            self._in_a_row += 1
            self.count += 1
            return True
        self._differed, self._in_a_row = last is not None and not is_same, 0
        if not is_same:
            self._last = picture.copy()  # a camera may write the next one over it
        return False

    def _is_same(self, one: Picture, other: Picture) -> bool:
        stride = self._settings.stride_px
        if one.shape != other.shape or not one.size:
            return False
        if not np.array_equal(one[::stride, ::stride], other[::stride, ::stride]):
            return False
        return np.array_equal(one, other)
