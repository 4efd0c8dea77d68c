"""Calibration: a picture (or what the user knows) in, the rig's `Geometry` out."""

from dataclasses import dataclass, field, replace
from math import atan2, hypot, isfinite, nan, radians, remainder, tau

import numpy as np

from worm_msgs_py.arrays import Picture
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.errors import NoChamberFound, TrackerError
from worm_msgs_py.paper import PASSAGE_LENGTH_MM
from worm_msgs_py.units import MM_PER_M
from worm_tracker.calibration.circle_fit import CircleFitSettings, FittedCircle, find_circles
from worm_tracker.calibration.exit_fit import ExitFitSettings, find_exit
from worm_tracker.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class CalibrationSettings:
    """What of a picture is believed to be the rig."""

    most_exit_off_rad: float = radians(3.0)
    """How far an exit may point past the other chamber's centre: the passage is straight."""
    least_ends_apart_px: float = 1.0
    least_ends_ratio_off: float = 0.05
    """By how much, and by which part of the wider one, two ends of a passage must differ in width
    for one to be disturbed: fits agree to 0.1 px, a worm on the water makes up to 4 px, and a mill
    is not exact."""
    black_grey: float = 8.0
    saturated_grey: float = 247.0
    least_contrast_grey: float = 12.0
    """Grey levels of a picture's brightest, darkest, and their difference, that say why no chamber
    was found."""
    most_move_px: float = 0.5
    """Pictures whose walls lie farther apart show a rig that moves; fits of one rig agree to 0.1
    px."""
    common_to_pictures_sd_px: float = 0.02
    """What all pictures have in common of the error of an edge: that of the half-height. Measured
    on simulated pictures with noise of 3 grey levels and a blur of 0.6 to 2 px."""
    circle: CircleFitSettings = field(default_factory=CircleFitSettings)
    exit: ExitFitSettings = field(default_factory=ExitFitSettings)


CALIBRATION = CalibrationSettings()


def calibrate(
    picture: Picture,
    parameters: TrackerParameters,
    stamp_ns: int,
    settings: CalibrationSettings = CALIBRATION,
) -> Geometry:
    """Find the chambers, their exits and the scale in one back-lit picture.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        Dark walls on bright water (an inverted picture for a bright worm).
    parameters : TrackerParameters
        What is given is not looked for.
    stamp_ns : int
        That of the geometry; its version is 1.
    settings : CalibrationSettings

    Returns
    -------
    Geometry
        The left chamber, or the one given first, is ``chamber_a``. Without an exit in view its x
        axis points to the right of the picture and `exit_width_m` is NaN.

    Raises
    ------
    NoChamberFound
        Where no circular wall stands out.
    TrackerError
        Where a circle that is given cannot be in this picture.
    """
    h, w = picture.shape
    if parameters.no_chamber:
        return Geometry(1, stamp_ns, w, h)
    circles = _given_circles(parameters, w, h) or sorted(
        find_circles(picture, settings.circle), key=lambda circle: circle.u
    )
    if not circles:
        raise NoChamberFound(_why_none(picture, settings))
    chambers = tuple(
        _chamber_of_circle(picture, circle, name, parameters, settings)
        for name, circle in zip((CHAMBER_A, CHAMBER_B), circles, strict=False)
    )
    chambers = with_shared_passage(chambers, settings)
    length = passage_length(chambers, parameters)
    return Geometry(1, stamp_ns, w, h, chambers, parameters.depth_m, length)


def passage_length(chambers: tuple[Chamber, ...], parameters: TrackerParameters) -> float:
    """Return the length L from wall to wall along the passage, m.

    It is what the user says, else what is seen, else (with one chamber in view) the paper's.
    """
    if isfinite(parameters.passage_m):
        return parameters.passage_m
    if len(chambers) < 2:
        return PASSAGE_LENGTH_MM / MM_PER_M
    a, b = chambers
    apart = hypot(b.centre_u_px - a.centre_u_px, b.centre_v_px - a.centre_v_px)
    return apart / a.px_per_m - a.radius_m - b.radius_m


