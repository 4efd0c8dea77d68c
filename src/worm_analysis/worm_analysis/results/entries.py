"""Takes single entries out of a summary that others may have written: of the right kind, or not."""

import re
from collections.abc import Collection, Mapping
from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST_NUMBER = 1e15
"""No number of a trial is larger, stamps apart, which are in the tables."""
LONGEST_TEXT = 2000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.+-]{0,99}\Z")


def name(text: Any) -> str:
    """Return a name of ours: letters, digits and _; it is drawn in figures as it is."""
    if not isinstance(text, str) or not _NAME.match(text):
        raise ValueError(f"{str(text)[:60]!r} is no name")
    return text


def one_of(text: Any, known: Collection[str]) -> str:
    """Return a word that is known."""
    if text not in known:
        raise ValueError(f"{str(text)[:60]!r} is none of {', '.join(known)}")
    return str(text)


def words(text: Any) -> str:
    """Return text for people; empty for null. A figure would take $ for a formula."""
    if text is None:
        return ""
    if not isinstance(text, str) or len(text) > LONGEST_TEXT or "$" in text:
        raise ValueError(f"{str(text)[:60]!r} is no text of ours")
    return text


def as_number(value: Any) -> float:
    """Return a number; NaN for null."""
    if value is None:
        return nan
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) <= LARGEST_NUMBER
    ):
        raise ValueError(f"{str(value)[:60]!r} is no number of a trial")
    return float(value)


def number_or_none(value: Any) -> Any:
    """Return a number as it is; None for null."""
    as_number(value)
    return value


def as_count(value: Any) -> int:
    """Return a number of items; 0 for null."""
    found = 0.0 if value is None else as_number(value)
    if found != int(found) or found < 0:
        raise ValueError(f"{str(value)[:60]!r} is no number of items")
    return int(found)


def as_numbers(values: Any) -> NDArray[np.float64]:
    """Return numbers; NaN for each null."""
    if not isinstance(values, list | tuple):
        raise TypeError(f"{str(values)[:60]!r} is no list of numbers")
    return np.array([as_number(value) for value in values], dtype=np.float64)


def mapping(value: Any) -> Mapping[str, Any]:
    """Return a JSON object; empty for null."""
    if value is None:
        return {}
    if not isinstance(value, dict):
        raise TypeError(f"{str(value)[:60]!r} is no JSON object")
    return value
