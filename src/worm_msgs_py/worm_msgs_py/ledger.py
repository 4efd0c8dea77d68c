"""Publishers that count, so that the recorder can prove that nothing was lost on the way.

DDS orders messages within a topic, not between topics: that a node's last state has come says
nothing of its last event. So each node, as it finishes, announces how many messages it has sent on
each topic, and the recorder is done when it holds exactly as many.
"""

from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import QoSProfile

from worm_msgs_py import topics
from worm_msgs_py.qos import FLOW


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

    def __init__(self, node: Node):
        self._node = node
        self.sent: dict[str, int] = {}
        self._announcement = node.create_publisher(DiagnosticStatus, topics.FLOW_FINISHED, FLOW)

    def publisher(self, kind: type, topic: str, qos: QoSProfile) -> CountingPublisher:
        """Create a publisher of a result topic (one of `topics.RESULTS`)."""
        return CountingPublisher(self, self._node.create_publisher(kind, topic, qos), topic)

    def announce(self) -> None:
        """Say that this node has finished, and what it has sent. Once, after the last message."""
        self._announcement.publish(
            DiagnosticStatus(
                level=DiagnosticStatus.OK,
                name=str(self._node.get_name()),
                message="finished",
                values=[KeyValue(key=topic, value=str(sent)) for topic, sent in self.sent.items()],
            )
        )


def read_announcement(msg: DiagnosticStatus) -> tuple[str, dict[str, int]]:
    """Return the node's name and the number of messages that it has sent on each topic."""
    return str(msg.name), {item.key: int(item.value) for item in msg.values}
