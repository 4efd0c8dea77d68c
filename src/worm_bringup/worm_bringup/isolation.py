"""Keeps a graph to itself: its own context or domain, its own logs, its own memory habits."""

import ctypes
import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

# glibc's malloc.h, and what the parameters are set to.
_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_MMAP_THRESHOLD = -1, -2, -3
_GIBIBYTE = 1 << 30

# DDS (RTPS 9.6.1): a domain's ports begin at 7400 + 250 * domain. Up to 101 they stay below the
# range that Linux gives to outgoing connections. A participant uses the 10th and 11th port and
# two more for each participant before it, so nobody uses the last one.
_DOMAINS = range(1, 102)
_FIRST_PORT = 7400
_PORTS_PER_DOMAIN = 250
_PARTICIPANTS = 20


@contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set environment variables for as long as the block runs."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def own_logs() -> Iterator[str]:
    """Keep rcl's log files in a folder that goes with the block, unless ROS_LOG_DIR is set.

    Otherwise every process leaves a file in ~/.ros/log, and there are hundreds after a day.
    """
    chosen = os.environ.get("ROS_LOG_DIR")
    if chosen:
        yield chosen
        return
    with (
        tempfile.TemporaryDirectory(prefix="worm-log-", ignore_cleanup_errors=True) as folder,
        environment(ROS_LOG_DIR=folder),
    ):
        yield folder


@contextmanager
def own_context(*, visible: bool = False) -> Iterator[Context]:
    """Give a context whose nodes see each other and nobody else.

    Parameters
    ----------
    visible : bool
        Let the graph be seen by other programs (Foxglove, ``ros2 topic``), as the variables
        ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE of the environment say.
    """
    context = Context()
    reach = {} if visible else {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    with own_logs(), environment(**reach):
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        try:
            yield context
        finally:
            rclpy.try_shutdown(context=context)


@contextmanager
def free_domain() -> Iterator[int]:
    """Give a ROS domain id that no one on this machine uses, and keep it for the block.

    The last port of the domain is the lock: the kernel frees it even if the process is killed.

    Raises
    ------
    RuntimeError
        Every domain is in use.
    """
    start = os.getpid() % len(_DOMAINS)
    for domain in (*_DOMAINS[start:], *_DOMAINS[:start]):
        first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain
        lock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with lock:
            try:
                lock.bind(("127.0.0.1", first + _PORTS_PER_DOMAIN - 1))
                _try_ports(range(first + 10, first + 10 + 2 * _PARTICIPANTS))
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError("every ROS domain of this machine is in use")


def _try_ports(ports: range) -> None:
    for port in ports:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("", port))


def keep_freed_memory() -> None:
    """Let glibc keep freed buffers of a picture's size; elsewhere do nothing.

    By default it maps each one anew and gives it back, which costs more than copying the picture.
    """
    with suppress(OSError, AttributeError):
        libc = ctypes.CDLL("libc.so.6")
        libc.mallopt(_M_MMAP_THRESHOLD, _GIBIBYTE)
        libc.mallopt(_M_TRIM_THRESHOLD, _GIBIBYTE)
        libc.mallopt(_M_TOP_PAD, 64 << 20)
