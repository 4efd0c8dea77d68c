"""Everything that a user may tell the tracker, with its default."""

from dataclasses import dataclass
from enum import StrEnum
from math import isfinite

from worm_tracker.errors import TrackerError

NAN = float("nan")


class Polarity(StrEnum):
    """How the worm looks against its surroundings."""

    DARK = "dark"
    BRIGHT = "bright"


@dataclass(frozen=True, slots=True)
class TrackerParameters:
    """Settings of a `Tracker`.

    Attributes
    ----------
    polarity : Polarity
        ``dark``: worm and walls are darker than the water (back light). ``bright``: the inverse.
    no_chamber : bool
        The pictures show no rig: nothing is looked for, and there are no metric coordinates unless
        `px_per_mm` is given.
    radius_m : float
        The chamber's known radius R, which gives the scale.
    centre_u_px, centre_v_px, radius_px : float
        The wall's circle, where it is given rather than looked for: all three or none.
    exit_deg : float
        Direction of the exit, counter-clockwise from the picture's right; looked for where NaN.
    px_per_mm : float
        Scale of pictures without a chamber; NaN where it is not known.
    hold_back_frames : int
        Most frames that wait for the decision which end is the head.
    calibration_frames : int
        Pictures that may fail to show a chamber before the tracker gives up.

    Raises
    ------
    TrackerError
        Where the values contradict each other or are out of range.
    """

    polarity: Polarity = Polarity.DARK
    no_chamber: bool = False
    radius_m: float = 0.01
    centre_u_px: float = NAN
    centre_v_px: float = NAN
    radius_px: float = NAN
    exit_deg: float = NAN
    px_per_mm: float = NAN
    hold_back_frames: int = 256
    calibration_frames: int = 10

    def __post_init__(self) -> None:
        if self.polarity not in tuple(Polarity):
            raise TrackerError(f"polarity must be 'dark' or 'bright', not {self.polarity!r}")
        object.__setattr__(self, "polarity", Polarity(self.polarity))
        given = [isfinite(x) for x in (self.centre_u_px, self.centre_v_px, self.radius_px)]
        if any(given) and not all(given):
            raise TrackerError(
                "the chamber is given in part: give centre_u_px, centre_v_px and radius_px, or none"
            )
        if self.no_chamber and (any(given) or isfinite(self.exit_deg)):
            raise TrackerError("no_chamber contradicts a given chamber or exit: leave one of them")
        for name in ("radius_m", "radius_px", "px_per_mm"):
            value = getattr(self, name)
            if value <= 0 or value == float("inf"):
                raise TrackerError(f"{name} must be positive, not {value}")
        if self.hold_back_frames < 0 or self.calibration_frames < 1:
            raise TrackerError("hold_back_frames must be 0 or more, calibration_frames 1 or more")

    @property
    def chamber_given(self) -> bool:
        """Whether the wall's circle is given rather than looked for."""
        return isfinite(self.radius_px)
