"""An operator: asks the tracker to exchange head and tail once it has taken some frames."""

from rclpy.node import Node
from std_msgs.msg import UInt64MultiArray
from std_srvs.srv import Trigger

from worm_msgs_py import convert, topics
from worm_msgs_py.ros.qos import FLOW


class AskingNode(Node):
    """Calls `swap_head` of the tracker after the frames of its parameter `after_frames`."""

    def __init__(self, **node_arguments):
        super().__init__("asker", start_parameter_services=False, **node_arguments)
        self._after = list(self.declare_parameter("after_frames", [0]).value)
        self._swap = self.create_client(Trigger, "tracker/swap_head")
        self.create_subscription(UInt64MultiArray, topics.FLOW_TRACKED, self._on_tracked, FLOW)

    def _on_tracked(self, msg):
        taken, _ = convert.counts_from_msg(msg)
        if self._after and taken > self._after[0]:
            self._after.pop(0)
            self._swap.call_async(Trigger.Request())
