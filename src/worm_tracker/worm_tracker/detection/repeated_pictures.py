"""Tells which pictures repeat the one before, as films do that were made to have more of them."""

from collections import deque
from dataclasses import dataclass
from statistics import median

import cv2

from worm_msgs_py.arrays import Picture


@dataclass(frozen=True, slots=True)
class RepeatedPicturesSettings:
    """What is repeated, and what merely stands still."""

    most_repeats: int = 3
    """How often a picture is repeated at most: what stands still for longer is a film of it."""
    memory_pictures: int = 31
    least_known: int = 8
    """By how many pictures before it is known how much usually changes from one to the next, and
    from how many on; until then nothing at all may change."""
    most_change_over_usual: float = 0.2
    most_largest_over_usual: float = 0.4
    """How much a repeated picture may change on average, and where it changes most, over what is
    usual: a video codec does not give the same picture twice. In films of H.264 (constant rate
    factor of 18 to 23; a real worm, a simulated and two drawn ones) 51 to 99 % of the repeats
    changed less, and of 2800 other pictures none."""
    every_row: int = 2
    """Of so many rows one is looked at."""
    most_unsaid: float = 0.05
    """Part of a film's pictures that may repeat the one before without a word."""


class RepeatedPictures:
    """Compares each picture with the one before.

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
        self._usual: deque[tuple[float, float]] = deque(maxlen=settings.memory_pictures)
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
        rows, last = picture[:: self._settings.every_row], self._last
        is_alike = last is not None and rows.size > 0 and rows.shape == last.shape
        change = _change(rows, last) if last is not None and is_alike else None
        is_same = change is not None and self._is_little(change)
        if is_same and self._differed and self._in_a_row < self._settings.most_repeats:
            self._in_a_row += 1
            self.count += 1
            return True
        if change is not None and not is_same:
            self._usual.append(change)
        self._differed, self._in_a_row = last is not None and not is_same, 0
        self._last = rows.copy()  # a camera may write the next one over it
        return False

    def _is_little(self, change: tuple[float, float]) -> bool:
        settings = self._settings
        if len(self._usual) < settings.least_known:
            return change == (0.0, 0.0)
        usual, usual_largest = (median(each) for each in zip(*self._usual, strict=True))
        mean, largest = change
        is_little = mean <= settings.most_change_over_usual * usual
        return is_little and bool(largest <= settings.most_largest_over_usual * usual_largest)


def _change(one: Picture, other: Picture) -> tuple[float, float]:
    """Return by how many grey levels two pictures differ, on average and at most."""
    mean = float(cv2.norm(one, other, cv2.NORM_L1)) / one.size
    return mean, float(cv2.norm(one, other, cv2.NORM_INF))
