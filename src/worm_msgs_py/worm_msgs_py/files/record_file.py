"""A file that grows by whole pieces, or says that the disk is full and stays as it was."""

import os
from contextlib import suppress
from pathlib import Path


class RecordFile:
    """A new file for writers that need `write`, `tell` and `flush`.

    What is written stays in memory until `commit`, which puts it onto the disk whole or not at
    all: a full disk never leaves half a record at the end, and what did not fit can be committed
    later. Room for the end (an index, a footer) can be kept meanwhile in a file beside this one.

    Parameters
    ----------
    path : Path
        The file to make.

    Raises
    ------
    OSError
        It exists, or cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.committed = 0
        self.closed = False
        self._waiting = bytearray()
        self._kept = path.with_name(f".{path.name}.room")  # not .mcap: it is none
        self._kept_bytes = 0
        self._handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)

    @property
    def waiting(self) -> int:
        """Number of bytes that are not on the disk yet."""
        return len(self._waiting)

    def write(self, data: bytes) -> int:
        """Take bytes; they reach the disk with the next `commit`."""
        self._waiting += data
        return len(data)

    def tell(self) -> int:
        """Return the length of the file once all is committed."""
        return self.committed + len(self._waiting)

    def flush(self) -> None:
        """Do nothing: `commit` decides."""

    def writable(self) -> bool:
        """Return True."""
        return True

    def commit(self) -> None:
        """Put what waits onto the disk; OSError where it does not fit: the file is as before."""
        left = memoryview(self._waiting)
        try:
            while left:
                left = left[os.write(self._handle, left) :]
        except OSError:
            os.ftruncate(self._handle, self.committed)
            os.lseek(self._handle, self.committed, os.SEEK_SET)
            raise
        finally:
            left.release()
        self.committed += len(self._waiting)
        self._waiting.clear()

    def sync(self) -> None:
        """See what is committed onto the medium: from now on a power cut does not cost it."""
        os.fdatasync(self._handle)

    def keep_room(self, wanted: int) -> None:
        """Keep at least so many bytes of the disk for the end; OSError where there are none."""
        if wanted <= self._kept_bytes:
            return
        handle = os.open(self._kept, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            os.posix_fallocate(handle, 0, wanted)
        finally:
            os.close(handle)
        self._kept_bytes = wanted

    def give_room(self) -> None:
        """Give back the room that was kept."""
        self._kept_bytes = 0
        with suppress(OSError):
            self._kept.unlink()

    def close(self) -> None:
        """Close the file, without what was not committed."""
        self.give_room()
        if not self.closed:
            self.closed = True
            os.close(self._handle)
