"""Keeps a run alive when nobody reads what it says any more: a closed terminal, a closed pipe."""

import errno
import io
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

_NOBODY_READS = (errno.EIO, errno.EPIPE)


class _Mouth(io.FileIO):
    """A file descriptor to write to, into which words may fall without an echo."""

    def write(self, words: Any) -> int:
        try:
            return super().write(words) or 0
        except OSError as error:
            if error.errno not in _NOBODY_READS:
                raise  # such as a full disk: what was asked for is not there
            return memoryview(words).nbytes


@contextmanager
def outliving_the_terminal() -> Iterator[None]:
    """Let writing to stdout and stderr succeed while the block runs, whether anyone reads or not.

    After a hangup each write to a terminal fails with EIO, and into a pipe without a reader with
    EPIPE; a trial must not end of that.
    """
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (_outliving(stream) for stream in before)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        sys.stdout, sys.stderr = before


def _outliving(stream: Any) -> Any:
    try:
        descriptor = stream.fileno()
    except (AttributeError, OSError, ValueError):  # not a file, as in a test or a notebook
        return stream
    with suppress(OSError):
        stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_Mouth(descriptor, "wb", closefd=False)),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.isatty() or stream is sys.stderr,
        write_through=stream is sys.stderr,
    )
