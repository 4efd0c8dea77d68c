"""Between which numbers a quantity makes sense, and which unit a number that does not may be in."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import isfinite, isnan

_FAMILIES: tuple[Mapping[str, float], ...] = (
    {"m": 1.0, "µm": 1e-6, "mm": 1e-3},
    {"ms": 1e-3, "s": 1.0, "ns": 1e-9},
    {"m/s": 1.0, "µm/s": 1e-6, "mm/s": 1e-3},
    {"px/m": 1e-3, "px/µm": 1e3, "px/mm": 1.0},
)
"""Units of one kind, the likelier mistakes first, and what they are in one of them."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The least and the greatest value that makes sense.

    Attributes
    ----------
    low, high : float
        Both are allowed.
    unit : str
        Of them; empty for a pure number.
    or_zero : bool
        0 is allowed too, where `low` is above it.
    """

    low: float
    high: float
    unit: str = ""
    or_zero: bool = False

    def to(self, unit: str) -> "Limit":
        """Return the same limit in another unit of the same kind."""
        scale = _family(self.unit)[self.unit] / _family(self.unit)[unit]
        return Limit(_rounded(self.low * scale), _rounded(self.high * scale), unit, self.or_zero)

    def allows(self, value: float) -> bool:
        """Tell whether a value makes sense; NaN and infinity never do."""
        return self.low <= value <= self.high or (self.or_zero and value == 0)

    def refusal(self, value: float) -> str:
        """Return what is wrong with a value and what to give instead; empty where it is right.

        It goes on from the name of what has the value: ``is 0.01: give 0.5 to 500 mm ...``.
        """
        if self.allows(value):
            return ""
        return f"is {value:.10g}: give {self.in_words()}{self._other_unit(value)}"

    def in_words(self) -> str:
        """Return the range with its unit, such as ``0, or 0.01 to 500 mm``."""
        zero = "0, or " if self.or_zero else ""
        return f"{zero}{self.low:.10g} to {self.high:.10g} {self.unit}".strip()

    def _other_unit(self, value: float) -> str:
        """Return in which other unit the value would make sense, and what it is in this one."""
        family = _family(self.unit)
        for unit, size in family.items():
            meant = value * size / family[self.unit]
            if unit != self.unit and meant and isfinite(meant) and self.allows(meant):
                return f" (if that is in {unit}, give {_rounded(meant):g})"
        return ""


def _family(unit: str) -> Mapping[str, float]:
    return next((family for family in _FAMILIES if unit in family), {unit: 1.0})


def _rounded(value: float) -> float:
    return float(f"{value:.12g}")


def first_refusal(
    parameters: object, limits: Mapping[str, Limit], may_lack: Collection[str] = ()
) -> str:
    """Return one line on the first attribute that is out of its limits; empty where none is.

    Parameters
    ----------
    parameters : object
        Has the attributes.
    limits : mapping
        By the attribute's name.
    may_lack : collection of str
        Attributes for which NaN, or None, says that they are not known.
    """
    for name, limit in limits.items():
        value = getattr(parameters, name)
        if name in may_lack and (value is None or isnan(value)):
            continue
        wrong = limit.refusal(value)
        if wrong:
            return f"{name} {wrong}"
    return ""


RADIUS = Limit(0.5e-3, 0.5, "m")
"""R: from a drop to a basin."""
EXIT_WIDTH = Limit(0.01e-3, 0.5, "m")
DEPTH = Limit(0.01e-3, 0.1, "m")
PASSAGE_LENGTH = Limit(0.1e-3, 1.0, "m")
BODY_WIDTH = Limit(0.01e-3, 9.9e-3, "m")
PX_PER_MM = Limit(0.1, 1e4, "px/mm")
ANGLE = Limit(-360.0, 360.0, "degrees")
PLACE_PX = Limit(-1e5, 1e5, "px")
RADIUS_PX = Limit(8.0, 5e3, "px")
CONTACT_FACTOR = Limit(0.01, 10.0)
"""R - r_h in units of the worm's width: the paper's 0.3."""
FRAME_RATE = Limit(1e-4, 1e5, "frames/s")
"""From a picture in three hours to a high-speed camera."""
JPEG_QUALITY = Limit(1, 100)
PAGE_PORT = Limit(0, 65535)
SEED = Limit(0, 2**32 - 1)
SHARE = Limit(0.0, 1.0)
