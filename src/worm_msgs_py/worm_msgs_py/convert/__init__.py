"""Conversions between the dataclasses and standard ROS messages.

rclpy's messages take a wrong type without a word and corrupt it on the wire, so every field is
passed through `float`, `int`, `bool` or `str` here, and nowhere else are messages filled.
"""

from worm_msgs_py.convert.analysis import (
    before_from_msg,
    correlation_from_msg,
    correlation_to_msg,
    distribution_from_msg,
    distribution_to_msg,
    observables_from_msg,
    observables_to_msg,
    quantities_from_msg,
    quantities_to_msg,
    sums_from_msg,
    sums_to_msg,
)
from worm_msgs_py.convert.body import body_state_from_msg, body_state_to_msg, keypoint_to_pose
from worm_msgs_py.convert.camera_info import camera_info_to_cdr, camera_info_to_msg
from worm_msgs_py.convert.chamber import geometry_from_msg, geometry_to_markers, geometry_to_msg
from worm_msgs_py.convert.episodes import events_from_msg, events_to_msg
from worm_msgs_py.convert.flow import count_from_msg, count_to_msg, counts_from_msg, counts_to_msg
from worm_msgs_py.convert.midline import midline_from_msg, midline_to_msg
from worm_msgs_py.convert.model import (
    comparison_from_msg,
    comparison_to_msg,
    forecast_from_msg,
    forecast_to_msg,
)
from worm_msgs_py.convert.picture import compressed_to_msg, picture_to_msg
from worm_msgs_py.convert.source_events import source_events_from_msg, source_events_to_msg
from worm_msgs_py.convert.stamp import stamp_to_msg, stamp_to_ns

__all__ = [
    "before_from_msg",
    "body_state_from_msg",
    "body_state_to_msg",
    "camera_info_to_cdr",
    "camera_info_to_msg",
    "comparison_from_msg",
    "comparison_to_msg",
    "compressed_to_msg",
    "correlation_from_msg",
    "correlation_to_msg",
    "count_from_msg",
    "count_to_msg",
    "counts_from_msg",
    "counts_to_msg",
    "distribution_from_msg",
    "distribution_to_msg",
    "events_from_msg",
    "events_to_msg",
    "forecast_from_msg",
    "forecast_to_msg",
    "geometry_from_msg",
    "geometry_to_markers",
    "geometry_to_msg",
    "keypoint_to_pose",
    "midline_from_msg",
    "midline_to_msg",
    "observables_from_msg",
    "observables_to_msg",
    "picture_to_msg",
    "quantities_from_msg",
    "quantities_to_msg",
    "source_events_from_msg",
    "source_events_to_msg",
    "stamp_to_msg",
    "stamp_to_ns",
    "sums_from_msg",
    "sums_to_msg",
]
