"""Replaces a result again and again, killed before each change that it makes to the disk in turn.

``python kill_points.py TOP exchange|renames`` makes TOP/0/out, TOP/1/out, …, each with an earlier
result in it, and prints their number.
"""

import errno
import itertools
import os
import signal
import sys
from pathlib import Path

from result_files import write_result

from worm_bringup.outputs import directory_swap
from worm_bringup.outputs.results_directory import results_directory

CHANGES = {"os.mkdir", "os.rename", "os.remove", "os.rmdir", "ctypes.dlsym"}
WRITING = os.O_WRONLY | os.O_RDWR


def replace_result(out, text):
    with results_directory(out) as partial:
        write_result(partial, text)


def killed_before(change, out):
    """Replace a result in a process that dies before its n-th change; say whether it did."""
    child = os.fork()
    if child == 0:
        left = change

        def on_event(event, arguments):
            nonlocal left
            if event in CHANGES or (event == "open" and arguments[2] & WRITING):
                if left == 0:
                    os.kill(os.getpid(), signal.SIGKILL)
                left -= 1

        sys.addaudithook(on_event)
        replace_result(out, "new")
        os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def cannot_exchange(one, other):
    raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))


if __name__ == "__main__":
    if sys.argv[2] == "renames":
        directory_swap._exchange = cannot_exchange
    for number in itertools.count():
        out = Path(sys.argv[1], str(number), "out")
        write_result(out, "earlier")
        if not killed_before(number, out):
            print(number)
            break
