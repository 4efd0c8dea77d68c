"""A lock on an output, which the kernel frees when the process ends, however it ends."""

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_NO_LOCKS_HERE = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


class InUse(RuntimeError):  # noqa: N818 (it is what the output is)
    """Another process holds the lock."""


@contextmanager
def output_lock(place: Path) -> Iterator[bool]:
    """Hold the lock on an output while the block runs; give whether locks are known there.

    The lock is on the hidden file ``.NAME.lock`` beside the output. It is removed while it is still
    held, and one that is no longer in its place is not taken for the lock: so two processes never
    hold it, and no file is left.

    Raises
    ------
    InUse
        At once, where another process holds it.
    OSError
        Where nothing can be written beside the output.
    """
    path = place.with_name(f".{place.name}.lock")
    handle, locked = _lock(path)
    try:
        yield locked
    finally:
        with suppress(OSError):
            if _is_in_place(handle, path):
                path.unlink()
        os.close(handle)


def is_in_use(place: Path) -> bool:
    """Tell whether another process holds the lock, and make nothing."""
    path = place.with_name(f".{place.name}.lock")
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        return not _take(handle, fcntl.LOCK_SH)[0]
    finally:
        os.close(handle)


def _lock(path: Path) -> tuple[int, bool]:
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        free, known = _take(handle, fcntl.LOCK_EX)
        if free and _is_in_place(handle, path):
            return handle, known
        os.close(handle)
        if not free:
            raise InUse(path)


def _take(handle: int, kind: int) -> tuple[bool, bool]:
    """Say whether the lock was free (and is now ours), and whether locks are known there."""
    try:
        fcntl.flock(handle, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False, True
    except OSError as error:
        if error.errno not in _NO_LOCKS_HERE:
            raise
        return True, False
    return True, True


def _is_in_place(handle: int, path: Path) -> bool:
    """Tell whether the open file is the one that the path leads to."""
    try:
        there = path.stat(follow_symlinks=False)
    except FileNotFoundError:
        return False
    return os.path.samestat(there, os.fstat(handle))
