"""Fixtures for tests of nodes in this graph; pytest has them wherever this package is installed.

`ros_context` is a context of the test's own, `run_graph` runs a source and other nodes to the end:
README.md has an example. Tests that ask for neither notice one thing alone: rclpy checks the types
of all fields of messages, which it otherwise corrupts on the wire without a word. It reads that
once, when messages are imported, so it is set here; ``ROS_PYTHON_CHECK_FIELDS=0`` turns it off.
"""

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from worm_msgs_py.ros.network import Reach, dds_settings, environment

os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")


@pytest.fixture
def ros_context(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Give a context of the test's own: nothing that others publish reaches it, nothing leaves it.

    Tests with contexts of their own run side by side. Logs go to a directory of the test's.
    """
    import rclpy
    from rclpy.context import Context
    from rclpy.signals import SignalHandlerOptions

    logs = str(tmp_path_factory.mktemp("ros-log"))
    with environment(ROS_LOG_DIR=logs, **dds_settings(Reach.OWN)):
        context = Context()
        rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
        yield context
        rclpy.shutdown(context=context)


@pytest.fixture(name="run_graph")
def run_nodes(ros_context: Any) -> Callable[..., None]:
    """Give a function that runs a source and other nodes, made in `ros_context`, to the end.

    Step and drain: a frame is published when nothing is left to do for the one before, so the
    test needs no sleep and loses nothing, however slow a node is.
    """
    from rclpy.executors import SingleThreadedExecutor

    from worm_tracker.sources.source_node import drain

    def run(source: Any, *nodes: Any) -> None:
        executor = SingleThreadedExecutor(context=ros_context)
        for node in (source, *nodes):
            executor.add_node(node)
        try:
            drain(executor)
            while source.publish_next():
                drain(executor)
            drain(executor)
        finally:
            executor.shutdown()
            for node in (source, *nodes):
                node.destroy_node()

    return run
