"""An example to copy: a node of your own in this graph, tested against the truth of a bag."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from worm_msgs_py import convert, topics
from worm_msgs_py.ros import qos
from worm_tracker.sources.replay_node import ReplayNode
from worm_tracker.tracker_node import TrackerNode

BAGS = Path(__file__).parents[1] / "bags"


class SpeedNode(Node):
    """Your node: publishes the centroid's speed, mm/s, for each pair of frames."""

    def __init__(self, **node_arguments):
        super().__init__("speed", start_parameter_services=False, **node_arguments)
        self.create_subscription(JointState, topics.WORM_STATE, self.on_state, qos.RESULT)
        self.publisher = self.create_publisher(Float64, "speed", qos.RESULT)
        self.last = None

    def on_state(self, msg):
        state = convert.body_state_from_msg(msg)
        if self.last is not None:
            step_mm = 1e3 * np.hypot(
                state.centroid.x_m - self.last.centroid.x_m,
                state.centroid.y_m - self.last.centroid.y_m,
            )
            elapsed_s = (state.stamp_ns - self.last.stamp_ns) / 1e9
            self.publisher.publish(Float64(data=float(step_mm / elapsed_s)))
        self.last = state


class Listener(Node):
    """Keeps what your node publishes."""

    def __init__(self, **node_arguments):
        super().__init__("listener", start_parameter_services=False, **node_arguments)
        self.speeds = []
        self.create_subscription(
            Float64, "speed", lambda msg: self.speeds.append(msg.data), qos.RESULT
        )


def test_the_speed_is_that_of_the_drawn_body(ros_context, run_graph):
    seconds = 5.0
    replay = ReplayNode(
        context=ros_context,
        parameter_overrides=[
            Parameter("bag", value=str(BAGS / "larva")),
            Parameter("playback_duration", value=seconds),
        ],
    )
    listener = Listener(context=ros_context)
    run_graph(replay, TrackerNode(context=ros_context), SpeedNode(context=ros_context), listener)

    truth = pq.read_table(BAGS / "larva_truth.parquet").to_pydict()
    frames = replay.sent
    x_mm, y_mm = (np.array(truth[f"centroid_{axis}_mm"][:frames]) for axis in "xy")
    elapsed_s = np.diff(truth["stamp_ns"][:frames]) / 1e9
    true_speed = np.hypot(np.diff(x_mm), np.diff(y_mm)) / elapsed_s
    assert len(listener.speeds) == frames - 1  # not a frame was lost
    assert np.mean(listener.speeds) == pytest.approx(np.mean(true_speed), rel=0.1)
