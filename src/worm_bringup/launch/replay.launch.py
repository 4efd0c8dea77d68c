"""Replay a bag through the whole graph, a process a node, on a full ROS 2 installation.

ros2 launch worm_bringup replay.launch.py bag:=/path/to/bag out:=/path/to/an/empty/directory

What is given here counts before the rig file, as with the worm command. Other machines hear it only
where ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET is set (docs/network.md).
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

_REPLAY_ARGUMENTS = {
    "bag": (str, "rosbag2 directory, .mcap or .db3"),
    "out": (str, "an existing, empty directory"),
    "rate": (float, "recorded time per time; 0: as fast as can be"),
    "rig": (str, "a rig file (worm calibrate writes one), or nothing"),
    "namespace": (str, "of all nodes, such as /rig1"),
    "polarity": (str, "dark or bright"),
    "no_chamber": (bool, "true where no rig is in view"),
}


def _replay_nodes(context):
    told = context.launch_configurations

    def node(package, executable, *names):
        files = [told["rig"]] if told["rig"] else []
        given = {
            name: ParameterValue(told[name], value_type=_REPLAY_ARGUMENTS[name][0])
            for name in names
            if told[name]
        }
        return Node(
            package=package,
            executable=executable,
            namespace=told["namespace"],
            parameters=[*files, given] if given else files,
        )

    return [
        node("worm_bringup", "recorder", "out"),
        node("worm_model", "model"),
        node("worm_analysis", "analysis"),
        node("worm_tracker", "tracker", "polarity", "no_chamber"),
        node("worm_tracker", "replay", "bag", "rate"),
    ]


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, (_, description) in _REPLAY_ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=_replay_nodes)])
