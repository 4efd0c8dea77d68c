"""Which nodes make a graph, and with which parameters; the same whichever way it is run."""

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.worm_node import WormNode, refuse_unknown_parameters
from worm_msgs_py.text import printable


@dataclass(frozen=True)
class NodeSpec:
    """One node of a graph.

    Attributes
    ----------
    module : str
        The module that defines the node: the one subclass of `rclpy.node.Node` written in it.
    name : str
        The node's name.
    parameters : mapping
        Values of its parameters; the others keep their defaults.
    """

    module: str
    name: str
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def make(
        self, *, context: Context | None = None, namespace: str = "", served: bool = False
    ) -> Node:
        """Create the node.

        Parameters
        ----------
        served : bool
            Whether a node of ours has parameter services; where nobody can call them there are
            none for the executor to look at in every wait (`benchmarks/graph.py`).

        Raises
        ------
        BadInput
            A parameter is misspelt (rclpy passes over it without a word) or of the wrong type, or
            the node refuses its input.
        """
        overrides = [
            Parameter(name, value=str(value) if isinstance(value, Path) else value)
            for name, value in self.parameters.items()
        ]
        kind = node_class(self.module)
        quiet = (
            {} if served or not issubclass(kind, WormNode) else {"start_parameter_services": False}
        )
        try:
            node = kind(
                context=context, namespace=namespace, parameter_overrides=overrides, **quiet
            )
        except InvalidParameterTypeException as error:
            raise BadInput(f"node {self.name}: {error}") from None
        except rclpy_implementation.RCLError as error:  # such as keys that cannot be used
            raise BadInput(f"node {self.name} cannot be made: {printable(error)}") from None
        try:
            refuse_unknown_parameters(node)
        except BadInput:
            node.destroy_node()
            raise
        if node.get_name() != self.name:
            raise ValueError(f"{self.module} makes {node.get_name()!r}, not {self.name!r}")
        return node

    def to_yaml(self) -> str:
        """Return the parameters in the form of a ROS parameter file."""
        values = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in self.parameters.items()
        }
        return yaml.safe_dump({self.name: {"ros__parameters": values}}, allow_unicode=True)

    @classmethod
    def from_yaml(cls, module: str, name: str, text: str) -> "NodeSpec":
        """Return the node whose parameters stand in a ROS parameter file."""
        return cls(module, name, yaml.safe_load(text)[name]["ros__parameters"])


def node_class(module: str) -> type[Node]:
    """Return the one subclass of `rclpy.node.Node` that is written in a module."""
    loaded = importlib.import_module(module)
    classes = [
        item
        for item in vars(loaded).values()
        if isinstance(item, type) and issubclass(item, Node) and item.__module__ == module
    ]
    if len(classes) != 1:
        raise TypeError(f"{module} defines {len(classes)} classes of nodes, not one")
    return classes[0]
