"""Where the exit is, in the chamber's frame: its arc on the wall and the passage behind it."""

from dataclasses import dataclass
from math import asin, hypot, nan, radians, sqrt

from worm_msgs_py import Chamber


@dataclass(frozen=True, slots=True)
class ExitSettings:
    """What is told at the exit.

    Attributes
    ----------
    noise_in_error, pixels_in_error : float
        How far a head in the exit may be from where it is seen: deviations of the noise, or pixels,
        whichever is more.
    seen_well_s : float
        Between frames that are further apart the head may go faster than from frame to frame.
    fewest_lengths : int
        Frames with a length before the head turns back that the phase of the stroke needs.
    length_slope_errors : float
        The body grows or shrinks where its length's slope is so many of its standard errors.
    first_touch_in_doubt_rad : float
        Where the head may have touched the wall earlier and further away, θ_h⁰ is not told.
    deepest_skip_in_radii : float
        A skip is flown nearer to the wall than to the centre.
    """

    noise_in_error: float = 2.0
    pixels_in_error: float = 0.5
    seen_well_s: float = 0.04
    fewest_lengths: int = 5
    length_slope_errors: float = 2.0
    first_touch_in_doubt_rad: float = radians(1.0)
    deepest_skip_in_radii: float = 0.5


EXITS = ExitSettings()


@dataclass(frozen=True, slots=True)
class ExitCorridor:
    """The exit of one chamber; x runs along the passage, y across it.

    Attributes
    ----------
    radius_m : float
        R.
    half_width_m : float
        W/2; NaN where the width is not known.
    half_arc_rad : float
        Half of the angle that the exit takes up on the wall; NaN where W is not known.
    mouth_x_m : float
        Where the passage's straight walls meet the circle: x_p counts from here.
    effective_half_arc_rad : float
        Half of the angle of an exit that is w_s = √(W² + h²) wide; NaN where W or h is not known.
    """

    radius_m: float
    half_width_m: float
    half_arc_rad: float
    mouth_x_m: float
    effective_half_arc_rad: float

    @classmethod
    def of(cls, chamber: Chamber, depth_m: float) -> "ExitCorridor":
        """Return the exit of a chamber that is `depth_m` deep."""
        radius_m, half_width_m = chamber.radius_m, chamber.exit_width_m / 2
        if half_width_m != half_width_m:
            return cls(radius_m, nan, nan, radius_m, nan)
        half_width_m = min(half_width_m, radius_m)
        mouth_x_m = radius_m - sagitta(radius_m, 2 * half_width_m)
        effective = min(hypot(half_width_m, depth_m / 2) / radius_m, 1.0)
        return cls(
            radius_m,
            half_width_m,
            asin(half_width_m / radius_m),
            mouth_x_m,
            asin(effective) if depth_m == depth_m else nan,
        )

    @property
    def is_known(self) -> bool:
        """Whether an exit is in view and its width is known."""
        return self.half_width_m == self.half_width_m

    def has_between_walls(self, x_m: float, y_m: float) -> bool:
        """Whether a point is between the passage's walls, or before its mouth."""
        return x_m > 0 and abs(y_m) <= self.half_width_m

    def holds(self, x_m: float, y_m: float) -> bool:
        """Whether a point is beyond the wall's circle and between the passage's walls."""
        return self.has_between_walls(x_m, y_m) and hypot(x_m, y_m) > self.radius_m

    def encloses(self, x_m: float, y_m: float) -> bool:
        """Whether a point is beyond the wall's circle and in the passage.

        Where W is not known, all beyond the circle on the exit's side is the passage.
        """
        beside = abs(y_m) > self.half_width_m
        return x_m > 0 and hypot(x_m, y_m) > self.radius_m and not beside

    def is_left(self, x_m: float, y_m: float, threshold_m: float) -> bool:
        """Whether a head that was in the exit is back in the chamber.

        It is when it is further inside the circle than `threshold_m`, or beside the exit at the
        wall. The threshold keeps a head that rests on the circle from entering again and again.
        """
        r = hypot(x_m, y_m)
        beside = r < self.radius_m + threshold_m and abs(y_m) > self.half_width_m
        return r < self.radius_m - threshold_m or beside


def sagitta(radius_m: float, exit_width_m: float) -> float:
    """Return how far the circle bulges over the mouth of an exit; 0 where W is not known."""
    if exit_width_m != exit_width_m:
        return 0.0
    return radius_m - sqrt(radius_m**2 - min(exit_width_m / 2, radius_m) ** 2)
