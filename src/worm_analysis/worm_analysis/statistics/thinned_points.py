"""Points for a scatter plot of a trial of any length, evenly thinned, in bounded memory."""

import numpy as np

from worm_msgs_py.arrays import Floats


class ThinnedPoints:
    """Keeps every point, then every other one, every fourth and so on: evenly over the trial."""

    MOST = 512

    def __init__(self) -> None:
        self._points: list[tuple[float, float]] = []
        self._every = 1
        self._seen = 0

    def push(self, x: float, y: float) -> None:
        """Take a point."""
        if self._seen % self._every == 0:
            self._points.append((x, y))
            if len(self._points) > self.MOST:
                self._points = self._points[::2]
                self._every *= 2
        self._seen += 1

    def rows(self) -> Floats:
        """Return the points that are kept, shape (n, 2)."""
        return np.array(self._points, dtype=np.float64).reshape(-1, 2)
