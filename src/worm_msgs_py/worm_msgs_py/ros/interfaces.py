"""Type and quality of service of every result topic: what a recorder or a monitor subscribes to."""

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from worm_msgs_py import topics
from worm_msgs_py.ros.qos import ESTIMATES, LATCHED, LATCHED_SET, RESULT

RESULTS: dict[str, tuple[type, QoSProfile]] = {
    topics.CHAMBER: (MarkerArray, LATCHED),
    topics.CHAMBER_GEOMETRY: (JointState, LATCHED),
    topics.WORM_STATE: (JointState, RESULT),
    topics.WORM_HEAD: (PoseStamped, RESULT),
    topics.WORM_CENTROID: (PoseStamped, RESULT),
    topics.WORM_TAIL: (PoseStamped, RESULT),
    topics.WORM_MIDLINE: (PointCloud2, RESULT),
    topics.ANALYSIS_STATE: (JointState, RESULT),
    topics.ANALYSIS_EVENTS: (DiagnosticArray, RESULT),
    topics.ANALYSIS_CORRELATION: (JointTrajectory, ESTIMATES),
    topics.ANALYSIS_DISTRIBUTIONS: (Float64MultiArray, LATCHED_SET),
    topics.ANALYSIS_SUMMARY: (DiagnosticArray, ESTIMATES),
    topics.ANALYSIS_SUMS: (Float64MultiArray, RESULT),
    topics.MODEL_FORECAST: (JointState, RESULT),
    topics.MODEL_COMPARISON: (JointState, ESTIMATES),
    topics.MODEL_CORRELATION: (JointTrajectory, ESTIMATES),
    topics.SOURCE_EVENTS: (DiagnosticArray, RESULT),
}

SUBSCRIBED = (
    *RESULTS,
    topics.IMAGE,
    topics.IMAGE_COMPRESSED,
    topics.FLOW_TRACKED,
    topics.FLOW_RECORDED,
    topics.FLOW_FINISHED,
    topics.FLOW_END,
)
"""Every topic that a node of the graph subscribes to."""
