"""Messages are taken past the executor as by it: in their order, each once."""

from std_msgs.msg import UInt64

from worm_msgs_py.ros.qos import RESULT
from worm_msgs_py.ros.worm_node import WormNode


def test_messages_are_taken_once_and_in_order(ros_context):
    node, heard = WormNode("hears", context=ros_context), []
    node.create_subscription(UInt64, "counts", lambda msg: heard.append(msg.data), RESULT)
    publisher = node.create_publisher(UInt64, "counts", RESULT)
    for count in range(5):
        publisher.publish(UInt64(data=count))
    passes = 0
    while node.take_messages():
        passes += 1
    assert heard == list(range(5))
    assert passes == len(heard)
    node.destroy_node()


def test_a_subscription_that_a_callback_destroys_takes_nothing_more(ros_context):
    node, heard = WormNode("hears", context=ros_context), []

    def stop(_: UInt64) -> None:
        heard.append("first")
        node.destroy_subscription(second)

    node.create_subscription(UInt64, "first", stop, RESULT)
    second = node.create_subscription(UInt64, "second", lambda _: heard.append("second"), RESULT)
    for topic in ("first", "second"):
        node.create_publisher(UInt64, topic, RESULT).publish(UInt64(data=1))
    assert node.take_messages()
    assert not node.take_messages()
    assert heard == ["first"]
    node.destroy_node()
