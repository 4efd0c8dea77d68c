"""`worm node`: one node of the graph as a process of its own, as `ros2 run` starts it."""

import importlib
from enum import StrEnum
from typing import Annotated

import typer
from rclpy.utilities import remove_ros_args

from worm_bringup.graph.nodes import NODES
from worm_msgs_py.errors import BadInput

NodeName = StrEnum("NodeName", {name.upper(): name for name in NODES})  # type: ignore[misc]


def node(
    context: typer.Context,
    name: Annotated[NodeName, typer.Argument(help="Which node (docs/nodes.md).")],
) -> None:
    """Run one node alone, until a signal or the end of its stream.

    What follows goes to ROS: `worm node tracker --ros-args -p radius_m:=0.01 -r __ns:=/rig1
    --params-file rig.yaml`. A parameter that the node does not have, or that makes no sense, is
    refused.
    """
    try:
        beside = remove_ros_args(["worm", *context.args])[1:]
    except RuntimeError:
        beside = []  # the node says what is wrong with them
    if beside:
        raise BadInput(
            f"{beside[0]!r} is nothing that a node takes: put --ros-args before what is for ROS, "
            "such as --ros-args -p NAME:=VALUE"
        )
    raise typer.Exit(importlib.import_module(NODES[name]).main(context.args))
