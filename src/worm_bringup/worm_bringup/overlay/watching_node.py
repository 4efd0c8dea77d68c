"""The base of nodes that only look: they take what they can, in a thread, and delay nobody."""

from collections.abc import Callable
from functools import partial
from threading import Event, Thread
from typing import Any

import cv2
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage, Image, JointState, PointCloud2

from worm_bringup.overlay.frame_join import JoinedFrame
from worm_bringup.overlay.latest_frames import LatestFrames, Parts
from worm_msgs_py import Geometry, convert, limits, topics
from worm_msgs_py.arrays import Picture
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput, BadPicture, MalformedMessage
from worm_msgs_py.ros.qos import LATCHED, VIEW
from worm_msgs_py.ros.worm_node import WormNode
from worm_msgs_py.text import printable
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE, IMAGE_TYPE, Grey, PictureDecoder

PICTURE = "picture"
"""Stands for whichever of the two topics the pictures come on."""
_OF_PICTURES = {
    topics.IMAGE: (Image, IMAGE_TYPE),
    topics.IMAGE_COMPRESSED: (CompressedImage, COMPRESSED_TYPE),
}
TRACKED = {topics.WORM_STATE: JointState, topics.WORM_MIDLINE: PointCloud2}
"""What the tracker says of a frame."""

OF_JPEG = Declaration(
    "jpeg_quality",
    85,
    "Of the pictures that are sent: 100 is nearly as they were.",
    limits.JPEG_QUALITY,
)


class WatchingNode(WormNode):
    """Keeps the newest whole frame and shows it in a thread of its own.

    A callback only puts serialised messages down, so that the graph, which waits for callbacks,
    waits for neither drawing nor encoding nor a slow viewer: these see fewer frames.
    """

    def __init__(self, name: str, **node_arguments: Any) -> None:
        super().__init__(name, **node_arguments)
        self.geometries: dict[int, Geometry] = {}
        self._frames = LatestFrames(())
        self.picture_type = ""
        self._decoder = PictureDecoder()
        self._listening: list[Any] = []
        self._wake, self._ended = Event(), Event()
        self._worker = Thread(target=self._work, name=name, daemon=True)
        self._worker.start()

    def show(self) -> None:
        """Show what is new; called in the node's own thread."""
        raise NotImplementedError

    def listen(self, *, pictures: bool, whole_with_picture: bool) -> None:
        """Follow the graph from now on.

        Parameters
        ----------
        pictures : bool
            Whether the pictures are needed.
        whole_with_picture : bool
            Whether a frame is whole with its picture alone.
        """
        self.stop_listening()
        self._frames = LatestFrames([*TRACKED, PICTURE] if whole_with_picture else TRACKED)
        take = self.create_subscription
        on_geometry = self._on_geometry
        self._listening.append(take(JointState, topics.CHAMBER_GEOMETRY, on_geometry, LATCHED))
        for topic, kind in TRACKED.items():
            self.hear(kind, topic, partial(self.on_part, topic))
        if pictures:
            for topic, (kind, name) in _OF_PICTURES.items():
                self.hear(kind, topic, partial(self.on_picture, name))

    def hear(self, kind: type, topic: str, callback: Callable[[bytes], None]) -> None:
        """Subscribe to a topic's serialised messages, until `stop_listening`."""
        self._listening.append(self.create_subscription(kind, topic, callback, VIEW, raw=True))

    def stop_listening(self) -> None:
        """Follow the graph no more."""
        for subscription in self._listening:
            self.destroy_subscription(subscription)
        self._listening = []

    def on_picture(self, message_type: str, data: bytes) -> None:
        """Take a serialised picture."""
        self.picture_type = message_type
        self.on_part(PICTURE, data)

    def jpeg(self, picture: Picture) -> bytes:
        """Return a picture, grey or in colour (blue, green, red), as JPEG."""
        quality = [cv2.IMWRITE_JPEG_QUALITY, self.read_parameter(OF_JPEG.name)]
        return bytes(cv2.imencode(".jpg", picture, quality)[1].tobytes())

    def on_part(self, topic: str, data: bytes) -> None:
        """Take a part of a frame."""
        try:
            if self._frames.add(topic, data):
                self.wake()
        except ValueError as error:
            raise MalformedMessage(str(error)) from None

    def wake(self) -> None:
        """Let the node's thread see what is new."""
        self._wake.set()

    def take_frame(self) -> tuple[JoinedFrame, Parts] | None:
        """Return the newest whole frame and its messages, once."""
        taken = self._frames.take()
        if taken is None:
            return None
        _, parts = taken
        messages = {topic: deserialize_message(parts[topic], TRACKED[topic]) for topic in TRACKED}
        state = convert.body_state_from_msg(messages[topics.WORM_STATE])
        midline = convert.midline_from_msg(messages[topics.WORM_MIDLINE])
        latest = max(list(self.geometries), default=0)  # callbacks add to it meanwhile
        geometry = self.geometries.get(state.geometry or latest)
        return JoinedFrame(state, midline, geometry), parts

    def decoded(self, data: bytes) -> Grey | None:
        """Return a serialised picture's grey levels; None where it cannot be read."""
        try:
            return self._decoder.decode(read_picture(data, self.picture_type))
        except (BadInput, BadPicture, ValueError):
            return None

    def _on_geometry(self, msg: JointState) -> None:
        geometry = convert.geometry_from_msg(msg)
        self.geometries[geometry.version] = geometry

    def _work(self) -> None:
        while not self._ended.is_set():
            self._wake.wait()
            self._wake.clear()
            if self._ended.is_set():
                return
            try:
                self.show()
            except MalformedMessage:
                continue  # not the graph's; the others count it
            except Exception as error:  # a viewer that fails must not end a trial
                why = printable(f"{type(error).__name__}: {error}")
                self.get_logger().error(f"shows nothing any more: {why}")
                return

    def destroy_node(self) -> None:
        """End the thread first: it publishes."""
        self._ended.set()
        self.wake()
        self._worker.join()
        super().destroy_node()
