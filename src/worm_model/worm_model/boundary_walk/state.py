"""A state of the boundary walk: where the head is, which way it goes, and in which phase."""

from dataclasses import dataclass
from enum import StrEnum
from math import isfinite


class Direction(StrEnum):
    """The way along the wall, as seen in the picture."""

    COUNTER_CLOCKWISE = "ccw"
    """θ_h grows."""
    CLOCKWISE = "cw"
    """θ_h falls."""


class Phase(StrEnum):
    """Whether the head is in contact with the wall."""

    SLIDE = "slide"
    HOP = "hop"


@dataclass(frozen=True, slots=True)
class WalkState:
    """A state of the walk.

    Attributes
    ----------
    theta_rad : float
        θ_h: angle from the middle of the exit, counter-clockwise positive, in the chamber's own
        frame; any turn of it.
    direction : Direction
        Which way it goes.
    phase : Phase
        Slide or hop. How long the phase has lasted does not matter: distances are exponential.

    Raises
    ------
    ValueError
        Where the angle is not a number.
    """

    theta_rad: float
    direction: Direction
    phase: Phase = Phase.SLIDE

    def __post_init__(self) -> None:
        if not isfinite(self.theta_rad):
            raise ValueError(f"theta_rad is {self.theta_rad}; it must be a finite angle")
