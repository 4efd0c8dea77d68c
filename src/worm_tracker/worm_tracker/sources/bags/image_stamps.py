"""Decides at what time each picture of a recording was taken."""

from statistics import median_low

from worm_msgs_py.units import NS_PER_S

LATEST_NS = 2**31 * NS_PER_S
"""No stamp of ROS is as late as this."""
JUMP_NS = 60 * NS_PER_S
"""A single stamp that is this far from its neighbours, against the times of recording, is wrong."""


class PictureStamps:
    """The stamps of one recording, in the order of recording.

    A picture was taken when its header says. Where the header says nothing (0), something that
    cannot be (before 1970, after 2038), or leaves the neighbours on both sides by more than
    `JUMP_NS` when theirs is compared with the time of recording, it was taken when it was
    recorded, less the usual delay between the two. Where the time of recording cannot be either,
    the picture has none: it takes that of the one before it.

    Parameters
    ----------
    first : list of (int, int)
        Stamps and times of recording of the first messages; they tell the usual delay at the start.
    """

    def __init__(self, first: list[tuple[int, int]]) -> None:
        ahead = [ns for pair in first if (ns := ahead_of(*pair)) is not None]
        self._ahead = median_low(ahead) if ahead else 0
        times = [log for _, log in first if _possible(log)]
        stamps = [stamp for stamp, _ in first if _is_stamped(stamp)]
        self._last_ns = min(stamps) if stamps else min(times, default=0)

    def decide(self, stamp_ns: int, log_ns: int, next_ahead: int | None) -> tuple[int, bool]:
        """Return when a picture was taken, and whether that is known at all.

        Parameters
        ----------
        stamp_ns, log_ns : int
            What its header says, and when it was recorded.
        next_ahead : int or None
            By how much the header of the next message is ahead of its time of recording.
        """
        if _is_stamped(stamp_ns):
            if not _possible(log_ns):
                return self._take(stamp_ns)
            ahead = stamp_ns - log_ns
            alone = next_ahead is None or abs(next_ahead - self._ahead) <= JUMP_NS
            if abs(ahead - self._ahead) <= JUMP_NS or not alone:
                self._ahead = ahead
                return self._take(stamp_ns)
        if not _possible(log_ns):
            return self._last_ns, False
        supposed = log_ns + self._ahead
        return self._take(supposed if _possible(supposed) else log_ns)

    def _take(self, stamp_ns: int) -> tuple[int, bool]:
        self._last_ns = stamp_ns
        return stamp_ns, True


def ahead_of(stamp_ns: int, log_ns: int) -> int | None:
    """Return by how much a header is ahead of the time of recording; None where one cannot be."""
    return stamp_ns - log_ns if _is_stamped(stamp_ns) and _possible(log_ns) else None


def _is_stamped(stamp_ns: int) -> bool:
    return stamp_ns != 0 and _possible(stamp_ns)


def _possible(time_ns: int) -> bool:
    return 0 <= time_ns < LATEST_NS
