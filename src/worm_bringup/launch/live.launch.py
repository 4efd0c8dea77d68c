"""Watch the rig through the whole graph, a process a node, on a full ROS 2 installation.

ros2 launch worm_bringup live.launch.py camera:=/dev/video0 record:=/path/to/a/new/bag

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

    return LaunchDescription(
        [
            DeclareLaunchArgument("camera", description="device, HTTP or RTSP address, or a file"),
            DeclareLaunchArgument("record", default_value="", description="a new bag, or nothing"),
            DeclareLaunchArgument("polarity", default_value="dark", description="dark or bright"),
            Node(package="worm_model", executable="model"),
            Node(package="worm_analysis", executable="analysis"),
            Node(
                package="worm_tracker",
                executable="tracker",
                parameters=[{"polarity": argument("polarity", str)}],
            ),
            Node(
                package="worm_tracker",
                executable="camera",
                parameters=[{"camera": argument("camera", str), "record": argument("record", str)}],
            ),
        ]
    )
