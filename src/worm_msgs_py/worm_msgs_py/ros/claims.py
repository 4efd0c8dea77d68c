"""Lets one graph alone have its names in a ROS domain of this machine."""

import hashlib
import socket
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager

from worm_msgs_py.errors import BadInput


def full_name(namespace: str, node: str) -> str:
    """Return a node's name with its namespace, as ROS writes it."""
    return "/" + "/".join(part for part in (*namespace.split("/"), node) if part)


@contextmanager
def claim(domain: int, nodes: Iterable[str]) -> Iterator[None]:
    """Hold the full names of nodes for as long as the block runs.

    Two graphs on the same names feed each other's nodes, and neither comes to its end. The lock is
    a socket in Linux's abstract namespace: of two that start at once one gets it, and the kernel
    frees it even if the process is killed. It holds on this machine (in this network namespace, as
    DDS does).

    Raises
    ------
    BadInput
        Somebody holds one of them.
    """
    with ExitStack() as stack:
        for node in nodes:
            lock = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))
            try:
                lock.bind("\0" + claimed_name(domain, node))
            except OSError:
                raise BadInput(in_use(domain, f"a node {node}")) from None
        yield


def claimed_name(domain: int, node: str) -> str:
    """Return the name in the abstract namespace that stands for a node's."""
    return "worm-escape " + hashlib.sha256(f"{domain} {node}".encode()).hexdigest()


def in_use(domain: int, what: str) -> str:
    """Return the line that says what is there already, and what to do."""
    return (
        f"{what} runs already in ROS domain {domain}: give this graph names of its own, "
        "such as --namespace /rig2 (a node started alone: --ros-args -r __ns:=/rig2), or another "
        "domain, such as ROS_DOMAIN_ID=1"
    )
