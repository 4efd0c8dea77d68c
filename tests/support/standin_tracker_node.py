"""A tracker that does nothing but take its time, hold frames back, and sum the pictures up."""

import time
import zlib

from rclpy.node import Node
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import UInt64, UInt64MultiArray

from worm_msgs_py import BodyState, convert, topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, IMAGE_REPLAY
from worm_tracker.sources.image_decoder import PictureDecoder


class StandInTrackerNode(Node):
    def __init__(self, **kwargs):
        super().__init__("tracker", start_parameter_services=False, **kwargs)
        self.delay_s = self.declare_parameter("delay_s", 0.0).value
        self.hold = self.declare_parameter("hold", 0).value
        self.fail_at = self.declare_parameter("fail_at", -1).value
        self.decoder = PictureDecoder()
        self.held, self.taken, self.given, self.end = [], 0, 0, None
        kind, qos = RESULTS[topics.WORM_STATE]
        self.states = self.create_publisher(kind, topics.WORM_STATE, qos)
        self.flow = self.create_publisher(UInt64MultiArray, topics.FLOW_TRACKED, FLOW)
        for kind, topic in ((Image, topics.IMAGE), (CompressedImage, topics.IMAGE_COMPRESSED)):
            self.create_subscription(kind, topic, self.on_picture, IMAGE_REPLAY)
        self.create_subscription(UInt64, topics.FLOW_END, self.on_end, FLOW)

    @property
    def done(self):
        return self.end is not None and self.taken == self.end and not self.held

    @property
    def missing(self):
        return f"{self.taken} of {self.end} frames are taken, {len(self.held)} are held"

    def on_picture(self, msg):
        if self.taken == self.fail_at:
            raise BadInput("frame 3: no chamber is found; try --no-chamber")
        time.sleep(self.delay_s)
        picture = self.decoder.decode(msg)
        self.held.append(
            BodyState(
                frame=self.taken,
                stamp_ns=convert.stamp_to_ns(msg.header.stamp),
                length_px=float(zlib.crc32(picture.tobytes())),
            )
        )
        self.taken += 1
        if len(self.held) > self.hold or self.taken == self.end:
            self.give()
        self.flow.publish(convert.counts_to_msg((self.taken, self.given)))

    def on_end(self, msg):
        self.end = convert.count_from_msg(msg)
        if self.taken == self.end:
            self.give()
            self.flow.publish(convert.counts_to_msg((self.taken, self.given)))

    def give(self):
        for state in self.held:
            self.states.publish(convert.body_state_to_msg(state))
        self.given += len(self.held)
        self.held = []
