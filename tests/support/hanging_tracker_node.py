"""A tracker that hangs at a frame: asleep, busy in Python, or deaf to all but SIGKILL."""

import threading
import time

from rclpy.node import Node
from sensor_msgs.msg import Image
from std_msgs.msg import UInt64MultiArray

from worm_msgs_py import convert, topics
from worm_msgs_py.ros.qos import FLOW, IMAGE_REPLAY


class HangingTrackerNode(Node):
    def __init__(self, **kwargs):
        super().__init__("tracker", start_parameter_services=False, **kwargs)
        self.way = self.declare_parameter("way", "asleep").value
        self.hang_at = self.declare_parameter("hang_at", 3).value
        self.taken, self.done = 0, False
        self.flow = self.create_publisher(UInt64MultiArray, topics.FLOW_TRACKED, FLOW)
        self.create_subscription(Image, topics.IMAGE, self.on_picture, IMAGE_REPLAY)

    def on_picture(self, msg):
        self.taken += 1
        while self.taken == self.hang_at:
            if self.way == "asleep":
                time.sleep(1000.0)
            elif self.way == "locked":
                threading.Event().wait()
        self.flow.publish(convert.counts_to_msg((self.taken, self.taken)))
