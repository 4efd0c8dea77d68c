"""A message of somebody else's is counted and ignored: no trial is lost and no byte moved."""

import json
import math
from dataclasses import is_dataclass

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from picture_bags import write_bag
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image, JointState, PointCloud2, PointField
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, UInt64, UInt64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import MarkerArray

from worm_analysis.analysis_node import AnalysisNode
from worm_bringup.recorder.recorder_node import RecorderNode
from worm_model.model_node import ModelNode
from worm_msgs_py import BodyState, Observables, convert, topics
from worm_msgs_py.convert.body import _JOINT_NAMES
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros.counting_publisher import read_announcement
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, IMAGE_REPLAY
from worm_tracker.sources.replay_node import ReplayNode
from worm_tracker.sources.source_node import drain
from worm_tracker.tracker_node import TrackerNode

FRAMES = 30
STATE_OF_NOTHING = convert.body_state_to_msg(BodyState(frame=10**9, stamp_ns=5))
STRANGE = {
    topics.WORM_STATE: [
        JointState(name=["x"]),
        JointState(name=["x"], position=[1.0]),
        STATE_OF_NOTHING,
        convert.body_state_to_msg(BodyState(frame=3, stamp_ns=5)),
        JointState(name=_JOINT_NAMES, position=[math.nan] * len(_JOINT_NAMES)),
    ],
    topics.WORM_MIDLINE: [PointCloud2(), PointCloud2(fields=[PointField(name="x")], point_step=1)],
    topics.CHAMBER_GEOMETRY: [JointState(name=["x"]), JointState(name=["version"], position=[1.5])],
    topics.CHAMBER: [MarkerArray()],
    topics.ANALYSIS_STATE: [
        JointState(name=["x"]),
        convert.observables_to_msg(Observables(frame=10**9, stamp_ns=5)),
    ],
    topics.ANALYSIS_EVENTS: [DiagnosticArray(status=[DiagnosticStatus(name="visit")])],
    topics.ANALYSIS_SUMMARY: [DiagnosticArray(status=[DiagnosticStatus(name="d_c")])],
    topics.ANALYSIS_CORRELATION: [JointTrajectory(joint_names=["x"])],
    topics.MODEL_COMPARISON: [JointState(name=["x"], position=[0.0])],
    topics.SOURCE_EVENTS: [DiagnosticArray(status=[DiagnosticStatus(name="outage")])],
    topics.FLOW_TRACKED: [UInt64MultiArray(), UInt64MultiArray(data=[10**6, 10**6])],
    topics.FLOW_RECORDED: [UInt64(data=10**6)],
    topics.FLOW_END: [UInt64(data=1)],
    topics.FLOW_FINISHED: [
        DiagnosticStatus(name="tracker", values=[KeyValue(key="worm/state", value="many")]),
        DiagnosticStatus(name="stranger", message="finished"),
    ],
    topics.IMAGE: [Image(), Image(height=9, width=9, encoding="mono8", step=9)],
}
FLOWS = {
    topics.FLOW_TRACKED: UInt64MultiArray,
    topics.FLOW_RECORDED: UInt64,
    topics.FLOW_END: UInt64,
    topics.FLOW_FINISHED: DiagnosticStatus,
}


def run(context, bag, out, strange):
    """Replay through all nodes, with what a stranger says after the fifth and the tenth frame."""
    out.mkdir()
    values = {"bag": str(bag)}
    source = ReplayNode(
        context=context, parameter_overrides=[Parameter(k, value=v) for k, v in values.items()]
    )
    nodes = [
        source,
        TrackerNode(context=context, parameter_overrides=[Parameter("no_chamber", value=True)]),
        AnalysisNode(context=context),
        ModelNode(context=context),
        RecorderNode(context=context, parameter_overrides=[Parameter("out", value=str(out))]),
    ]
    stranger = Node("stranger", context=context, start_parameter_services=False)
    executor = SingleThreadedExecutor(context=context)
    for node in (*nodes, stranger):
        executor.add_node(node)
    say = []
    for topic, messages in strange.items():
        qos = RESULTS[topic][1] if topic in RESULTS else FLOW
        qos = IMAGE_REPLAY if topic == topics.IMAGE else qos
        publisher = stranger.create_publisher(type(messages[0]), topic, qos)
        say += [(publisher, message) for message in messages]
    drain(executor)
    while source.publish_next():
        drain(executor)
        if source.sent in (5, 10):
            for publisher, message in say:
                publisher.publish(message)
            drain(executor)
    drain(executor)
    late = [getattr(node, "missing", "") for node in nodes if not node.done]
    executor.shutdown()
    for node in (*nodes, stranger):
        node.destroy_node()
    assert late == []
    return json.loads((out / "summary.json").read_text())


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "bag", FRAMES)


