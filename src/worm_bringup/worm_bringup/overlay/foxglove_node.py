"""Node `foxglove`: serves what is seen to Foxglove: pictures, annotations, frames, numbers."""

import sys
from functools import partial
from threading import Lock
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from worm_bringup.overlay.foxglove_server import DEFAULT_PORT, FoxgloveServer
from worm_bringup.overlay.plain_numbers import (
    CORRELATION_TOPIC,
    NUMBERS_TOPIC,
    curve_of,
    numbers_of,
)
from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC
from worm_bringup.overlay.views import FrameViews
from worm_bringup.overlay.watching_node import OF_JPEG, PICTURE, WatchingNode
from worm_msgs_py import convert, topics
from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.ros.network import LOOPBACK
from worm_msgs_py.ros.qos import LATCHED
from worm_msgs_py.ros.running import run_alone
from worm_tracker.sources.bags.serialized_images import stamp_of, with_frame_id
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE

PORT = Limit(0, 65535)
_OF_FRAMES = tuple(TYPE_OF_TOPIC)


class FoxgloveNode(WatchingNode):
    """Serves the newest of everything; Foxglove opens a WebSocket connection to it.

    The topics of ROS messages have the names and types that they have in bags; `analysis/numbers`
    and `analysis/C_theta` are plain JSON with units in the names.

    Raises
    ------
    BadInput
        As `FoxgloveServer`.
    """

    PARAMETERS = (
        Declaration("host", LOOPBACK, "Address to listen at; 127.0.0.1 is this machine alone."),
        Declaration("port", DEFAULT_PORT, "Port to listen at; 0: any that is free.", PORT),
        OF_JPEG,
    )

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("foxglove", **node_arguments)
        try:
            self._server = FoxgloveServer(self.read_parameter("host"), self.read_parameter("port"))
        except BaseException:
            self.destroy_node()
            raise
        self.get_logger().info(f"Foxglove: open the connection {self._server.address}")
        self._now_ns = 0
        self._views, self._news, self._lock = FrameViews(), dict[str, bytes](), Lock()
        self.listen(pictures=True, whole_with_picture=False)
        self.hear(JointState, topics.ANALYSIS_STATE, partial(self._put, topics.ANALYSIS_STATE))
        curve = topics.ANALYSIS_CORRELATION
        self.hear(JointTrajectory, curve, partial(self._put, curve))
        walls = partial(self._put, topics.CHAMBER)
        self.create_subscription(MarkerArray, topics.CHAMBER, walls, LATCHED, raw=True)

    @property
    def address(self) -> str:
        """What Foxglove is to open."""
        return self._server.address

    @property
    def watched(self) -> set[str]:
        """The topics that somebody looks at, as they are shown."""
        return self._server.watched

    def on_part(self, topic: str, data: bytes) -> None:
        """Take a part of a frame, which is also sent as it is; pictures wait for nothing."""
        if topic != PICTURE:
            super().on_part(topic, data)
        self._put(topic, data)

    def _put(self, topic: str, data: bytes) -> None:
        with self._lock:
            self._news[topic] = data
        self.wake()

    def show(self) -> None:
        """Send what is new."""
        with self._lock:
            news, self._news = self._news, {}
        stamps = [stamp_of(data) for topic, data in news.items() if topic != topics.CHAMBER]
        self._now_ns = max([self._now_ns, *stamps])
        self._server.tell_time(self._now_ns)
        for topic, data in news.items():
            self._send(topic, data)
        taken = self.take_frame() if any(map(self._server.wants, _OF_FRAMES)) else None
        if taken is not None:
            frame, _ = taken
            for topic, data in self._views.of(frame):
                self._server.send(topic, data, frame.state.stamp_ns)

    def _send(self, topic: str, data: bytes) -> None:
        """Send one message of the graph."""
        send = self._server.send
        if topic == topics.CHAMBER:  # has no stamp of its own
            send(topic, data, self._now_ns)
        elif topic == PICTURE:
            if self._server.wants(topics.IMAGE_COMPRESSED):
                self._send_picture(data)
        else:
            send(topic, data, stamp_of(data))
            if topic == topics.ANALYSIS_STATE and self._server.wants(NUMBERS_TOPIC):
                observables = convert.observables_from_msg(deserialize_message(data, JointState))
                send(NUMBERS_TOPIC, numbers_of(observables), stamp_of(data))
            if topic == topics.ANALYSIS_CORRELATION and self._server.wants(CORRELATION_TOPIC):
                curve = convert.correlation_from_msg(deserialize_message(data, JointTrajectory))
                send(CORRELATION_TOPIC, curve_of(curve), stamp_of(data))

    def _send_picture(self, data: bytes) -> None:
        """Send a picture: as it is where it is a file, otherwise as JPEG."""
        stamp_ns = stamp_of(data)
        if self.picture_type == COMPRESSED_TYPE:
            self._server.send(topics.IMAGE_COMPRESSED, with_frame_id(data, CAMERA), stamp_ns)
            return
        grey = self.decoded(data)
        if grey is not None:
            message = convert.compressed_to_msg(self.jpeg(grey), "jpeg", stamp_ns)
            raw = bytes(serialize_message(message))
            self._server.send(topics.IMAGE_COMPRESSED, raw, stamp_ns)

    def destroy_node(self) -> None:
        """End the server as well."""
        super().destroy_node()
        if hasattr(self, "_server"):
            self._server.close()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(FoxgloveNode, args, refusals=(BadInput,))


if __name__ == "__main__":
    sys.exit(main())
