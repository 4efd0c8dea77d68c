"""A recorder that writes frame, stamp and checksum of every state into a text file."""

from pathlib import Path

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import UInt64

from worm_msgs_py import convert, topics
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW


class StandInRecorderNode(Node):
    def __init__(self, **kwargs):
        super().__init__("recorder", start_parameter_services=False, **kwargs)
        self.path = Path(self.declare_parameter("out", Parameter.Type.STRING).value)
        self.lines, self.end, self.done = [], None, False
        kind, qos = RESULTS[topics.WORM_STATE]
        self.create_subscription(kind, topics.WORM_STATE, self.on_state, qos)
        self.create_subscription(UInt64, topics.FLOW_END, self.on_end, FLOW)
        self.flow = self.create_publisher(UInt64, topics.FLOW_RECORDED, FLOW)

    @property
    def missing(self):
        return f"{len(self.lines)} of {self.end} frames are recorded"

    def on_state(self, msg):
        state = convert.body_state_from_msg(msg)
        self.lines.append(f"{state.frame} {state.stamp_ns} {state.length_px:.0f}")
        self.flow.publish(convert.count_to_msg(len(self.lines)))
        self.finish_if_whole()

    def on_end(self, msg):
        self.end = convert.count_from_msg(msg)
        self.finish_if_whole()

    def finish_if_whole(self):
        if self.end == len(self.lines) and not self.done:
            self.path.write_text("\n".join(self.lines))
            self.done = True
