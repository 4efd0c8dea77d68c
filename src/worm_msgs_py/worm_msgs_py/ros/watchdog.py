"""Notices a callback that does not come back, says which node it is, and ends it if it can."""

import faulthandler
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from worm_msgs_py.errors import INCOMPLETE, NodeFailed
from worm_msgs_py.limits import Limit

PATIENCE = Limit(0.1, 86400.0, "s")
PATIENCE_S = 60.0
"""Longer than any node takes over one message, shorter than a trial that nobody watches."""
_SIGNAL = signal.SIGUSR2


class Watch:
    """Which node is at work, and since when; cheap enough to be told of every callback."""

    def __init__(self) -> None:
        self.node = ""
        self.since_s = math.inf

    def enter(self, node: str) -> None:
        """Take note that a node begins with something."""
        self.node, self.since_s = node, time.monotonic()

    def leave(self) -> None:
        """Take note that it is done."""
        self.since_s = math.inf


@contextmanager
def watchdog(patience_s: float) -> Iterator[Watch]:
    """Watch the callbacks that run in this thread while the block runs.

    A callback that takes longer than `patience_s` is told on stderr, with the traceback of all
    threads, and is interrupted: what waits or computes in Python ends with `NodeFailed`. A library
    that does not come back to Python cannot be interrupted; after as long again the process ends.
    What was recorded until then can be saved (`worm repair`). Against a library that
    keeps even other threads from running only a process for each node helps.

    Parameters
    ----------
    patience_s : float
        Seconds that one callback may take.

    Raises
    ------
    NodeFailed
        A callback was interrupted.
    """
    watch, over = Watch(), threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield watch  # signals, which interrupt, reach the main thread alone
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        if watch.since_s < math.inf:
            raise NodeFailed(_hangs(watch.node, patience_s))

    before = signal.signal(_SIGNAL, interrupt)
    thread = threading.Thread(
        target=_interrupt_what_hangs, args=(watch, patience_s, over), name="watchdog", daemon=True
    )
    thread.start()
    try:
        yield watch
    finally:
        over.set()
        thread.join()
        signal.signal(_SIGNAL, before)


def _interrupt_what_hangs(watch: Watch, patience_s: float, over: threading.Event) -> None:
    told = False
    step_s, silent_s, since_s = min(1.0, patience_s / 4), 0.0, math.inf
    while not over.wait(step_s):
        # Only what this thread saw pass: a process that is stopped (Ctrl-Z) does not hang.
        silent_s = silent_s + step_s if watch.since_s == since_s < math.inf else 0.0
        since_s = watch.since_s
        if silent_s > 2 * patience_s:
            print(
                f"{_hangs(watch.node, silent_s)}; it cannot be interrupted and the process ends",
                file=sys.stderr,
                flush=True,
            )
            os._exit(INCOMPLETE)
        if silent_s > patience_s and not told:
            told = True
            faulthandler.dump_traceback(file=sys.__stderr__ or 2, all_threads=True)
            signal.pthread_kill(threading.main_thread().ident or 0, _SIGNAL)


def _hangs(node: str, silent_s: float) -> str:
    return f"node {node or 'of the graph'} hangs: it has not come back for {silent_s:.0f} s"
