"""Everything that a user may tell the tracker, with its default."""

from dataclasses import dataclass
from math import hypot, isfinite, nan

from worm_msgs_py import limits
from worm_msgs_py.declarations import declare, first_refusal_of
from worm_msgs_py.errors import TrackerError
from worm_msgs_py.units import MM_PER_M
from worm_tracker.detection.polarity import Polarity
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS, MEGAPIXELS

_LOOKED_FOR = {"or_else": nan, "means": "looked for"}
_NOT_GIVEN_PX = {"or_else": nan, "means": "not given"}


MOST_HOLD_BACK_FRAMES = 1000
"""Most frames that may wait, and what a replay takes, where nobody waits for the poses: a worm that
lies folded when the film begins may take long to show which end is its head. More would take
memory (0.2 MiB a frame of a fold), and given at once overrun what DDS keeps."""
HOLD_BACK = limits.Limit(0, MOST_HOLD_BACK_FRAMES, "frames")


@dataclass(frozen=True, slots=True)
class TrackerParameters:
    """Settings of a `Tracker`.

    Raises
    ------
    TrackerError
        Where the values contradict each other or are out of range.
    """

    polarity: Polarity = declare(  # noqa: RUF009 (it is a field)
        Polarity.DARK,
        "How worm and walls look against the water: dark (back light) or bright.",
        choices=tuple(Polarity),
    )
    no_chamber: bool = declare(
        False,
        "The pictures show no rig: nothing is looked for, and there are no metric coordinates "
        "unless px_per_mm is given.",
    )
    radius_m: float = declare(
        0.01, "Known radius R of the chamber, which gives the scale.", limits.RADIUS
    )
    centre_u_px: float = declare(
        nan,
        "Column u of the centre of the wall's circle, given with v and the radius or not at all.",
        limits.PLACE_PX,
        **_LOOKED_FOR,
    )
    centre_v_px: float = declare(
        nan, "Row v of the centre of the wall's circle.", limits.PLACE_PX, **_LOOKED_FOR
    )
    radius_px: float = declare(nan, "Radius of the wall's circle.", limits.RADIUS_PX, **_LOOKED_FOR)
    centre_b_u_px: float = declare(
        nan,
        "Column u of the centre of a second chamber, whose exit faces the first one.",
        limits.PLACE_PX,
        **_NOT_GIVEN_PX,
    )
    centre_b_v_px: float = declare(
        nan, "Row v of the centre of a second chamber.", limits.PLACE_PX, **_NOT_GIVEN_PX
    )
    radius_b_px: float = declare(
        nan, "Radius of a second chamber.", limits.RADIUS_PX, **_NOT_GIVEN_PX
    )
    exit_deg: float = declare(
        nan,
        "Direction of the exit, counter-clockwise from the picture's right.",
        limits.ANGLE,
        **_LOOKED_FOR,
    )
    exit_width_m: float = declare(
        nan, "Width W of the exits.", limits.EXIT_WIDTH, or_else=nan, means="measured"
    )
    depth_m: float = declare(
        1.5e-3,
        "Thickness h of the sheet, which a picture from above does not show.",
        limits.DEPTH,
    )
    passage_m: float = declare(
        nan,
        "Length L of the passage.",
        limits.PASSAGE_LENGTH,
        or_else=nan,
        means="measured where both chambers are in view, else the paper's",
    )
    px_per_mm: float = declare(
        nan,
        "Scale of pictures without a chamber.",
        limits.PX_PER_MM,
        or_else=nan,
        means="not known",
    )
    hold_back_frames: int = declare(
        256,
        "Most frames that wait for the decision which end is the head (worm replay: 1000).",
        HOLD_BACK,
    )
    calibration_frames: int = declare(
        10,
        "Pictures that may fail to show a chamber before the tracker gives up.",
        limits.Limit(1, 1e5, "frames"),
    )
    max_megapixels: float = declare(
        MAX_MEGAPIXELS, "Larger pictures are bad ones: they are not decoded.", MEGAPIXELS
    )

    def __post_init__(self) -> None:
        wrong = first_refusal_of(self)
        if wrong:
            raise TrackerError(wrong)
        object.__setattr__(self, "polarity", Polarity(self.polarity))
        self._check_circles()
        if self.no_chamber and (self.chamber_given or isfinite(self.exit_deg)):
            raise TrackerError("no_chamber contradicts a given chamber or exit: leave one of them")
        if isfinite(self.px_per_mm) and not self.no_chamber:
            raise TrackerError(
                "px_per_mm (--px-per-mm) is the scale of pictures without a chamber, whose radius "
                "gives it: leave it out, or set no_chamber (--no-chamber)"
            )
        if self.exit_width_m >= 2 * self.radius_m:
            width_mm, across_mm = self.exit_width_m * MM_PER_M, 2 * self.radius_m * MM_PER_M
            raise TrackerError(
                f"--exit-width-mm (exit_width_m) is {width_mm:g} mm: an exit is narrower than its "
                f"chamber, {across_mm:g} mm across"
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
