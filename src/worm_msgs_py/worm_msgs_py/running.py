"""Runs one node as a process of its own, until SIGINT or SIGTERM."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

TICK_S = 0.1
"""No wait is longer than this, so that a signal or a service is heeded at once."""
_REFUSED = 2


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Give an event that SIGINT and SIGTERM set while the block runs.

    rclpy's own handlers end the context before the last messages are out. Outside the main thread
    (where Python allows no handlers) the event is simply never set by a signal.
    """
    stop = threading.Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        stop.set()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {
        number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def run_alone(
    make: Callable[[], Node],
    args: list[str] | None = None,
    refusals: tuple[type[Exception], ...] = (ValueError,),
) -> int:
    """Make a node and run its callbacks until a signal comes.

    Parameters
    ----------
    make : callable
        Makes the node, in rclpy's default context.
    args : list of str, optional
        Command line, with ``--ros-args``.
    refusals : tuple of exception types
        What the node raises where its parameters or its input are bad.

    Returns
    -------
    int
        The process's exit status: 0, or 2 where the node refused (one line on stderr).
    """
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node = None
    try:
        with stop_on_signals() as stop:
            node = make()
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            while not stop.is_set():
                executor.spin_once(timeout_sec=TICK_S)
    except (*refusals, InvalidParameterTypeException) as error:
        print(error, file=sys.stderr)
        return _REFUSED
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
