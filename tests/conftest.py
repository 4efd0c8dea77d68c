"""Every test has its own rclpy context, and rclpy checks every field that it is given."""

import os
import tempfile

from worm_msgs_py.ros.network import Reach, dds_settings

# Before rclpy is imported: read once, at import.
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
os.environ.update(dds_settings(Reach.OWN))
os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp(prefix="worm-test-log-"))

import pytest
import rclpy
from hypothesis import settings
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from worm_tracker.sources.source_node import drain

settings.register_profile("worm", deadline=None, derandomize=True)
settings.load_profile("worm")


@pytest.fixture
def ros_context():
    """A context of the test's own: nothing that other tests publish can reach it."""
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    yield context
    rclpy.shutdown(context=context)


@pytest.fixture
def run_graph(ros_context):
    """Give a function that runs a source and other nodes, made in `ros_context`, to the end.

    Step and drain: a frame is published when nothing is left to do for the one before, so the
    test needs no sleep and loses nothing.
    """

    def run(source, *nodes):
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
