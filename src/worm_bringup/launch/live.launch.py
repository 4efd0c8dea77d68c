"""Watch the rig through the whole graph, a process a node, on a full ROS 2 installation.

ros2 launch worm_bringup live.launch.py camera:=/dev/video0 record:=/path/to/a/new/bag rig:=rig.yaml

What is given here counts before the rig file, as with the worm command. Other machines hear it only
where ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET is set (docs/network.md).
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

_LIVE_ARGUMENTS = {
    "camera": "device, HTTP or RTSP address, or a file",
    "topic": "instead of a camera, the topic of a driver, such as /camera/image_raw",
    "record": "a new bag for the pictures, or nothing",
    "out": "an existing, empty directory for the results, or nothing",
    "rig": "a rig file (worm calibrate writes one), or nothing",
    "namespace": "of all nodes, such as /rig1",
    "polarity": "dark or bright",
}


def _live_nodes(context):
    told = context.launch_configurations

    def node(package, executable, *names):
        files = [told["rig"]] if told["rig"] else []
        given = {name: ParameterValue(told[name], value_type=str) for name in names if told[name]}
        return Node(
            package=package,
            executable=executable,
            namespace=told["namespace"],
            parameters=[*files, given] if given else files,
        )

    return [
        *([node("worm_bringup", "recorder", "out")] if told["out"] else []),
        node("worm_model", "model"),
        node("worm_analysis", "analysis"),
        node("worm_tracker", "tracker", "polarity"),
        node("worm_tracker", "camera", "camera", "topic", "record"),
    ]


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, description in _LIVE_ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=_live_nodes)])
