"""Memory that is free between pieces in use is kept by glibc, and goes back when it is told to."""

import platform
import subprocess
import sys

import pytest

FREE_IN_PIECES = """
import os
from pathlib import Path
from worm_bringup.freed_memory import give_back_freed_memory, keep_freed_memory

def resident_mib():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

keep_freed_memory()
pictures = [b"1" * (1 << 16) for _ in range(2048)]
in_use = pictures[::32]
full = resident_mib()
del pictures
kept = resident_mib()
give_back_freed_memory()
print(full - kept, full - resident_mib(), len(in_use))
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other libraries do as they do")
def test_what_was_freed_is_kept_until_it_is_given_back():
    """128 MiB are taken, and all but every 32nd of their 64 KiB are freed."""
    told = subprocess.run(
        [sys.executable, "-P", "-c", FREE_IN_PIECES], check=True, capture_output=True, text=True
    )
    given_at_once_mib, given_back_mib, _ = map(float, told.stdout.split())
    assert given_at_once_mib < 1
    assert given_back_mib > 110
