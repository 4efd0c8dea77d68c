"""What happens to freed memory: kept for the next picture, given back now and then."""

import ctypes
import gc
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pyarrow as pa

# glibc's malloc.h, and what the parameters are set to.
_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_MMAP_THRESHOLD = -1, -2, -3
_GIBIBYTE = 1 << 30


def keep_freed_memory() -> None:
    """Let glibc keep freed buffers of a picture's size; elsewhere do nothing.

    By default it maps each one anew and gives it back, which costs more than copying the picture.
    """
    with suppress(OSError, AttributeError):
        libc = ctypes.CDLL("libc.so.6")
        libc.mallopt(_M_MMAP_THRESHOLD, _GIBIBYTE)
        libc.mallopt(_M_TRIM_THRESHOLD, _GIBIBYTE)
        libc.mallopt(_M_TOP_PAD, 64 << 20)


def give_back_freed_memory() -> None:
    """Give back to the system what Arrow and glibc have kept by now; elsewhere Arrow's alone.

    What is kept lies in pieces between what is in use, and new objects do not always fit into
    them: a replay of an hour takes 300 MiB without this, and 250 with it.
    """
    pa.default_memory_pool().release_unused()
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)


@contextmanager
def lasting_objects_left_alone() -> Iterator[None]:
    """Leave what is there by now, all modules above all, out of garbage collections.

    A full one goes through half a million of objects that last: it stopped a live trial for 70 ms,
    two frames, every minute or so.
    """
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