def with_shared_passage(
    chambers: tuple[Chamber, ...], settings: CalibrationSettings
) -> tuple[Chamber, ...]:
    """Give two chambers that share a passage its width, where a worm hides one of its ends.

    The passage is straight, from circle to circle: an exit that points elsewhere, or was not seen,
    lies towards the other chamber's centre. Of two widths that differ one is disturbed.
    """
    if len(chambers) < 2 or not any(isfinite(chamber.exit_width_m) for chamber in chambers):
        return chambers
    a, b = chambers
    right, up = b.centre_u_px - a.centre_u_px, a.centre_v_px - b.centre_v_px
    sd = hypot(a.centre_sd_px, b.centre_sd_px) / hypot(right, up)
    towards = {a.name: atan2(up, right), b.name: atan2(-up, -right)}
    off = {c.name: abs(remainder(c.exit_rad - towards[c.name], tau)) for c in chambers}
    known = [
        c for c in chambers if isfinite(c.exit_width_m) and off[c.name] < settings.most_exit_off_rad
    ]
    if not known:
        return chambers
    if len(known) == 2:
        narrow, wide = sorted(known, key=lambda chamber: chamber.exit_width_m)
        apart_m = wide.exit_width_m - narrow.exit_width_m
        least_px = settings.least_ends_apart_px
        least_m = max(least_px / wide.px_per_m, settings.least_ends_ratio_off * wide.exit_width_m)
        if apart_m > least_m:
            # A worm along an edge narrows an exit, and turns its middle by half as much; one on the
            # water before it makes both edges seem farther out.
            turned = off[narrow.name] - off[wide.name] > apart_m / 4 / narrow.radius_m
            known = [wide] if turned else [narrow]
    width_m, width_sd_m = known[0].exit_width_m, known[0].exit_width_sd_m
    return tuple(
        c
        if c in known
        else replace(
            c,
            exit_rad=towards[c.name],
            exit_sd_rad=sd,
            exit_width_m=width_m,
            exit_width_sd_m=width_sd_m,
        )
        for c in chambers
    )


def _chamber_of_circle(
    picture: Picture,
    circle: FittedCircle,
    name: str,
    parameters: TrackerParameters,
    settings: CalibrationSettings,
) -> Chamber:
    """Return the chamber of one circle, with its exit where there is one."""
    exit_ = find_exit(picture, circle, settings.exit)
    metres = parameters.radius_m / circle.radius
    direction, sd = (exit_.direction_rad, exit_.direction_sd_rad) if exit_ else (0.0, nan)
    width, width_sd = (exit_.width_px * metres, exit_.width_sd_px * metres) if exit_ else (nan, nan)
    if isfinite(parameters.exit_deg) and name == CHAMBER_A:
        direction, sd = radians(parameters.exit_deg), nan
        width = parameters.exit_width_m if isfinite(parameters.exit_width_m) else width
    if exit_ and isfinite(parameters.exit_width_m):
        width, width_sd = parameters.exit_width_m, nan
    return Chamber(
        name=name,
        centre_u_px=circle.u,
        centre_v_px=circle.v,
        radius_px=circle.radius,
        exit_rad=direction,
        radius_m=parameters.radius_m,
        exit_width_m=width,
        residual_px=circle.residual,
        centre_sd_px=circle.centre_sd,
        radius_sd_px=circle.radius_sd,
        exit_sd_rad=sd,
        exit_width_sd_m=width_sd,
    )


def _given_circles(parameters: TrackerParameters, w: int, h: int) -> list[FittedCircle]:
    """Return the circles that the user gives, in that order; none where none is given."""
    if not parameters.chamber_given:
        return []
    circles = [FittedCircle(parameters.centre_u_px, parameters.centre_v_px, parameters.radius_px)]
    if isfinite(parameters.radius_b_px):
        second = FittedCircle(
            parameters.centre_b_u_px, parameters.centre_b_v_px, parameters.radius_b_px
        )
        circles.append(second)
    for circle, option in zip(circles, ("--circle-px", "--circle-b-px"), strict=False):
        _refuse_elsewhere(circle, option, w, h)
    return circles


def _refuse_elsewhere(circle: FittedCircle, option: str, w: int, h: int) -> None:
    """Refuse a circle that does not reach into the picture, or is far too large for it."""
    beyond_u, beyond_v = max(-circle.u, 0.0, circle.u - w), max(-circle.v, 0.0, circle.v - h)
    if circle.radius <= hypot(w, h) and hypot(beyond_u, beyond_v) < circle.radius:
        return
    raise TrackerError(
        f"{option} {circle.u:g} {circle.v:g} {circle.radius:g}: no such wall can be in pictures of "
        f"{w} x {h} px: give the centre's u and v and the radius in their pixels"
    )


def _why_none(picture: Picture, settings: CalibrationSettings) -> str:
    """Return one line that names the cause and the remedy."""
    low, high = (float(np.quantile(picture, q)) for q in (0.02, 0.98))
    if high < settings.black_grey:
        cause = "the picture is black"
    elif low > settings.saturated_grey:
        cause = "the picture is saturated"
    elif high - low < settings.least_contrast_grey:
        cause = "the picture has no contrast"
    else:
        cause = "no circular wall stands out in it"
    return (
        f"no chamber found: {cause}; check the light and the topic, give the circle "
        "(--circle-px U V R; of the node: centre_u_px, centre_v_px, radius_px), "
        "say --polarity bright where the worm is bright, "
        "or track without a rig (--no-chamber)"
    )
