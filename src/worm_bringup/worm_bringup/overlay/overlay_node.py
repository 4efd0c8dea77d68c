"""Node `overlay`: the pictures with what was found drawn over them, while somebody looks."""

import sys
from importlib import import_module
from typing import Any

from sensor_msgs.msg import CompressedImage

from worm_bringup.overlay.drawing import draw_over
from worm_bringup.overlay.shapes import shapes_of
from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC
from worm_bringup.overlay.views import FrameViews
from worm_bringup.overlay.watching_node import OF_JPEG, PICTURE, WatchingNode
from worm_msgs_py import convert, topics
from worm_msgs_py.ros.qos import IMAGE_REPLAY, LATCHED, RESULT
from worm_msgs_py.ros.running import run_alone

_LOOK_EVERY_S = 0.5
"""How often it looks whether somebody looks."""
_FORM = "bgr8; jpeg compressed bgr8"


class OverlayNode(WatchingNode):
    """Publishes `worm/overlay/compressed` (JPEG) of the newest frame.

    `tf_static`, `tf` and `worm/annotations` too, where `tf2_msgs` and `foxglove_msgs` can be
    imported: there are no wheels, a full ROS 2 installation has them. Where nobody subscribes it
    listens to nothing.
    """

    PARAMETERS = (OF_JPEG,)

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("overlay", **node_arguments)
        self._views = FrameViews()
        self._wanted: frozenset[str] = frozenset()
        kind, topic = CompressedImage, topics.WORM_OVERLAY
        self._out = {topic: self.create_publisher(kind, topic, IMAGE_REPLAY)}
        for topic, name in TYPE_OF_TOPIC.items():
            found = None if topic == topics.CAMERA_INFO else _importable(name)
            if found is not None:
                qos = LATCHED if topic == topics.TF_STATIC else RESULT
                self._out[topic] = self.create_publisher(found, topic, qos)
        self.create_timer(_LOOK_EVERY_S, self._look_for_watchers)

    def _look_for_watchers(self) -> None:
        wanted = frozenset(
            topic for topic, publisher in self._out.items() if publisher.get_subscription_count()
        )
        if wanted != self._wanted:
            self._wanted = wanted
            drawn = topics.WORM_OVERLAY in wanted
            if wanted:
                self.listen(pictures=drawn, whole_with_picture=drawn)
            else:
                self.stop_listening()

    def show(self) -> None:
        """Publish what is wanted of the newest frame."""
        taken = self.take_frame()
        if taken is None:
            return
        frame, parts = taken
        for topic, data in self._views.of(frame):
            if topic in self._out:
                self._out[topic].publish(data)
        grey = self.decoded(parts[PICTURE]) if PICTURE in parts else None
        if grey is not None:
            shapes = shapes_of(frame.state, frame.midline, frame.geometry)
            file = self.jpeg(draw_over(grey, shapes))
            message = convert.compressed_to_msg(file, _FORM, frame.state.stamp_ns)
            self._out[topics.WORM_OVERLAY].publish(message)


def _importable(name: str) -> Any:
    """Return a message class by its type's name; None where its package is not installed."""
    package, _, kind = name.split("/")
    try:
        return getattr(import_module(f"{package}.msg"), kind)
    except ImportError:
        return None


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(OverlayNode, args)


if __name__ == "__main__":
    sys.exit(main())
