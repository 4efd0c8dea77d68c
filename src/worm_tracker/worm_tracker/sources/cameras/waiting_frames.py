"""Frames of a camera that wait for the tracker: for seconds, and what nobody took is counted."""

import threading
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_WAITING = 600
"""Twenty seconds at 30 frames/s: a trial that begins with a long fold takes up to twelve to go back
through it, once the worm is known, and finding the chamber a second or two. A late frame is told;
one that was skipped is lost."""
MOST_WAITING_BYTES = 512_000_000
"""Memory that they may take: large pictures wait in smaller numbers."""
LEAST_WAITING = 60
"""So many may wait, however large they are: finding the chamber in them takes as long."""


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

    Where as many frames wait as may when another comes, the tracker is slower than the camera:
    those that wait are skipped, and the newest one alone is held from then on, until some have been
    taken in a row without one skipped. Before `begin` the newest alone is held too, and nothing
    counted.

    One thread may put frames in while another takes them.

    Parameters
    ----------
    most : int, optional
        Frames that may wait.
    most_bytes : int, optional
        What they may take of memory; of large frames fewer wait, though never fewer than `least`.
    least : int, optional
        Also how many are taken in a row before frames may wait again, and are left at the end.
    """

    def __init__(
        self,
        most: int = MOST_WAITING,
        most_bytes: int = MOST_WAITING_BYTES,
        least: int = LEAST_WAITING,
    ) -> None:
        self._lock = threading.Lock()
        self._frames: deque[CapturedFrame] = deque()
        self._most, self._most_bytes, self._least = most, most_bytes, min(least, most)
        self._newest_alone = True
        self._captured = self._taken = self._skipped = self._in_a_row = 0

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return bool(self._frames)

    def begin(self) -> None:
        """Count, and hold more frames than one, from now on."""
        with self._lock:
            self._captured, self._taken, self._skipped = len(self._frames), 0, 0
            self._newest_alone = False

    def put(self, frame: CapturedFrame) -> None:
        """Hold a frame behind those that wait, or instead of them."""
        with self._lock:
            if len(self._frames) >= self._limit(frame):
                self._skipped += len(self._frames)
                self._frames.clear()
                self._newest_alone, self._in_a_row = True, 0
            self._frames.append(frame)
            self._captured += 1

    def end(self) -> None:
        """Skip all that wait but the oldest few: who ends a trial does not wait for long."""
        with self._lock:
            while len(self._frames) > self._least:
                self._frames.pop()
                self._skipped += 1

    def take(self) -> CapturedFrame | None:
        """Return the oldest frame that waits, or None."""
        with self._lock:
            if not self._frames:
                return None
            self._taken += 1
            self._in_a_row += 1
            if self._in_a_row >= self._least:
                self._newest_alone = False
            return self._frames.popleft()

    def counts(self) -> tuple[int, int, int, int]:
        """Return how many frames were put in, taken and skipped, and how many wait.

        The first is the sum of the others at any time.
        """
        with self._lock:
            return self._captured, self._taken, self._skipped, len(self._frames)

    def _limit(self, frame: CapturedFrame) -> int:
        """Return how many frames of this size may wait."""
        if self._newest_alone:
            return 1
        fit = self._most_bytes // max(frame.picture.nbytes, 1)
        return min(self._most, max(self._least, fit))
