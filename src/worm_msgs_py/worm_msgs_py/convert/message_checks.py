"""One error for every message that does not hold what ours hold."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from worm_msgs_py.errors import MalformedMessage

_Given = ParamSpec("_Given")
_Read = TypeVar("_Read")
_WHOLE_LIMIT = 2.0**53


def strict(read: Callable[_Given, _Read]) -> Callable[_Given, _Read]:
    """Let a conversion from a message raise `MalformedMessage`, whatever is wrong with it."""

    @wraps(read)
    def read_or_refuse(*args: _Given.args, **kwargs: _Given.kwargs) -> _Read:
        try:
            return read(*args, **kwargs)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise MalformedMessage(f"{type(error).__name__}: {error}") from error

    return read_or_refuse


def whole(value: float) -> int:
    """Return a number that counts something; ValueError where it cannot."""
    if not 0.0 <= value <= _WHOLE_LIMIT or value != int(value):
        raise ValueError(f"{value!r} counts nothing")
    return int(value)
