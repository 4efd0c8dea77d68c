"""`worm doctor`: tells whether this machine has what the graph needs."""

import os
import shutil
import sys
from collections.abc import Callable
from importlib.metadata import version

import typer
from rich.table import Table
from rich.text import Text

from worm_bringup.cli.terminal import Terminal

_SHM_MB = 64
_MEGABYTE = 1 << 20


def doctor() -> None:
    """Check Python, ROS, OpenCV and shared memory; say what to do about what is not right."""
    table = Table("check", "", "found")
    healthy = True
    for name, check in _CHECKS.items():
        try:
            found, good = check(), True
        except Exception as error:  # a check's failure is its result
            found, good = f"{type(error).__name__}: {error}", False
        healthy &= good
        table.add_row(name, Text("ok", "green") if good else Text("no", "red"), found)
    Terminal().print(table)
    if not healthy:
        raise typer.Exit(1)


def _python() -> str:
    return sys.version.split()[0]


def _rclpy() -> str:
    from rclpy.utilities import get_rmw_implementation_identifier

    from worm_bringup.graph.ros_environment import own_context

    with own_context():
        rmw = get_rmw_implementation_identifier()
    return f"{version('ros-jazzy-rclpy')}, {rmw}"


def _message_delivery() -> str:
    """Send a picture through a context of its own, and compare what comes out."""
    import numpy as np
    from sensor_msgs.msg import Image

    from worm_bringup.graph.ros_environment import own_context
    from worm_msgs_py.convert import picture_to_msg
    from worm_msgs_py.ros.qos import IMAGE_REPLAY

    picture = np.arange(256, dtype=np.uint8).reshape(16, 16)
    received: list[bytes] = []
    with own_context() as context:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        node = Node("doctor", context=context, start_parameter_services=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        node.create_subscription(
            Image, "picture", lambda msg: received.append(bytes(msg.data)), IMAGE_REPLAY
        )
        node.create_publisher(Image, "picture", IMAGE_REPLAY).publish(picture_to_msg(picture, 0))
        executor.spin_once(timeout_sec=5.0)
        executor.shutdown()
        node.destroy_node()
    if received != [picture.tobytes()]:
        raise RuntimeError("a picture that was published did not come: check ROS_* variables")
    return "a picture went through"


def _opencv() -> str:
    import cv2

    backends = [
        cv2.videoio_registry.getBackendName(backend)
        for backend in cv2.videoio_registry.getBackends()
    ]
    return f"{cv2.__version__}; cameras through {', '.join(backends)}"


def _shared_memory() -> str:
    free_mb = shutil.disk_usage("/dev/shm").free // _MEGABYTE
    if free_mb < _SHM_MB:
        raise RuntimeError(
            f"{free_mb} MB free in /dev/shm, --processes needs {_SHM_MB}: remove stale segments"
        )
    return f"{free_mb} MB free in /dev/shm"


def _domain() -> str:
    names = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "RMW_IMPLEMENTATION")
    given = [f"{name}={os.environ[name]}" for name in names if name in os.environ]
    return ", ".join(given) or "no ROS variable is set"


_CHECKS: dict[str, Callable[[], str]] = {
    "Python": _python,
    "rclpy": _rclpy,
    "messages": _message_delivery,
    "OpenCV": _opencv,
    "shared memory": _shared_memory,
    "ROS variables": _domain,
}
