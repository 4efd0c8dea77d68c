"""Nothing leaves the machine, and hypothesis gives the same examples on each machine.

`ros_context` and `run_graph` are those that users have, too: `worm_bringup.pytest_plugin`.
"""

import os
import tempfile

from hypothesis import settings

from worm_msgs_py.ros.network import Reach, dds_settings

os.environ.update(dds_settings(Reach.OWN))
os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp(prefix="worm-test-log-"))

settings.register_profile("worm", deadline=None, derandomize=True)
settings.load_profile("worm")
