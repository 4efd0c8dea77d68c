"""Parameters as ROS has them: their descriptors, and names that no parameter has."""

from collections.abc import Iterable
from difflib import get_close_matches

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter

from worm_msgs_py.declarations import Declaration

FIXED = "is fixed while the node runs: start the node anew with another value"


def descriptor(declared: Declaration) -> ParameterDescriptor:
    """Return what ROS tells others of a parameter.

    The range is ROS's own where a number may be anything within it, and only then; in words it is
    always there, with the unit.
    """
    running = "may change while the node runs" if declared.changes else "fixed"
    about = ParameterDescriptor(
        description=declared.description,
        additional_constraints=f"{declared.allowed}; {running}",
        read_only=not declared.changes,
    )
    limit = declared.limit
    if limit is None or limit.or_zero or declared.or_else not in (None, limit.low):
        return about
    if declared.kind is int:
        about.integer_range = [
            IntegerRange(from_value=int(limit.low), to_value=int(limit.high), step=1)
        ]
    else:
        about.floating_point_range = [
            FloatingPointRange(from_value=float(limit.low), to_value=float(limit.high))
        ]
    return about


def of_its_kind(parameter: Parameter, declared: Declaration) -> Parameter:
    """Return the parameter, a whole number as a float where it is one: YAML writes 2 for 2.0."""
    if declared.kind is float and type(parameter.value) is int:
        return Parameter(parameter.name, value=float(parameter.value))
    return parameter


def unknown_parameter(node: str, name: str, known: Iterable[str]) -> str:
    """Return one line on a name that no parameter has, with the one that may be meant."""
    names = sorted(known)
    like = get_close_matches(name, names, n=1)
    guess = f"did you mean {like[0]!r}? " if like else ""
    return f"node {node} has no parameter {name!r}: {guess}it has {', '.join(names)}"
