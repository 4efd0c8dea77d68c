"""A server that Foxglove connects to, by Foxglove's own SDK, which is an optional dependency."""

import json
from collections.abc import Mapping
from threading import Lock
from typing import Any

from worm_bringup.overlay.plain_numbers import SCHEMAS
from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC, TYPES
from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput

DEFAULT_PORT = 8765
FORWARDED = {
    topics.WORM_STATE: "sensor_msgs/msg/JointState",
    topics.WORM_MIDLINE: "sensor_msgs/msg/PointCloud2",
    topics.ANALYSIS_STATE: "sensor_msgs/msg/JointState",
    topics.ANALYSIS_CORRELATION: "trajectory_msgs/msg/JointTrajectory",
    topics.CHAMBER: "visualization_msgs/msg/MarkerArray",
}
"""Served as they are on the graph and in bags, so that one layout does for both."""
SERVED: Mapping[str, str] = {
    **FORWARDED,
    **TYPE_OF_TOPIC,
    topics.IMAGE_COMPRESSED: "sensor_msgs/msg/CompressedImage",
}
"""Type of each topic of ROS messages that is served; beside them, JSON: `plain_numbers.SCHEMAS`."""
_SENT_ONCE = (topics.TF_STATIC, topics.CHAMBER)


class FoxgloveServer:
    """Serves topics without a namespace: a rig has a port of its own.

    Parameters
    ----------
    host : str
        Address to listen at; ``127.0.0.1`` is this machine alone.
    port : int
        0: any that is free.

    Attributes
    ----------
    address : str
        What Foxglove is to open.

    Raises
    ------
    BadInput
        The SDK is not installed, or the address is taken or not this machine's.
    """

    def __init__(self, host: str, port: int) -> None:
        try:
            import foxglove
            from foxglove.websocket import Capability
        except ImportError:
            raise BadInput(
                "Foxglove is served by the package foxglove-sdk, which is not installed: "
                "pip install 'worm-escape[foxglove]'"
            ) from None
        self._kept: dict[str, tuple[bytes, int]] = {}
        self._lock = Lock()
        context = self._context = foxglove.Context()  # which its channels end with
        self._channels = {
            topic: foxglove.Channel(
                "/" + topic,
                schema=_foxglove_schema(foxglove, kind),
                message_encoding="cdr",
                context=context,
            )
            for topic, kind in SERVED.items()
        }
        for topic, schema in SCHEMAS.items():
            self._channels[topic] = foxglove.Channel("/" + topic, schema=schema, context=context)
        try:
            self._server = foxglove.start_server(
                name="worm-escape",
                host=host,
                port=port,
                capabilities=[Capability.Time],
                server_listener=self,
                context=context,
            )
        except RuntimeError as error:
            why = str(error).rpartition(": ")[2]
            raise BadInput(
                f"Foxglove cannot be served at {host}:{port} ({why}): choose another "
                "--foxglove-host or --foxglove-port"
            ) from None
        self.address = f"ws://{host}:{self._server.port}"

    @property
    def watched(self) -> set[str]:
        """The topics that somebody looks at, as they are shown: with a slash."""
        return {"/" + topic for topic in self._channels if self.wants(topic)}

    def wants(self, topic: str) -> bool:
        """Tell whether somebody looks at a topic."""
        return bool(self._channels[topic].has_sinks())

    def send(self, topic: str, message: bytes | Mapping[str, Any], stamp_ns: int) -> None:
        """Send a serialised message, or a mapping as JSON; the server's clock follows the stamps.

        The SDK hands it to each client's own queue and drops the oldest where one is slow.
        """
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        if topic in _SENT_ONCE:
            with self._lock:
                self._kept[topic] = data, stamp_ns
        self._channels[topic].log(data, log_time=stamp_ns)

    def tell_time(self, stamp_ns: int) -> None:
        """Tell clients what time it is."""
        self._server.broadcast_time(stamp_ns)

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """Send a client that comes late what is sent once; called by the SDK."""
        topic = channel.topic.removeprefix("/")
        with self._lock:
            kept = self._kept.get(topic)
        if kept is not None:
            self._channels[topic].log(kept[0], log_time=kept[1])

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """Do nothing; called by the SDK."""

    def close(self) -> None:
        """End the server."""
        self._server.stop()


def _foxglove_schema(foxglove: Any, kind: str) -> Any:
    definition, _ = TYPES.generate_msgdef(kind, ros_version=2)
    return foxglove.Schema(name=kind, encoding="ros2msg", data=definition.encode())
