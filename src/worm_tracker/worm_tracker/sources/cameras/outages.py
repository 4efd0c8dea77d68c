"""Outages of a camera: whether frames still come, and when to look for it again or to give up."""

import time
from collections import deque
from dataclasses import dataclass

from worm_msgs_py.units import NS_PER_S

LONGEST_PAUSE_S = 5.0
"""Pauses between attempts to reconnect double up to this."""


@dataclass(frozen=True, slots=True)
class Outage:
    """A time without frames: when the last one before it was captured, how long, and attempts."""

    since_ns: int
    duration_s: float
    reconnections: int


class OutageWatch:
    """What is known of a camera from when its frames came.

    Its clock is that of the frames' stamps, which it is told. How long the camera has been looked
    for is measured by a clock of its own: it is a matter of seconds waited, not of stamps.

    Parameters
    ----------
    reconnect_s : float
        How long a camera that has stopped is looked for.
    first_pause_s : float
        Pause before the first attempt; it doubles up to `LONGEST_PAUSE_S`.
    stall_s : float
        What gives nothing for so long has stopped; infinite where gaps are no outages.
    began_ns : int
        When the first frame began to be waited for.

    Attributes
    ----------
    last_ns : int
        Stamp of the last frame, or when the first one began to be waited for.
    attempts : int
        Attempts to reconnect since then.
    reconnections : int
        How many, in all, opened a camera again.
    """

    def __init__(self, reconnect_s: float, first_pause_s: float, stall_s: float, began_ns: int):
        self._reconnect_s, self._first_pause_s = reconnect_s, first_pause_s
        self._stall_s = stall_s
        self.last_ns = began_ns
        self.attempts = self.reconnections = 0
        self._stopped_s: float | None = None
        self._over: deque[Outage] = deque()

    @property
    def stopped(self) -> bool:
        """Whether the camera is being looked for."""
        return self._stopped_s is not None

    def silent_s(self, now_ns: int) -> float:
        """Return the seconds since the last frame."""
        return (now_ns - self.last_ns) / NS_PER_S

    def outage(self, now_ns: int) -> Outage | None:
        """Return the outage that goes on now; None where frames come."""
        silent_s = self.silent_s(now_ns)
        if not (self.stopped or silent_s > self._stall_s):
            return None
        return Outage(self.last_ns, silent_s, self.attempts)

    def frame_came(self, stamp_ns: int) -> None:
        """Take note of a frame; it ends an outage."""
        outage = self.outage(stamp_ns)
        if outage is not None:
            self._over.append(outage)
        self._stopped_s = None
        self.attempts = 0
        self.last_ns = stamp_ns

    def take_over(self) -> list[Outage]:
        """Return the outages that have ended since the last time."""
        over = []
        while self._over:
            over.append(self._over.popleft())
        return over

    def stop(self) -> None:
        """Take note that the camera has stopped and is to be looked for."""
        self._stopped_s = time.monotonic()

    def pause_s(self) -> float | None:
        """Return the seconds until the next attempt; None where the camera is to be given up."""
        assert self._stopped_s is not None, "only a camera that has stopped is looked for"
        left_s = self._stopped_s + self._reconnect_s - time.monotonic()
        if left_s <= 0.0:
            return None
        return min(self._first_pause_s * 2.0 ** min(self.attempts, 10), LONGEST_PAUSE_S, left_s)
