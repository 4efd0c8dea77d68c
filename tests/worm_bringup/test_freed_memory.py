"""Memory that is free between pieces in use is kept, and goes back when that is asked for."""

import gc
import platform
import subprocess
import sys

import pytest

from worm_bringup.freed_memory import lasting_objects_left_alone

FREE_IN_PIECES = """
import os
from pathlib import Path
from worm_bringup.freed_memory import give_back_freed_memory, keep_freed_memory

def resident_mib():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

keep_freed_memory()
{taken}
in_use = taken[::32]
full = resident_mib()
del taken
kept = resident_mib()
give_back_freed_memory()
print(full - kept, full - resident_mib(), len(in_use))
"""


PICTURES = 'taken = [b"1" * (1 << 16) for _ in range(2048)]'
COLUMNS = """
import numpy as np
import pyarrow as pa
taken = [pa.array(np.full(1 << 13, 1.0)).take(pa.array(np.arange(1 << 13))) for _ in range(2048)]
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other libraries do as they do")
@pytest.mark.parametrize("taken", [PICTURES, COLUMNS], ids=["of glibc", "of Arrow"])
def test_what_was_freed_is_kept_until_it_is_given_back(taken):
    """128 MiB are taken, and all but every 32nd of their 64 KiB are freed."""
    program = FREE_IN_PIECES.replace("{taken}", taken)
    told = subprocess.run(
        [sys.executable, "-P", "-c", program], check=True, capture_output=True, text=True
    )
    given_at_once_mib, given_back_mib, _ = map(float, told.stdout.split())
    assert given_at_once_mib < 1
    assert given_back_mib > 110


def test_what_lasts_is_left_out_of_collections_while_a_graph_runs_and_no_longer():
    before = gc.get_freeze_count()
    with lasting_objects_left_alone():
        assert gc.get_freeze_count() > before + 10_000  # modules and what they hold
        loop: list[object] = []
        loop.append(loop)
        del loop
        assert gc.collect() >= 1  # what came since is collected as ever
    assert gc.get_freeze_count() == 0
