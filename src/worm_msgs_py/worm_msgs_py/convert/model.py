"""Model against measurement as named numbers in a `sensor_msgs/JointState`."""

from dataclasses import asdict

from sensor_msgs.msg import JointState

from worm_msgs_py.convert.joints import joints_from_msg, joints_to_msg
from worm_msgs_py.convert.stamp import stamp_to_ns
from worm_msgs_py.model import Comparison, ModelQuantity

_PARAMETER = "parameter/"


def comparison_to_msg(comparison: Comparison) -> JointState:
    """Write ``parameter/NAME`` and then ``QUANTITY[UNIT]/FIELD`` for each number."""
    values = {_PARAMETER + name: value for name, value in comparison.parameters}
    for quantity in comparison.quantities:
        numbers = asdict(quantity)
        prefix = f"{numbers.pop('name')}[{numbers.pop('unit')}]"
        values |= {f"{prefix}/{field}": value for field, value in numbers.items()}
    return joints_to_msg(values, comparison.stamp_ns)


def comparison_from_msg(msg: JointState) -> Comparison:
    """Read a comparison."""
    parameters: list[tuple[str, float]] = []
    quantities: dict[str, dict[str, float]] = {}
    for key, value in joints_from_msg(msg).items():
        if key.startswith(_PARAMETER):
            parameters.append((key.removeprefix(_PARAMETER), value))
        else:
            prefix, _, field = key.rpartition("/")
            quantities.setdefault(prefix, {})[field] = value
    return Comparison(
        stamp_ns=stamp_to_ns(msg.header.stamp),
        parameters=tuple(parameters),
        quantities=tuple(_quantity(prefix, numbers) for prefix, numbers in quantities.items()),
    )


def _quantity(prefix: str, numbers: dict[str, float]) -> ModelQuantity:
    name, _, unit = prefix.removesuffix("]").partition("[")
    return ModelQuantity(name=name, unit=unit, **numbers)
