"""Puts one directory in the place of another, at no moment with nothing there."""

import ctypes
import errno
import os
from pathlib import Path

_HERE = -100  # AT_FDCWD
_EXCHANGE = 2  # RENAME_EXCHANGE
_NOT_KNOWN = (errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP)


def put_in_place_of(new: Path, old: Path, aside: Path) -> None:
    """Move `new` to `old`, and what was there to `aside`.

    The two are exchanged in one step where the file system can; where it cannot (NFS), the place is
    empty for the moment between two renames.

    Raises
    ------
    OSError
        Where that cannot be done; all is then where it was.
    """
    try:
        _exchange(new, old)
    except OSError as error:
        if error.errno not in _NOT_KNOWN:
            raise
        old.rename(aside)
        try:
            new.rename(old)
        except OSError:
            aside.rename(old)
            raise
    else:
        new.rename(aside)


def _exchange(one: Path, other: Path) -> None:
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except AttributeError:  # an old C library
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS)) from None
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), str(other))
