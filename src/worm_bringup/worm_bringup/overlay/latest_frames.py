"""The latest frame of which all parts have come, for those who only look and never wait."""

from collections.abc import Collection
from threading import Lock

from worm_tracker.sources.bags.serialized_images import stamp_of

_MOST_INCOMPLETE = 16
"""Frames of which some parts have come. Pictures come before their states, which the tracker may
hold back: of a longer burst the last frames have their pictures, and they are what is shown."""

Parts = dict[str, bytes]
"""Serialised messages of one frame by topic."""


class LatestFrames:
    """Takes the parts of frames in any order, and gives the newest frame that is whole.

    Frames are known by the stamps in their headers. One thread may add while another takes.

    Parameters
    ----------
    needed : collection of str
        The topics that make a frame whole.
    """

    def __init__(self, needed: Collection[str]) -> None:
        self._needed = frozenset(needed)
        self._waiting: dict[int, Parts] = {}
        self._whole: tuple[int, Parts] | None = None
        self._lock = Lock()

    def add(self, topic: str, data: bytes) -> bool:
        """Take a message; tell whether it has made a frame whole."""
        stamp_ns = stamp_of(data)
        with self._lock:
            parts = self._waiting.setdefault(stamp_ns, {})
            parts[topic] = data
            if not parts.keys() >= self._needed:
                for old in sorted(self._waiting)[:-_MOST_INCOMPLETE]:
                    del self._waiting[old]
                return False
            self._whole = stamp_ns, parts
            for old in [key for key in self._waiting if key <= stamp_ns]:
                del self._waiting[old]
            return True

    def take(self) -> tuple[int, Parts] | None:
        """Return stamp and parts of the newest whole frame, once; None where there is no new."""
        with self._lock:
            whole, self._whole = self._whole, None
            return whole
