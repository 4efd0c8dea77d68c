"""Stamps: nanoseconds as one integer inside, `builtin_interfaces/Time` in messages."""

from builtin_interfaces.msg import Duration, Time
from std_msgs.msg import Header

from worm_msgs_py.units import NS_PER_S


def stamp_to_msg(stamp_ns: int) -> Time:
    """Convert nanoseconds since the source's epoch, 0 ≤ stamp < 2³¹ s, to a message."""
    return Time(sec=int(stamp_ns // NS_PER_S), nanosec=int(stamp_ns % NS_PER_S))


def stamp_to_ns(msg: Time) -> int:
    """Convert a message to nanoseconds since the source's epoch."""
    return int(msg.sec) * NS_PER_S + int(msg.nanosec)


def header(stamp_ns: int, frame_id: str) -> Header:
    """Return a header with this stamp and frame."""
    return Header(stamp=stamp_to_msg(stamp_ns), frame_id=str(frame_id))


def seconds_to_duration(seconds: float) -> Duration:
    """Convert seconds to a message, to the nanosecond."""
    total_ns = round(float(seconds) * NS_PER_S)
    return Duration(sec=int(total_ns // NS_PER_S), nanosec=int(total_ns % NS_PER_S))


def duration_to_seconds(msg: Duration) -> float:
    """Convert a duration message to seconds."""
    return int(msg.sec) + int(msg.nanosec) / NS_PER_S
