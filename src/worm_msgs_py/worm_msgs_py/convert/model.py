"""Model against measurement, and forecasts, as named numbers in a `sensor_msgs/JointState`."""

from dataclasses import asdict

from sensor_msgs.msg import JointState

from worm_msgs_py.contract.frames import Where
from worm_msgs_py.contract.model import Comparison, Forecast, ModelQuantity, NeededReversal
from worm_msgs_py.convert.joints import joints_from_msg, joints_to_msg
from worm_msgs_py.convert.message_checks import strict, whole
from worm_msgs_py.convert.stamp import stamp_to_ns

_PARAMETER, _NEEDED, _FORECAST = "parameter/", "needed_reversal/", "forecast/"
_IS_MEASURED = "_is_measured"
_FORECAST_NUMBERS = (
    "theta_h_rad",
    "direction",
    "contact",
    "median_s",
    "low_s",
    "high_s",
    "within_10_s",
    "within_30_s",
    "within_60_s",
)


def comparison_to_msg(comparison: Comparison) -> JointState:
    """Write ``parameter/NAME``, then ``QUANTITY[UNIT]/FIELD`` for each number.

    After these ``needed_reversal/RULE/SPEED/OBSERVATION/FIELD`` and ``forecast/SCORE``.
    """
    values = {_PARAMETER + name: value for name, value in comparison.parameters}
    for quantity in comparison.quantities:
        numbers = asdict(quantity)
        prefix = f"{numbers.pop('name')}[{numbers.pop('unit')}]"
        values |= {f"{prefix}/{field}": value for field, value in numbers.items()}
    for need in comparison.needs:
        numbers = asdict(need)
        prefix = _NEEDED + "/".join(numbers.pop(key) for key in ("rule", "speed", "observation"))
        values |= {f"{prefix}/{field}": value for field, value in numbers.items()}
    values |= {_FORECAST + name: value for name, value in comparison.scores}
    return joints_to_msg(values, comparison.stamp_ns)


@strict
def comparison_from_msg(msg: JointState) -> Comparison:
    """Read a comparison."""
    named: dict[str, list[tuple[str, float]]] = {_PARAMETER: [], _FORECAST: []}
    quantities: dict[str, dict[str, float]] = {}
    needs: dict[str, dict[str, float]] = {}
    for key, value in joints_from_msg(msg).items():
        kind = next((known for known in named if key.startswith(known)), "")
        if kind:
            named[kind].append((key.removeprefix(kind), value))
            continue
        groups = needs if key.startswith(_NEEDED) else quantities
        prefix, _, field = key.removeprefix(_NEEDED).rpartition("/")
        groups.setdefault(prefix, {})[field] = value
    return Comparison(
        stamp_ns=stamp_to_ns(msg.header.stamp),
        parameters=tuple(named[_PARAMETER]),
        quantities=tuple(_quantity_of(prefix, numbers) for prefix, numbers in quantities.items()),
        needs=tuple(_need_of(prefix, numbers) for prefix, numbers in needs.items()),
        scores=tuple(named[_FORECAST]),
    )


def forecast_to_msg(forecast: Forecast) -> JointState:
    """Write a forecast; ``NAME_is_measured`` is 1 for a parameter that is the trial's own."""
    return joints_to_msg(
        {
            "frame": forecast.frame,
            "where": forecast.where,
            **{name: getattr(forecast, name) for name in _FORECAST_NUMBERS},
            **{name + _IS_MEASURED: is_own for name, is_own in forecast.measured},
        },
        forecast.stamp_ns,
        forecast.where.label if forecast.where is not Where.UNKNOWN else "",
    )


@strict
def forecast_from_msg(msg: JointState) -> Forecast:
    """Read a forecast; MalformedMessage where a name is missing."""
    values = joints_from_msg(msg)
    return Forecast(
        frame=whole(values["frame"]),
        stamp_ns=stamp_to_ns(msg.header.stamp),
        where=Where(whole(values["where"])),
        **{name: values[name] for name in _FORECAST_NUMBERS},
        measured=tuple(
            (name.removesuffix(_IS_MEASURED), bool(value))
            for name, value in values.items()
            if name.endswith(_IS_MEASURED)
        ),
    )


def _quantity_of(prefix: str, numbers: dict[str, float]) -> ModelQuantity:
    name, _, unit = prefix.removesuffix("]").partition("[")
    return ModelQuantity(name=name, unit=unit, **numbers)


def _need_of(prefix: str, numbers: dict[str, float]) -> NeededReversal:
    rule, speed, observation = prefix.split("/")
    is_measured = bool(numbers.pop("is_measured"))
    return NeededReversal(rule, speed, observation, **numbers, is_measured=is_measured)
