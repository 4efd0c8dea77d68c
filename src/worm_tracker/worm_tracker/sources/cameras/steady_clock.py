"""The time of day that a trial's frames are stamped with: read once, then counted on."""

import time


class SteadyClock:
    """Wall-clock time at the start, plus what has passed since by a clock that is never set.

    The system's clock may be set while a trial runs (NTP, an operator, the end of summer time on a
    rig that keeps local time). Stamps that followed it would tear the trial: speeds and τ_h are
    differences of stamps.
    """

    def __init__(self) -> None:
        self._offset_ns = time.time_ns() - time.monotonic_ns()

    def now_ns(self) -> int:
        """Return nanoseconds since 1970; never less than before."""
        return self._offset_ns + time.monotonic_ns()
