"""Nothing leaves the machine, hypothesis gives the same examples on each, and work is shared.

`ros_context` and `run_graph` are those that users have, too: `worm_bringup.pytest_plugin`.
"""

import atexit
import os
import shutil
import tempfile

import pytest
from hypothesis import settings

from worm_msgs_py.ros.network import Reach, dds_settings

os.environ.update(dds_settings(Reach.OWN))
if "ROS_LOG_DIR" not in os.environ:  # a worker writes where the process that starts it does
    os.environ["ROS_LOG_DIR"] = tempfile.mkdtemp(prefix="worm-test-log-")
    atexit.register(shutil.rmtree, os.environ["ROS_LOG_DIR"], ignore_errors=True)

settings.register_profile("worm", deadline=None, derandomize=True)
settings.load_profile("worm")


SHORT = ("worm_analysis", "worm_model", "worm_msgs_py", "worm_tracker")
"""Folders whose modules take seconds; those of the others run whole commands for up to minutes."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Keep the tests of a module on one worker, so that what they share is made once.

    Long modules come first: workers that begin with them end together.
    """
    items.sort(key=lambda item: any(f"{folder}/" in item.location[0] for folder in SHORT))
    for item in items:
        if item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.location[0]))
