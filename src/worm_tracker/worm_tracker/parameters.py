"""Everything that a user may tell the tracker, with its default."""

from dataclasses import dataclass
from math import hypot, isfinite, nan

from worm_msgs_py import limits
from worm_msgs_py.errors import TrackerError
from worm_tracker.polarity import Polarity
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS, MEGAPIXELS

TRACKER_LIMITS = {
    "radius_m": limits.RADIUS,
    "centre_u_px": limits.PLACE_PX,
    "centre_v_px": limits.PLACE_PX,
    "radius_px": limits.RADIUS_PX,
    "centre_b_u_px": limits.PLACE_PX,
    "centre_b_v_px": limits.PLACE_PX,
    "radius_b_px": limits.RADIUS_PX,
    "exit_deg": limits.ANGLE,
    "exit_width_m": limits.EXIT_WIDTH,
    "depth_m": limits.DEPTH,
    "passage_m": limits.PASSAGE_LENGTH,
    "px_per_mm": limits.PX_PER_MM,
    "hold_back_frames": limits.Limit(0, 1e5),
    "calibration_frames": limits.Limit(1, 1e5),
    "max_megapixels": MEGAPIXELS,
}
MAY_LACK = frozenset(TRACKER_LIMITS) - {
    "radius_m",
    "depth_m",
    "hold_back_frames",
    "calibration_frames",
    "max_megapixels",
}
"""NaN says of these that they are to be looked for, or are not known."""


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
    centre_b_u_px, centre_b_v_px, radius_b_px : float
        The same of a second chamber, whose exit faces the first one.
    exit_deg : float
        Direction of the exit, counter-clockwise from the picture's right; looked for where NaN.
    exit_width_m : float
        Width W of the exits; measured where NaN.
    depth_m : float
        Thickness h of the sheet, which a picture from above does not show.
    passage_m : float
        Length L of the passage; where NaN it is measured if both chambers are in view, else the
        paper's.
    px_per_mm : float
        Scale of pictures without a chamber; NaN where it is not known.
    hold_back_frames : int
        Most frames that wait for the decision which end is the head.
    calibration_frames : int
        Pictures that may fail to show a chamber before the tracker gives up.
    max_megapixels : float
        Larger pictures are bad ones: they are not decoded.

    Raises
    ------
    TrackerError
        Where the values contradict each other or are out of range.
    """

    polarity: Polarity = Polarity.DARK
    no_chamber: bool = False
    radius_m: float = 0.01
    centre_u_px: float = nan
    centre_v_px: float = nan
    radius_px: float = nan
    centre_b_u_px: float = nan
    centre_b_v_px: float = nan
    radius_b_px: float = nan
    exit_deg: float = nan
    exit_width_m: float = nan
    depth_m: float = 1.5e-3
    passage_m: float = nan
    px_per_mm: float = nan
    hold_back_frames: int = 256
    calibration_frames: int = 10
    max_megapixels: float = MAX_MEGAPIXELS

    def __post_init__(self) -> None:
        if self.polarity not in tuple(Polarity):
            raise TrackerError(f"polarity must be 'dark' or 'bright', not {self.polarity!r}")
        object.__setattr__(self, "polarity", Polarity(self.polarity))
        self._check_circles()
        if self.no_chamber and (self.chamber_given or isfinite(self.exit_deg)):
            raise TrackerError("no_chamber contradicts a given chamber or exit: leave one of them")
        wrong = limits.first_refusal(self, TRACKER_LIMITS, MAY_LACK)
        if wrong:
            raise TrackerError(wrong)
        if isfinite(self.px_per_mm) and not self.no_chamber:
            raise TrackerError(
                "px_per_mm (--px-per-mm) is the scale of pictures without a chamber, whose radius "
                "gives it: leave it out, or set no_chamber (--no-chamber)"
            )
        if self.exit_width_m >= 2 * self.radius_m:
            raise TrackerError(
                f"--exit-width-mm (exit_width_m) is {1e3 * self.exit_width_m:g} mm: an exit is "
                f"narrower than its chamber, {2e3 * self.radius_m:g} mm across"
            )

    def _check_circles(self) -> None:
        """Refuse a circle that is given in part, and a second one without a first."""
        first = (self.centre_u_px, self.centre_v_px, self.radius_px)
        second = (self.centre_b_u_px, self.centre_b_v_px, self.radius_b_px)
        for which, circle in (("the chamber", first), ("the second chamber", second)):
            if any(isfinite(x) for x in circle) and not all(isfinite(x) for x in circle):
                raise TrackerError(
                    f"{which} is given in part: give the centre's u and v and the radius, or none"
                )
        if isfinite(second[0]) and not isfinite(first[0]):
            raise TrackerError(
                "the second chamber (--circle-b-px) is given without the first (--circle-px): "
                "give both"
            )
        apart_px = hypot(first[0] - second[0], first[1] - second[1])
        if apart_px < first[2] + second[2]:  # False where one of them is not given
            raise TrackerError(
                f"the second chamber (--circle-b-px) overlaps the first: their centres are "
                f"{apart_px:g} px apart, their radii {first[2]:g} and {second[2]:g} px: give "
                "circles that lie beside each other"
            )

    @property
    def chamber_given(self) -> bool:
        """Whether the wall's circle is given rather than looked for."""
        return isfinite(self.radius_px)

    @property
    def exit_given(self) -> bool:
        """Whether the exit's direction and width are given rather than looked for."""
        return isfinite(self.exit_deg) and isfinite(self.exit_width_m)
