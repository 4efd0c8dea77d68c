"""How many a second, over the last seconds."""

from collections import deque

_WINDOW_S = 3.0
_MOST_COUNTS = 64


class Rate:
    """Follows a count that only grows.

    Attributes
    ----------
    count : int
        The last that was told.
    """

    def __init__(self) -> None:
        self.count = 0
        self._told: deque[tuple[float, int]] = deque(maxlen=_MOST_COUNTS)

    def take(self, count: int, now_s: float) -> None:
        """Take the count at this time; a few times a second are enough."""
        self.count = count
        if not self._told or now_s - self._told[-1][0] >= _WINDOW_S / _MOST_COUNTS:
            self._told.append((now_s, count))

    def per_s(self, now_s: float) -> float | None:
        """Return how many a second there were of late; None where that cannot be told yet."""
        while len(self._told) > 1 and now_s - self._told[0][0] > _WINDOW_S:
            self._told.popleft()
        if not self._told:
            return None
        began_s, first = self._told[0]
        span_s = now_s - began_s
        return (self.count - first) / span_s if span_s > 0.5 else None
