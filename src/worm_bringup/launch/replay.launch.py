"""Replay a bag through the whole graph, a process a node, on a full ROS 2 installation.

ros2 launch worm_bringup replay.launch.py bag:=/path/to/bag out:=/path/to/an/empty/directory

Other machines hear it only where ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET is set (docs/network.md).
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    def argument(name, kind):
        return ParameterValue(LaunchConfiguration(name), value_type=kind)

    tracker = {"polarity": argument("polarity", str), "no_chamber": argument("no_chamber", bool)}
    return LaunchDescription(
        [
            DeclareLaunchArgument("bag", description="rosbag2 directory, .mcap or .db3"),
            DeclareLaunchArgument("out", description="an existing, empty directory"),
            DeclareLaunchArgument("rate", default_value="0.0", description="0: as fast as can be"),
            DeclareLaunchArgument("polarity", default_value="dark", description="dark or bright"),
            DeclareLaunchArgument(
                "no_chamber", default_value="false", description="no rig in view"
            ),
            Node(
                package="worm_bringup",
                executable="recorder",
                parameters=[{"out": argument("out", str)}],
            ),
            Node(package="worm_model", executable="model"),
            Node(package="worm_analysis", executable="analysis"),
            Node(package="worm_tracker", executable="tracker", parameters=[tracker]),
            Node(
                package="worm_tracker",
                executable="replay",
                parameters=[{"bag": argument("bag", str), "rate": argument("rate", float)}],
            ),
        ]
    )
