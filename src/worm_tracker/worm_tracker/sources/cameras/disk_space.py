"""How long a disk lasts at the rate at which it is written to, and when to stop."""

import shutil
from pathlib import Path

_WARN_MINUTES = (30.0, 5.0)
_SURE_AFTER_S = 2.0
"""Of two pictures in a hurry a rate would be told that the record never has."""
_KEEP_BYTES = 256 << 20
_KEEP_SHARE = 0.02


class DiskSpace:
    """Watches the disk that a recording grows on.

    Parameters
    ----------
    directory : Path
        Where the recording is.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._levels = list(_WARN_MINUTES)
        self.minutes_left = float("inf")
        self.free_bytes = shutil.disk_usage(directory).free

    @property
    def used_up(self) -> bool:
        """Whether what is left belongs to the others: results may go to the same disk."""
        usage = shutil.disk_usage(self._directory)
        return usage.free < min(_KEEP_BYTES, _KEEP_SHARE * usage.total)

    def warning(self, written_bytes: int, elapsed_s: float) -> str:
        """Return one line each time that the time left falls below a level, otherwise nothing."""
        self.free_bytes = shutil.disk_usage(self._directory).free
        if elapsed_s < _SURE_AFTER_S or written_bytes <= 0:
            return ""
        self.minutes_left = self.free_bytes * elapsed_s / written_bytes / 60.0
        passed = [level for level in self._levels if self.minutes_left < level]
        if not passed:
            return ""
        self._levels = [level for level in self._levels if level not in passed]
        return (
            f"{self._directory}: the disk has {self.free_bytes / 1e6:.0f} MB left, enough for "
            f"{self.minutes_left:.1f} minutes of recording; make room"
        )
