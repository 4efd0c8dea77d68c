"""Runs one node as a process of its own, until SIGINT, SIGTERM or SIGHUP."""

import math
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import TYPE_CHECKING, TypeVar

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from worm_msgs_py.errors import BAD_INPUT, BadInput
from worm_msgs_py.ros.claims import claim
from worm_msgs_py.ros.network import Reach, dds_settings, environment, reach_of_a_lone_node
from worm_msgs_py.ros.parameter_files import files_of_a_rig
from worm_msgs_py.ros.worm_node import refuse_unknown_parameters
from worm_msgs_py.text import printable

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

TICK_S = 0.1
"""No wait is longer than this, so that a signal or a service is heeded at once."""
AGAIN_S = 0.01
"""Seconds from a KeyboardInterrupt that Python dropped to the next: a callback is over by then."""

AnyNode = TypeVar("AnyNode", bound=Node)


class Stop(threading.Event):
    """Set by a signal; it also knows the first one, for good.

    Attributes
    ----------
    number : int or None
        The signal.
    """

    def __init__(self) -> None:
        super().__init__()
        self.number: int | None = None

    def take(self, number: int) -> None:
        """Take a signal."""
        if self.number is None:
            self.number = number
        self.set()


_running: Stop | None = None  # of the stop_on_signals that is in force


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Give an event that SIGINT, SIGTERM and SIGHUP set while the block runs.

    rclpy's own handlers end the context before the last messages are out. Outside the main thread
    (where Python allows no handlers) the event is simply never set by a signal. Within another such
    block it is the same event, so that no signal falls between the two.

    A terminal that closes may send SIGHUP twice, or after SIGTERM: it counts as the first signal
    alone. Where SIGHUP was ignored (nohup) it stays so.
    """
    global _running
    if threading.current_thread() is not threading.main_thread():
        yield Stop()
        return
    outer = _running
    stop = _running = Stop() if outer is None else outer
    seen = False

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal seen
        if number != signal.SIGHUP or not seen:
            stop.take(number)
        seen = True

    try:
        with _handling(on_signal):
            yield stop
    finally:
        _running = outer


@contextmanager
def finish_despite_signals(within_s: float = math.inf, *, told: bool = False) -> Iterator[None]:
    """Let the block come to its end at the first signal; a second one raises KeyboardInterrupt.

    SIGHUP is never the second: nobody is there any more who waits.

    Parameters
    ----------
    within_s : float
        Seconds that the block is given from the first signal on; then KeyboardInterrupt is raised.
    told : bool
        Whether the first signal came before.
    """
    seen = told

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal seen
        if seen and number != signal.SIGHUP:
            raise KeyboardInterrupt
        if not seen and within_s < math.inf:
            signal.setitimer(signal.ITIMER_REAL, within_s)
        seen = True

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _until_it_is_heard(), _handling(on_signal):
        yield


@contextmanager
def interrupted_by_signals() -> Iterator[None]:
    """Let SIGTERM and SIGHUP do what Ctrl-C does, so that nothing half-written is left behind."""

    def on_signal(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    with _until_it_is_heard(), _handling(on_signal):
        yield


@contextmanager
def _until_it_is_heard() -> Iterator[None]:
    """Raise KeyboardInterrupt at SIGALRM, and anew where Python has dropped it.

    What is raised in a finaliser or a weak reference's callback, where a signal may fall, is told
    on stderr and forgotten; the program would go on as if nobody had asked it to end.
    """
    told = sys.unraisablehook

    def on_alarm(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    def anew(dropped: "UnraisableHookArgs") -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
        else:
            told(dropped)

    timer = signal.setitimer(signal.ITIMER_REAL, 0.0)
    before = signal.signal(signal.SIGALRM, on_alarm)
    sys.unraisablehook = anew
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook = told
        signal.signal(signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, *timer)


@contextmanager
def _handling(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Handle the signals that end a program, but SIGHUP only where it was not ignored."""
    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextmanager
def ros_of_a_lone_node(args: list[str] | None) -> Iterator[Reach]:
    """Start rclpy's default context for one node, and end it; give who can hear the node.

    Raises
    ------
    BadInput
        The command line, or a parameter file that it names, cannot be read.
    """
    reach = reach_of_a_lone_node()
    with environment(**dds_settings(reach, heed_profile=True)):
        try:
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        except RuntimeError as error:
            why = str(error).split(", at ")[0].removeprefix("failed to initialize rcl: ")
            raise BadInput(f"--ros-args cannot be used: {why}") from None
        try:
            yield reach
        finally:
            rclpy.try_shutdown()


@contextmanager
def alone_on_its_name(node: Node, reach: Reach) -> Iterator[None]:
    """Hold a lone node's name where others can hear it (see `claims.claim`)."""
    names = [] if reach is Reach.OWN else [node.get_fully_qualified_name()]
    with claim(node.context.get_domain_id(), names):
        yield


def _until_a_signal(node: Node, executor: SingleThreadedExecutor, stop: threading.Event) -> int:
    while not stop.is_set():
        executor.spin_once(timeout_sec=TICK_S)
    return 0


def run_alone(
    make: Callable[[], AnyNode],
    args: list[str] | None = None,
    refusals: tuple[type[Exception], ...] = (ValueError,),
    drive: Callable[[AnyNode, SingleThreadedExecutor, threading.Event], int] = _until_a_signal,
) -> int:
    """Make a node and run it as a process of its own.

    Parameters
    ----------
    make : callable
        Makes the node, in rclpy's default context.
    args : list of str, optional
        Command line, with ``--ros-args``.
    refusals : tuple of exception types
        What the node raises where its parameters or its input are bad.
    drive : callable
        Runs the node in its executor, to its end or until the event is set, and returns the exit
        status; by default its callbacks are run until a signal comes.

    Returns
    -------
    int
        The process's exit status, or 2 where the node refused (one line on stderr).
    """
    try:
        with ros_of_a_lone_node(args) as reach, stop_on_signals() as stop, ExitStack() as stack:
            stack.enter_context(files_of_a_rig(sys.argv if args is None else args))
            node = make()
            stack.callback(node.destroy_node)
            refuse_unknown_parameters(node)
            stack.enter_context(alone_on_its_name(node, reach))
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            return drive(node, executor, stop)
    except (*refusals, InvalidParameterTypeException) as error:
        print(printable(error), file=sys.stderr)
        return BAD_INPUT
