"""Plays a bag into a real tracker and gives what both say of it; bags of raw bytes."""

from mcap.writer import CompressionType, Writer
from picture_bags import TYPESTORE
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_msgs_py import SourceEventKind, convert, topics
from worm_msgs_py.ros.interfaces import RESULTS
from worm_tracker.sources.replay_node import ReplayNode
from worm_tracker.tracker_node import TrackerNode


class Played:
    """States of one run, and what it told of its pictures; not that noise has no poses."""

    def __init__(self, run_graph, context, bag, **source):
        overrides = {"bag": str(bag), **source}
        self.replay = ReplayNode(
            context=context,
            parameter_overrides=[Parameter(name, value=v) for name, v in overrides.items()],
        )
        tracker = TrackerNode(
            context=context, parameter_overrides=[Parameter("no_chamber", value=True)]
        )
        ears = Node("ears", context=context, start_parameter_services=False)
        self.states, self.events = [], []
        for topic, take in (
            (topics.WORM_STATE, lambda m: self.states.append(convert.body_state_from_msg(m))),
            (topics.SOURCE_EVENTS, lambda m: self.events.extend(convert.source_events_from_msg(m))),
        ):
            kind, qos = RESULTS[topic]
            ears.create_subscription(kind, topic, take, qos)
        run_graph(self.replay, tracker, ears)
        self.events = [e for e in self.events if e.kind is not SourceEventKind.WHAT_TO_TRY]

    @property
    def bad_frames(self):
        return [state.frame for state in self.states if state.status.label == "bad_image"]


def write_raw_mcap(path, messages, kind, *, chunk=1 << 16, topic="/image_raw", compression=None):
    """Write (time of recording, serialised bytes) as a bare .mcap; return the path."""
    definition, _ = TYPESTORE.generate_msgdef(kind, ros_version=2)
    with path.open("wb") as file:
        writer = Writer(
            file,
            chunk_size=chunk,
            compression=compression or CompressionType.NONE,
            use_chunking=chunk > 0,
        )
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema(kind, "ros2msg", definition.encode())
        channel = writer.register_channel(topic, "cdr", schema)
        for number, (log_ns, data) in enumerate(messages):
            writer.add_message(channel, log_ns, data, log_ns, number)
        writer.finish()
    return path
