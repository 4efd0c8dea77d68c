"""Counters that give the source its back-pressure."""

import array
from collections.abc import Sequence

from std_msgs.msg import UInt64, UInt64MultiArray

from worm_msgs_py.convert.message_checks import strict


def count_to_msg(count: int) -> UInt64:
    """Write one counter."""
    return UInt64(data=int(count))


@strict
def count_from_msg(msg: UInt64) -> int:
    """Read one counter."""
    return int(msg.data)


def counts_to_msg(counts: Sequence[int]) -> UInt64MultiArray:
    """Write several counters."""
    return UInt64MultiArray(data=array.array("Q", [int(count) for count in counts]))


@strict
def counts_from_msg(msg: UInt64MultiArray) -> tuple[int, ...]:
    """Read several counters."""
    return tuple(int(count) for count in msg.data)
