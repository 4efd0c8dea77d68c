"""The `worm` command."""

import os
import signal
import sys
import threading
from types import FrameType


def main() -> None:
    """Run the command (see `app.main`), and end when a signal says so, also while it is loaded."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _leave)
    from worm_bringup.cli.app import main as run

    try:
        run()
    finally:
        _leave_behind_what_hangs()


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: nothing has been begun."""
    os._exit(128 + signal.SIGINT)


def _leave_behind_what_hangs() -> None:
    """End at once where a camera is still being opened or read: that may take ten seconds."""
    if any(thread.name == "capture" for thread in threading.enumerate()):
        error = sys.exc_info()[1]
        status = error.code if isinstance(error, SystemExit) else 1
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status if isinstance(status, int) else 0)
