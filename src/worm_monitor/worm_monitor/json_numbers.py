"""Numbers as a page can read them: JSON has no NaN, and digits that nobody sees cost time."""

from collections.abc import Iterable
from math import isfinite

Number = float | None
JsonRow = list[Number]


def rounded(value: float | None, digits: int = 5) -> Number:
    """Return a number to so many significant digits; None where there is none."""
    return None if value is None or not isfinite(value) else float(f"{value:.{digits}g}")


def rounded_all(values: Iterable[float], scale: float = 1.0, digits: int = 5) -> JsonRow:
    """Return numbers, each times a scale."""
    return [rounded(float(value) * scale, digits) for value in values]
