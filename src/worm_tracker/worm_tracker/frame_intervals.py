"""Tells from stamps how much a worm may have moved between two frames, and how many are missing."""

from collections import deque
from dataclasses import dataclass
from statistics import median


@dataclass(frozen=True, slots=True)
class FrameIntervalSettings:
    """What is a long interval."""

    step_ns: int = 66_666_667
    """What a worm can do in a frame is bounded for 15 frames a second."""
    most_steps: int = 15
    """After a second a worm may be anywhere: what it did before tells no more."""
    memory_frames: int = 31
    """The usual interval is the median of so many: odd, so that it is one of them."""
    least_intervals: int = 3
    """Intervals from which on a usual one is known."""


@dataclass(frozen=True, slots=True)
class Elapsed:
    """What lies between a frame and the one before.

    Attributes
    ----------
    steps : int
        Frames of 15 a second, 1 to 15: the limits on what a worm does are for one of them.
    frames_missing : int
        Frames that are missing, by the recording's usual interval.
    over_steps : float
        How much longer than so many frames it is, 1 to 1.5: 80 ms are one, and a fifth longer.
    """

    steps: int = 1
    frames_missing: int = 0
    over_steps: float = 1.0


AT_ONCE = Elapsed()
"""Of a frame that follows the one before at a usual rate."""


class FrameIntervals:
    """Measures the time between frames, by their stamps alone.

    Parameters
    ----------
    settings : FrameIntervalSettings
    """

    def __init__(self, settings: FrameIntervalSettings) -> None:
        self._settings = settings
        self._last_ns: int | None = None
        self._usual = deque[int](maxlen=settings.memory_frames)

    def push(self, stamp_ns: int) -> Elapsed:
        """Take the stamp of the next frame; return what lies between it and the last.

        No frame is missing where stamps do not increase, nor before a usual interval is known; nor
        in a recording of every second frame: that is its usual interval.

        Parameters
        ----------
        stamp_ns : int
            Time of capture.
        """
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is None or stamp_ns <= last_ns:
            return AT_ONCE
        interval_ns = stamp_ns - last_ns
        known = len(self._usual) >= self._settings.least_intervals
        missing = round(interval_ns / median(self._usual)) - 1 if known else 0
        self._usual.append(interval_ns)
        steps = min(max(round(interval_ns / self._settings.step_ns), 1), self._settings.most_steps)
        # More than half a step over is a pause that is longer than all steps that count.
        over = min(max(interval_ns / (steps * self._settings.step_ns), 1.0), 1.5)
        return Elapsed(steps, max(missing, 0), over)
