"""When each frame of a video file is due: by its container where that makes sense."""

import math

_LONGEST_S = 3600.0
"""A frame that is said to be shown for longer is not waited for."""


class FilmPace:
    """Turns the times of a container into times that grow from 0, frame by frame.

    A video of variable rate is played as it was filmed. Where a time is missing or does not grow
    (some files carry none) the frame is due one period after the one before it.

    Parameters
    ----------
    fps : float
        The rate that the container claims.

    Attributes
    ----------
    guessed : int
        Frames whose time was not the container's.
    """

    def __init__(self, fps: float) -> None:
        self._period_s = 1.0 / fps
        self._first_s: float | None = None
        self._last_s = -math.inf
        self.guessed = 0

    def due_s(self, container_s: float) -> float:
        """Return the seconds from the first frame to this one."""
        if self._first_s is None:
            self._first_s, self._last_s = container_s if math.isfinite(container_s) else 0.0, 0.0
            return 0.0
        due_s = container_s - self._first_s
        if not self._last_s < due_s <= self._last_s + _LONGEST_S:
            self.guessed += 1
            due_s = self._last_s + self._period_s
        self._last_s = due_s
        return due_s
