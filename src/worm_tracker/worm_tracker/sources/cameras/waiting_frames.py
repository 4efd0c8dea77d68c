"""Frames of a camera that wait for the tracker: few of them, and what nobody took is counted."""

import threading
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_WAITING = 60
"""Two seconds at 30 frames/s: longer than it takes to find the chamber in the first picture, and
than the frames that were held back until the head was known take to be analysed."""


@dataclass(frozen=True, slots=True, eq=False)
class CapturedFrame:
    """One frame: grey, shape (h, w) uint8, and when it was captured, nanoseconds since 1970.

    Where `why_bad` says why it cannot be used, there is no pixel.
    """

    picture: NDArray[np.uint8]
    stamp_ns: int
    why_bad: str = ""


class WaitingFrames:
    """Holds frames in order while the tracker is busy for a moment; the newest alone where it lags.

    Where `most` frames wait when another comes, the tracker is slower than the camera: those that
    wait are skipped, and the newest one alone is held from then on, until as many have been taken
    in a row without one skipped. Before `begin` the newest alone is held too, and nothing counted.

    One thread may put frames in while another takes them.
    """

    def __init__(self, most: int = MOST_WAITING) -> None:
        self._lock = threading.Lock()
        self._frames: deque[CapturedFrame] = deque()
        self._most, self._limit = most, 1
        self._captured = self._taken = self._skipped = self._in_a_row = 0

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return bool(self._frames)

    def begin(self) -> None:
        """Count, and hold more frames than one, from now on."""
        with self._lock:
            self._captured, self._taken, self._skipped = len(self._frames), 0, 0
            self._limit = self._most

    def put(self, frame: CapturedFrame) -> None:
        """Hold a frame behind those that wait, or instead of them."""
        with self._lock:
            if len(self._frames) >= self._limit:
                self._skipped += len(self._frames)
                self._frames.clear()
                self._limit, self._in_a_row = 1, 0
            self._frames.append(frame)
            self._captured += 1

    def take(self) -> CapturedFrame | None:
        """Return the oldest frame that waits, or None."""
        with self._lock:
            if not self._frames:
                return None
            self._taken += 1
            self._in_a_row += 1
            if self._in_a_row >= self._most:
                self._limit = self._most
            return self._frames.popleft()

    def counts(self) -> tuple[int, int, int, int]:
        """Return how many frames were put in, taken and skipped, and how many wait.

        The first is the sum of the others at any time.
        """
        with self._lock:
            return self._captured, self._taken, self._skipped, len(self._frames)
