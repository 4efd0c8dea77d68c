"""Publishers that count, so that the recorder can prove that nothing was lost on the way.

DDS orders messages within a topic, not between topics: that a node's last state has come says
nothing of its last event. So each node, as it finishes, announces how many messages it has sent on
each topic, and the recorder is done when it holds exactly as many.
"""

from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.qos import QoSProfile

from worm_msgs_py import topics
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros import interfaces
from worm_msgs_py.ros.qos import FLOW
from worm_msgs_py.ros.worm_node import WormNode

_FINISHED = "finished"
_IGNORED = "ignored "


class CountingPublisher:
    """A publisher that knows how many messages it has sent."""

    def __init__(self, ledger: "Ledger", publisher: Any, topic: str):
        self._ledger, self._publisher, self._topic = ledger, publisher, topic
        ledger.sent[topic] = 0

    @property
    def sent(self) -> int:
        """How many messages were published."""
        return self._ledger.sent[self._topic]

    def publish(self, msg: Any) -> None:
        """Publish a message, or its serialised bytes, and count it."""
        self._publisher.publish(msg)
        self._ledger.sent[self._topic] += 1


class Ledger:
    """All result topics of one node, and its announcement at the end.

    Attributes
    ----------
    sent : dict
        How many messages were published, by topic.
    """

    def __init__(self, node: WormNode):
        self._node = node
        self.sent: dict[str, int] = {}
        self._announcement = node.create_publisher(DiagnosticStatus, topics.FLOW_FINISHED, FLOW)

    def publisher(self, kind: type, topic: str, qos: QoSProfile) -> CountingPublisher:
        """Create a publisher of a result topic (one of `interfaces.RESULTS`)."""
        return CountingPublisher(self, self._node.create_publisher(kind, topic, qos), topic)

    def announce(self) -> None:
        """Say that this node has finished, and what it has sent. Once, after the last message."""
        self._announcement.publish(
            DiagnosticStatus(
                level=DiagnosticStatus.OK,
                name=str(self._node.get_name()),
                message=_FINISHED,
                values=[
                    KeyValue(key=topic, value=str(count))
                    for counts, prefix in ((self.sent, ""), (self._node.ignored, _IGNORED))
                    for topic, count in ((prefix + topic, n) for topic, n in counts.items())
                ],
            )
        )


@dataclass(frozen=True, slots=True)
class Announcement:
    """What a node says as it finishes.

    Attributes
    ----------
    name : str
        The node's.
    sent, ignored : dict
        How many messages it has sent, and how many that were not ours it has ignored, by topic.
    """

    name: str
    sent: dict[str, int]
    ignored: dict[str, int]


def read_announcement(msg: DiagnosticStatus) -> Announcement:
    """Read an announcement; MalformedMessage where it is none."""
    counts = {item.key: item.value for item in msg.values}
    known = {name for topic in interfaces.RESULTS for name in (topic, _IGNORED + topic)}
    known |= {_IGNORED + topic for topic in interfaces.SUBSCRIBED}
    whole = all(
        value.isascii() and value.isdigit() and len(value) < 16 for value in counts.values()
    )
    if msg.message != _FINISHED or not whole or not counts.keys() <= known:
        raise MalformedMessage(f"no announcement: {msg.name!r}")
    by_kind: dict[bool, dict[str, int]] = {True: {}, False: {}}
    for key, value in counts.items():
        by_kind[key.startswith(_IGNORED)][key.removeprefix(_IGNORED)] = int(value)
    return Announcement(str(msg.name), sent=by_kind[False], ignored=by_kind[True])
