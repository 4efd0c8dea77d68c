"""Every node that there is, by the name that `worm node` takes."""

from worm_bringup.graph.node_spec import node_class
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.ros.worm_node import WormNode

NODES = {
    "replay": "worm_tracker.sources.replay_node",
    "camera": "worm_tracker.sources.camera_node",
    "simulated_camera": "worm_bringup.simulated_camera",
    "tracker": "worm_tracker.tracker_node",
    "analysis": "worm_analysis.analysis_node",
    "model": "worm_model.model_node",
    "recorder": "worm_bringup.recorder.recorder_node",
    "overlay": "worm_bringup.overlay.overlay_node",
    "foxglove": "worm_bringup.overlay.foxglove_node",
    "monitor": "worm_monitor.monitor_node",
}
"""The module of each."""
ROS_NAMES = dict.fromkeys(("replay", "camera", "simulated_camera"), "image_source")
"""What a node is called in the graph, where that is another name."""


def parameters_of(name: str) -> tuple[Declaration, ...]:
    """Return all that a node may be told."""
    kind = node_class(NODES[name])
    assert issubclass(kind, WormNode)
    return kind.PARAMETERS
