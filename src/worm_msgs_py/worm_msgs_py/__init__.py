"""The contract between the nodes: dataclasses, topics, frames and their ROS messages.

The dataclasses import without ROS. Only `worm_msgs_py.convert` and `worm_msgs_py.ros` need rclpy.
"""

from worm_msgs_py.contract.analysis import Correlation, Distribution, Observables, Quantity
from worm_msgs_py.contract.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.episodes import Attempt, Episode, EpisodeKind, Event, StrokePhase, Visit
from worm_msgs_py.contract.frames import Where
from worm_msgs_py.contract.model import Comparison, Forecast, ModelQuantity, NeededReversal
from worm_msgs_py.contract.source_events import SourceEvent, SourceEventKind
from worm_msgs_py.contract.status import Status

__all__ = [
    "Attempt",
    "BodyState",
    "Chamber",
    "Comparison",
    "Correlation",
    "Distribution",
    "Episode",
    "EpisodeKind",
    "Event",
    "Forecast",
    "Geometry",
    "Keypoint",
    "Midline",
    "ModelQuantity",
    "NeededReversal",
    "Observables",
    "Quantity",
    "SourceEvent",
    "SourceEventKind",
    "Status",
    "StrokePhase",
    "TrackedFrame",
    "Visit",
    "Where",
]
