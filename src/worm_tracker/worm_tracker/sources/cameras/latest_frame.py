"""Holds the newest frame of a camera for whoever takes it, and counts those that nobody took."""

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class CapturedFrame:
    """One frame: grey, shape (h, w) uint8, and when it was captured, nanoseconds since 1970."""

    picture: NDArray[np.uint8]
    stamp_ns: int


class LatestFrame:
    """Holds one frame; one that nobody has taken when the next comes is overwritten, and counted.

    One thread may put frames in while another takes them.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._frame: CapturedFrame | None = None
        self._captured = self._taken = self._skipped = 0

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return self._frame is not None

    def put(self, frame: CapturedFrame) -> None:
        """Hold a frame instead of the one before it."""
        with self._lock:
            self._skipped += self._frame is not None
            self._frame = frame
            self._captured += 1

    def take(self) -> CapturedFrame | None:
        """Return the newest frame that was not taken yet, or None."""
        with self._lock:
            frame, self._frame = self._frame, None
            self._taken += frame is not None
        return frame

    def counts(self) -> tuple[int, int, int, int]:
        """Return how many frames were put in, taken and overwritten, and whether one waits.

        The first is the sum of the others at any time.
        """
        with self._lock:
            return self._captured, self._taken, self._skipped, int(self._frame is not None)
