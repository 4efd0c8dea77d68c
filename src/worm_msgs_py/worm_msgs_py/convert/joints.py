"""Named numbers in a `sensor_msgs/JointState`: the form of all generalised coordinates."""

from collections.abc import Iterator, Mapping
from itertools import groupby

from sensor_msgs.msg import JointState

from worm_msgs_py.convert.stamp import header


def joints_to_msg(values: Mapping[str, float], stamp_ns: int, frame_id: str = "") -> JointState:
    """Write names and values, in the mapping's order."""
    return JointState(
        header=header(stamp_ns, frame_id),
        name=list(values),
        position=[float(value) for value in values.values()],
    )


def joints_from_msg(msg: JointState) -> dict[str, float]:
    """Read names and values; ValueError where their numbers differ."""
    if len(msg.name) != len(msg.position):
        raise ValueError(
            f"a JointState has {len(msg.name)} names but {len(msg.position)} positions"
        )
    return dict(zip(msg.name, msg.position, strict=True))


def by_prefix(values: Mapping[str, float]) -> Iterator[tuple[str, dict[str, float]]]:
    """Group ``prefix/key`` names that follow one another by prefix."""
    for prefix, items in groupby(values.items(), key=lambda item: item[0].rpartition("/")[0]):
        yield prefix, {name.rpartition("/")[2]: value for name, value in items}
