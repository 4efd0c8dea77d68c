"""Keeps a graph to itself: its own context or domain, its own logs."""

import os
import socket
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.claims import claim, full_name, in_use
from worm_msgs_py.ros.network import Reach, dds_settings, environment
from worm_msgs_py.ros.running import TICK_S
from worm_msgs_py.text import printable

# DDS (RTPS 9.6.1): a domain's ports begin at 7400 + 250 * domain. Up to 101 they stay below the
# range that Linux gives to outgoing connections. A participant uses the 10th and 11th port and
# two more for each participant before it, so nobody uses the last one.
_DOMAINS = range(1, 102)
_LAST_DOMAIN = 232
_FIRST_PORT = 7400
_PORTS_PER_DOMAIN = 250
_PARTICIPANTS = 20

_DISCOVERY_S = 4.0
"""A participant announces itself at its start and then every three seconds (Fast DDS)."""


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
def own_context(reach: Reach = Reach.OWN) -> Iterator[Context]:
    """Give a context whose nodes see each other, and are seen as far as `reach` says.

    A graph that others can see applies ROS_DOMAIN_ID, and a Fast DDS profile that the user has set.

    Raises
    ------
    BadInput
        ROS refuses the environment: a domain out of range, a keystore that is not there.
    """
    context = Context()
    with own_logs(), environment(**dds_settings(reach, heed_profile=reach is not Reach.OWN)):
        try:
            rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        except RuntimeError as error:  # rclpy's RCLError
            raise BadInput(f"ROS does not start: {printable(error)}") from None
        try:
            _check_domain(context.get_domain_id())
            yield context
        finally:
            rclpy.try_shutdown(context=context)


def _check_domain(domain: int) -> None:
    """Refuse a domain whose ports do not exist: Fast DDS would end the process."""
    if domain > _LAST_DOMAIN:
        raise BadInput(f"ROS_DOMAIN_ID={domain}: it is a number from 0 to {_LAST_DOMAIN}")


@contextmanager
def alone_on_their_names(
    context: Context, reach: Reach, namespace: str, nodes: Iterable[str]
) -> Iterator[None]:
    """Hold the names of a graph's nodes where others can see it.

    On this machine the lock is sure; on the network whoever is there already is found within the
    time that discovery takes.

    Raises
    ------
    BadInput
        Another graph has these names.
    """
    domain = context.get_domain_id()
    names = [] if reach is Reach.OWN else [full_name(namespace, node) for node in nodes]
    with claim(domain, names):
        if reach is Reach.NETWORK:
            _refuse_where_others_track(context, domain, namespace)
        yield


def _refuse_where_others_track(context: Context, domain: int, namespace: str) -> None:
    probe = Node("probe", context=context, namespace=namespace, start_parameter_services=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(probe)
    try:
        until_s = time.monotonic() + _DISCOVERY_S
        while time.monotonic() < until_s:
            executor.spin_once(timeout_sec=TICK_S)
            if probe.count_publishers(topics.WORM_STATE):
                graph = f"a graph with the topic {full_name(namespace, topics.WORM_STATE)}"
                raise BadInput(in_use(domain, graph))
    finally:
        executor.shutdown()
        probe.destroy_node()


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
