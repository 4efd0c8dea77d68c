"""Numbers as people write them: as many digits as their interval supports."""

from math import floor, isfinite, log10

from worm_msgs_py import Quantity

LEAST_IN_PLAIN = 1e-4
"""A number without an interval below this is written as a power of ten."""
ROUNDING_PART = 1e-12
"""An interval that is a smaller part of the value is rounding, and none."""
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def decimals_for(value: float, low: float | None = None, high: float | None = None) -> int:
    """Return how many decimals to write.

    Two significant digits of the interval's shorter side, or of the one that it has; without an
    interval, three significant digits of the value.
    """
    ends = [end for end in (low, high) if end is not None]
    half = min((abs(end - value) for end in ends if end != value), default=0.0)
    if half > ROUNDING_PART * abs(value) and isfinite(half):
        return max(0, 1 - floor(log10(half)))
    if value == 0 or not isfinite(value):
        return 0
    return max(0, 2 - floor(log10(abs(value))))


def written(value: float | None, decimals: int) -> str:
    """Write a number with a true minus sign; a dash for none."""
    if value is None or not isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    if float(text) == 0:
        text = text.removeprefix("-")
    return text.replace("-", "−")


def plain(value: float | None, digits: int = 3) -> str:
    """Write a number with so many significant digits, without an exponent where it is legible."""
    if value is None or not isfinite(value):
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}".replace("-", "−")
    decimals = max(0, digits - 1 - floor(log10(abs(value)))) if value else 0
    text = f"{value:.{decimals}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace("-", "−")


def with_deviation(value: float, deviation: float) -> str:
    """Write a number ± one standard deviation; without one, three decimals at most."""
    if not (isfinite(deviation) and deviation > 0):
        return plain(round(value, 3), 7) if isfinite(value) else "–"
    decimals = decimals_for(0.0, -deviation, deviation)
    return f"{written(value, decimals)} ± {written(deviation, decimals)}"


def interval(quantity: Quantity) -> str:
    """Write the 95 % interval, or the end that the data bound; a dash where there is none."""
    low, high = quantity.low, quantity.high
    if quantity.value is None or (low is None and high is None):
        return "–"
    decimals = decimals_for(quantity.value, low, high)
    if low is None:
        return f"≤ {written(high, decimals)}"
    if high is None:
        return f"≥ {written(low, decimals)}"
    return f"{written(low, decimals)} … {written(high, decimals)}"


def value(quantity: Quantity) -> str:
    """Write the value with the digits that its interval supports."""
    if quantity.value is None:
        return "–"
    if quantity.low is quantity.high is None and 0 < abs(quantity.value) < LEAST_IN_PLAIN:
        power = floor(log10(abs(quantity.value)))
        return f"{written(quantity.value / 10.0**power, 1)}·10{str(power).translate(_RAISED)}"
    return written(quantity.value, decimals_for(quantity.value, quantity.low, quantity.high))


def with_interval(quantity: Quantity) -> str:
    """Write the value and, where there is one, its interval in brackets."""
    between = interval(quantity)
    return value(quantity) if between == "–" else f"{value(quantity)} [{between}]"