def test_foreign_messages_on_every_topic_change_no_byte_and_are_counted(tmp_path, ros_context, bag):
    alone = run(ros_context, bag, tmp_path / "alone", {})
    assert alone["ignored_messages"] == {}
    beside = run(ros_context, bag, tmp_path / "beside", STRANGE)
    ignored = beside.pop("ignored_messages")
    alone.pop("ignored_messages")
    assert beside == alone
    assert set(ignored) == set(STRANGE)
    assert ignored[topics.WORM_STATE] == 2 * len(STRANGE[topics.WORM_STATE])
    for table in ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet"):
        assert (tmp_path / "beside" / table).read_bytes() == (
            tmp_path / "alone" / table
        ).read_bytes()


numbers = st.floats(allow_nan=True, allow_infinity=True) | st.sampled_from([0.0, 1.0, 3.0, 2.0**53])
texts = st.text(max_size=8)
names = texts | st.sampled_from(
    [*_JOINT_NAMES, "contact", "frame", "version", "chamber_a/radius_m"]
)
joints = st.builds(
    JointState,
    name=st.lists(names, max_size=8) | st.just(_JOINT_NAMES),
    position=st.lists(numbers, max_size=8)
    | st.lists(numbers, min_size=len(_JOINT_NAMES), max_size=len(_JOINT_NAMES)),
)
words = texts | st.sampled_from(["none", "true", "1", "-1", "9" * 30, "contact", "a", "nan"])
keys = texts | st.sampled_from(["chamber", "kind", "start_ns", "end_ns", "distance_m", "name", "n"])
statuses = st.builds(
    DiagnosticStatus,
    name=texts | st.sampled_from(["episode", "visit", "attempt"]),
    message=st.sampled_from(["", "finished"]),
    values=st.lists(st.builds(KeyValue, key=keys, value=words), max_size=10),
)
arrays = st.builds(DiagnosticArray, status=st.lists(statuses, max_size=3))
clouds = st.builds(
    PointCloud2,
    fields=st.lists(
        st.builds(
            PointField,
            name=st.sampled_from(["x", "y", "z", "s", "width", "u_px", "v_px", "s_px", "width_px"]),
            offset=st.integers(0, 2**32 - 1) | st.integers(0, 40),
            datatype=st.integers(1, 8),
            count=st.integers(0, 3),
        ),
        max_size=10,
    ),
    point_step=st.integers(0, 2**32 - 1) | st.integers(0, 40),
    is_bigendian=st.booleans(),
    data=st.binary(max_size=120).map(list),
)
trajectories = st.builds(
    JointTrajectory,
    joint_names=st.just(["C_theta", "C_theta_error", "pairs", "C_theta_model"])
    | st.lists(texts, max_size=4),
    points=st.lists(
        st.builds(JointTrajectoryPoint, positions=st.lists(numbers, max_size=5)), max_size=4
    ),
)
dimensions = st.builds(
    MultiArrayDimension,
    label=texts | st.just("low,high,count"),
    size=st.integers(0, 2**32 - 1) | st.integers(0, 4),
)


@st.composite
def histograms(draw):
    message = Float64MultiArray(data=draw(st.lists(numbers, max_size=12)))
    message.layout.dim = draw(st.lists(dimensions, max_size=3))
    return message


CONVERSIONS = [
    (convert.body_state_from_msg, joints),
    (convert.observables_from_msg, joints),
    (convert.before_from_msg, joints),
    (convert.geometry_from_msg, joints),
    (convert.comparison_from_msg, joints),
    (convert.forecast_from_msg, joints),
    (convert.events_from_msg, arrays),
    (convert.quantities_from_msg, arrays),
    (convert.source_events_from_msg, arrays),
    (convert.midline_from_msg, clouds),
    (convert.correlation_from_msg, trajectories),
    (convert.distribution_from_msg, histograms()),
    (read_announcement, statuses),
]


@pytest.mark.parametrize(
    ("read", "messages"), CONVERSIONS, ids=[read.__name__ for read, _ in CONVERSIONS]
)
@given(data=st.data())
def test_a_message_is_read_or_refused_whatever_it_holds(read, messages, data):
    try:
        value = read(data.draw(messages))
    except MalformedMessage:
        return
    assert is_dataclass(value) or isinstance(value, tuple)
