"""Finds a camera driver that is not ours on its topic, and hears it as it wants to be heard."""

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from sensor_msgs.msg import CompressedImage, Image

from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.running import TICK_S, stop_on_signals

_MESSAGES = {"sensor_msgs/msg/Image": Image, "sensor_msgs/msg/CompressedImage": CompressedImage}
_DISCOVERY_TICKS = 100
"""Ten seconds: a driver with default settings and our graph find each other within three."""
_SETTLED_TICKS = 20
"""Two seconds: we announce ourselves once a second, and every driver on this machine answers."""
_NOT_YET_NAMED = "_NODE_NAME_UNKNOWN_"
"""rmw's name of a node whose publisher is known before it is: nodes are told by a topic."""


def hear_driver(node: Node, topic: str, take: Callable[[Any, int], None], depth: int) -> None:
    """Hear the one driver that publishes pictures on a topic, from now on.

    The subscription is as reliable as the driver: of one that offers best effort a reliable one
    would get nothing, without a word.

    Parameters
    ----------
    take : callable
        Given each message, and the number that DDS gave it among those of its publisher.
    depth : int
        Messages that may wait.

    Raises
    ------
    BadInput
        Nobody, or more than one, publishes pictures there; or it is a topic of this graph.
    """
    if topic in _own_topics(node):
        raise BadInput(
            f"{topic}: this graph sends its own pictures there: give it other names, such as "
            "--namespace /worm"
        )
    driver = _find_driver(node, topic)
    reliable = driver.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    qos = QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.VOLATILE,
    )

    def on_message(message: Image | CompressedImage, info: dict[str, int]) -> None:
        take(message, info["publication_sequence_number"])

    Node.create_subscription(  # not WormNode's: it keeps the numbers to itself
        node,
        _MESSAGES[driver.topic_type],
        topic,
        on_message,
        qos,
        event_callbacks=SubscriptionEventCallbacks(),  # it warns of a partner it cannot hear
    )


def _own_topics(node: Node) -> list[str]:
    return [node.resolve_topic_name(name) for name in (topics.IMAGE, topics.IMAGE_COMPRESSED)]


def _find_driver(node: Node, topic: str) -> TopicEndpointInfo:
    """Return the one publisher of pictures on a topic; wait until it is found."""
    found = _wait_for_publishers(node, topic)
    if not found:
        raise BadInput(f"{topic}: nobody publishes there; {_whats_there(node)}")
    if len(found) > 1:
        nodes = " and ".join(sorted(_shown_name(one) for one in found))
        raise BadInput(f"{topic}: {nodes} publish there; a trial has one camera")
    if found[0].topic_type not in _MESSAGES:
        raise BadInput(
            f"{topic}: is of type {found[0].topic_type}; pictures are {' or '.join(_MESSAGES)}"
        )
    return found[0]


def _wait_for_publishers(node: Node, topic: str) -> list[TopicEndpointInfo]:
    """Return who publishes on a topic: two at once, one alone after two seconds of no other."""
    found: list[TopicEndpointInfo] = []
    alone_ticks = 0
    with stop_on_signals() as stop:
        for _ in range(_DISCOVERY_TICKS):
            found = node.get_publishers_info_by_topic(topic)
            alone_ticks = alone_ticks + 1 if len(found) == 1 else 0
            is_all = len(found) > 1 or alone_ticks > _SETTLED_TICKS
            is_named = all(one.node_name != _NOT_YET_NAMED for one in found)
            if (is_all and is_named) or stop.wait(TICK_S):
                break
        if stop.is_set():
            raise KeyboardInterrupt
    return found


def _shown_name(publisher: TopicEndpointInfo) -> str:
    is_named = publisher.node_name != _NOT_YET_NAMED
    return publisher.node_name if is_named else "a node without a known name"


def _whats_there(node: Node) -> str:
    there = sorted(
        name
        for name, types in node.get_topic_names_and_types()
        if any(kind in _MESSAGES for kind in types) and name not in _own_topics(node)
    )
    return (
        f"pictures are on {', '.join(there)}"
        if there
        else "does the driver run, on this machine, with the same ROS_DOMAIN_ID?"
    )
