"""The quality-of-service profile of each kind of topic (docs/architecture.md)."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

RESULT_DEPTH = 4096
"""Deeper than the longest burst: the tracker may hold back a few hundred frames and then give them
all at once (`tests/worm_bringup` proves that nothing is lost)."""


def _keep_last(
    depth: int, reliability: ReliabilityPolicy, durability: DurabilityPolicy
) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=reliability,
        durability=durability,
    )


RESULT = _keep_last(RESULT_DEPTH, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)
"""States, poses, events: nothing may be lost."""

LATCHED = _keep_last(64, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)
"""Geometry: a late subscriber gets the last ones; DDS keeps them all."""

ESTIMATES_DEPTH = 24
"""More than the estimates of all the states that the tracker may give at once. Hardly more: each
takes up to 17 KiB, and DDS keeps so many of each topic, so that memory grows until there are."""

ESTIMATES = _keep_last(
    ESTIMATES_DEPTH, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL
)
"""Correlation, summary, comparison: as the geometry, but large."""

LATCHED_SET_DEPTH = 256
"""More than the distributions of all the states that the tracker may give at once."""

LATCHED_SET = _keep_last(
    LATCHED_SET_DEPTH, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL
)
"""Distributions: many small messages at a time."""

IMAGE_REPLAY = _keep_last(16, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)
"""Replayed pictures: deeper than the source's window of frames in flight."""

IMAGE_LIVE = _keep_last(1, ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)
"""Live pictures from a driver that is not ours: the latest frame wins."""

VIEW = _keep_last(16, ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)
"""What is only looked at: nobody waits for a viewer."""

FLOW = _keep_last(64, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)
"""Counters that give the source its back-pressure."""
