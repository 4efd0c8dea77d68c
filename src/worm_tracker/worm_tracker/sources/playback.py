"""When each picture of a recording is due: rate, pause, step by step, and round again."""

import math
from collections.abc import Iterable, Iterator

from worm_msgs_py.limits import Limit
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_reader import BagPicture
from worm_tracker.sources.bags.serialized_images import with_stamp

NO_SEEK = -1.0
RATE = Limit(1e-3, 1e3, or_zero=True)
"""Of the recording to a second's; 0: as fast as can be."""
START_OFFSET, PLAYBACK = Limit(0.0, 1e7, "s"), Limit(1e-3, 1e7, "s")
"""Seconds to leave out, and to play."""
SEEK = Limit(0.0, 1e7, "s")
"""Where to play to, from the first picture that is played."""
_LONE_PICTURE_NS = NS_PER_S
"""What a recording of a single picture takes to play, where it is repeated."""


class Playback:
    """The player's clock. It is told what time it is, and never asks.

    Parameters
    ----------
    rate : float
        Seconds of recording to a second; 0 where pictures are due as soon as they can be taken.
    paused : bool
        Start paused.
    """

    def __init__(self, rate: float, *, paused: bool = False) -> None:
        if not (rate >= 0.0 and math.isfinite(rate)):
            raise ValueError(f"the rate is {rate}; it must be 0 (as fast as can be) or more")
        self._rate = rate
        self._paused = paused
        self._steps = 0
        self._first_ns: int | None = None
        self._position_s = 0.0  # of the recording, where the clock was last set
        self._played_s = 0.0  # where the last picture was
        self._set_at_s: float | None = None
        self._sought_s: float | None = None

    @property
    def paused(self) -> bool:
        """Whether pictures wait for `resume` or `play_next`."""
        return self._paused

    @property
    def played_s(self) -> float | None:
        """Where the last picture was, seconds after the first one; None before that."""
        return None if self._first_ns is None else self._played_s

    @property
    def seeks(self) -> bool:
        """Whether pictures are due at once, as far as the one that is sought."""
        return self._sought_s is not None

    def seek(self, position_s: float) -> None:
        """Let every picture be due at once as far as this position, and pause there.

        Parameters
        ----------
        position_s : float
            Seconds after the first picture; not before the last one that was played.
        """
        self._sought_s, self._paused, self._steps = position_s, False, 0

    def stop_seeking(self, now_s: float) -> None:
        """Pause at the last picture, if one that comes later is sought."""
        if self.seeks:
            self._sought_s, self._paused = None, True
            self._position_s, self._set_at_s = self._played_s, now_s

    def pause(self, now_s: float) -> None:
        """Stop the clock."""
        self.stop_seeking(now_s)
        self._position_s = self._position(now_s)
        self._set_at_s = now_s
        self._paused = True

    def resume(self, now_s: float) -> None:
        """Let the clock go on from where it stopped."""
        self.stop_seeking(now_s)
        self._position_s = self._position(now_s)
        self._set_at_s = now_s
        self._paused = False
        self._steps = 0

    def set_rate(self, rate: float, now_s: float) -> None:
        """Let the clock run at another rate from the last picture on, however late that was."""
        self._position_s = self._played_s
        self._set_at_s = now_s if self._first_ns is not None else None
        self._rate = rate

    def play_next(self) -> bool:
        """Let one picture through while paused; return whether that was possible."""
        self._steps += self._paused
        return self._paused

    def _position(self, now_s: float) -> float:
        """Return how far the recording has played, seconds."""
        if self._paused or self._set_at_s is None:
            return self._position_s
        return self._position_s + self._rate * (now_s - self._set_at_s)

    def wait_s(self, stamp_ns: int, now_s: float) -> float:
        """Return the seconds until a picture is due: 0 where it is, infinity where paused."""
        if self._paused:
            return 0.0 if self._steps else math.inf
        if self.seeks or self._rate == 0.0 or self._first_ns is None:
            return 0.0
        ahead_s = (stamp_ns - self._first_ns) / NS_PER_S - self._position(now_s)
        return max(0.0, ahead_s / self._rate)

    def played(self, stamp_ns: int, now_s: float) -> None:
        """Take note that a picture was sent."""
        if self._first_ns is None:
            self._first_ns = stamp_ns
        self._played_s = (stamp_ns - self._first_ns) / NS_PER_S
        if self._paused:
            self._steps = max(0, self._steps - 1)
            self._position_s = self._played_s
        if self._set_at_s is None:
            self._set_at_s = now_s
        if self._sought_s is not None and self._played_s >= self._sought_s:
            self.stop_seeking(now_s)


def in_a_loop(recording: Iterable[BagPicture]) -> Iterator[BagPicture]:
    """Yield a recording again and again, as if it had been filmed in one go.

    Each round is later than the one before by the recording's duration and one mean interval
    between its pictures, so that stamps go on growing.
    """
    shift_ns = 0
    while True:
        first_ns = last_ns = None
        count = 0
        for picture in recording:
            count += 1
            last_ns = picture.stamp_ns
            first_ns = last_ns if first_ns is None else first_ns
            stamp_ns = picture.stamp_ns + shift_ns
            yield BagPicture(stamp_ns, picture.index, with_stamp(picture.raw, stamp_ns))
        if first_ns is None or last_ns is None:
            return
        interval_ns = (last_ns - first_ns) // (count - 1) if count > 1 else _LONE_PICTURE_NS
        shift_ns += last_ns - first_ns + max(1, interval_ns)
