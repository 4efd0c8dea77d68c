"""How a source of pictures is driven beside nodes that have much to do."""

import math

import pytest
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import UInt64

from worm_msgs_py.ros.qos import RESULT
from worm_msgs_py.ros.worm_node import WormNode
from worm_tracker.sources.source_node import SourceNode, drain, spin_source

STATES, PICTURES = 400, 20
"""States that are given at once, and pictures that wait meanwhile."""


class ManyPictures(SourceNode):
    """Sends numbered pictures, each of them late, and with the first a burst of states."""

    endless = True

    def __init__(self, waits, **node_arguments):
        super().__init__(**node_arguments)
        self._waits = waits
        self._pictures = self.create_publisher(UInt64, "picture", RESULT)
        self._states = self.create_publisher(UInt64, "state", RESULT)

    last_stamp_ns = 0
    is_watched = True

    @property
    def picture_waits(self):
        return self._waits and self.sent < PICTURES

    def wait_s(self):
        return 0.0 if self.sent <= PICTURES else math.inf

    def publish_next(self):
        if self.sent == PICTURES:
            return False
        if self.sent == 0:
            for number in range(STATES):
                self._states.publish(UInt64(data=number))
        self._pictures.publish(UInt64(data=self.sent))
        self.sent += 1
        return True


class Listener(WormNode):
    """Notes what it takes, in order."""

    def __init__(self, taken, **node_arguments):
        super().__init__("listener", **node_arguments)
        for topic in ("picture", "state"):
            self.create_subscription(
                UInt64, topic, lambda msg, topic=topic: taken.append((topic, msg.data)), RESULT
            )


@pytest.mark.parametrize("waits", [False, True])
def test_a_picture_that_waits_goes_before_a_backlog_of_states(ros_context, waits):
    taken = []
    source, listener = (
        ManyPictures(waits, context=ros_context),
        Listener(taken, context=ros_context),
    )
    executor = SingleThreadedExecutor(context=ros_context)
    for node in (source, listener):
        executor.add_node(node)
    assert spin_source(executor, source, lambda: True, heed_window=False)
    drain(executor)
    executor.shutdown()
    for node in (source, listener):
        node.destroy_node()
    assert [n for topic, n in taken if topic == "picture"] == list(range(PICTURES))
    assert [n for topic, n in taken if topic == "state"] == list(range(STATES))
    before_the_second = taken.index(("picture", 1))
    assert (before_the_second < STATES) == waits


def test_what_a_drain_left_over_and_what_came_then_is_taken_by_the_next(ros_context):
    taken = []
    listener = Listener(taken, context=ros_context)
    publisher = listener.create_publisher(UInt64, "state", RESULT)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(listener)
    for number in range(3):
        publisher.publish(UInt64(data=number))
    drain(executor, enough=lambda: True)
    left_over = taken.copy()
    publisher.publish(UInt64(data=3))
    drain(executor)
    executor.shutdown()
    listener.destroy_node()
    assert left_over == [("state", 0)]
    assert [number for _, number in taken] == [0, 1, 2, 3]
