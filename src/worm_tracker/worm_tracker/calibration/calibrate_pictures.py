"""Calibration from many pictures: polarity, and what they agree on of the rig, with its error."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, isfinite, nan

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.errors import NoChamberFound, TrackerError
from worm_msgs_py.intervals import SD_OF_MAD
from worm_tracker.calibration.calibrate import (
    CALIBRATION,
    CalibrationSettings,
    calibrate,
    passage_length,
)
from worm_tracker.detection.polarity import Polarity, dark_on_bright
from worm_tracker.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class PicturesCalibration:
    """What the pictures of a rig agree on.

    Attributes
    ----------
    polarity : Polarity
    geometry : Geometry
        Medians over the pictures: a worm before an exit changes its width in some. Each standard
        deviation is the larger of the fits' own and of the scatter between pictures, and no smaller
        than what they share: many pictures through one lens are no surer than one.
    showing, looked_at : int
        Pictures that show the rig, of how many.
    """

    polarity: Polarity
    geometry: Geometry
    showing: int
    looked_at: int


def calibrate_pictures(
    pictures: Sequence[Picture],
    parameters: TrackerParameters,
    polarity: Polarity | None = None,
    settings: CalibrationSettings = CALIBRATION,
) -> PicturesCalibration:
    """Find polarity, walls, exits and scale in pictures of one rig that stands still.

    Parameters
    ----------
    pictures : sequence of ndarray of uint8, shape (h, w)
        All of one size, as they came, spread over the trial so that the worm hides different parts.
    parameters : TrackerParameters
        What is given is not looked for; its polarity is not used.
    polarity : Polarity, optional
        Where it is known.
    settings : CalibrationSettings

    Raises
    ------
    NoChamberFound
        In most of the pictures no circular wall stands out.
    TrackerError
        Both polarities show a chamber; or the rig moves between the pictures.
    """
    found = {
        each: _geometries(pictures, replace(parameters, polarity=each), settings)
        for each in ((polarity,) if polarity is not None else tuple(Polarity))
    }
    enough = [each for each, geometries in found.items() if 2 * len(geometries) > len(pictures)]
    if not enough:
        seen = max(map(len, found.values()))
        raise NoChamberFound(
            f"{seen} of {len(pictures)} pictures show a circular wall: check light, focus and "
            "topic, or give the circle to worm replay by hand (--circle-px)"
        )
    if len(enough) > 1:
        raise TrackerError(
            "a wall stands out as dark and as bright: say --polarity dark where the worm is darker "
            "than the water, --polarity bright where it is brighter"
        )
    geometries = found[enough[0]]
    counts = [len(geometry.chambers) for geometry in geometries]
    usual = max(set(counts), key=counts.count)
    alike = [geometry for geometry in geometries if len(geometry.chambers) == usual]
    views = zip(*(geometry.chambers for geometry in alike), strict=True)
    chambers = tuple(_median_chamber(views_of_one, settings) for views_of_one in views)
    length_m = passage_length(chambers, parameters)
    geometry = replace(alike[0], chambers=chambers, passage_length_m=length_m)
    return PicturesCalibration(enough[0], geometry, len(alike), len(pictures))


def _geometries(
    pictures: Sequence[Picture], parameters: TrackerParameters, settings: CalibrationSettings
) -> list[Geometry]:
    found = []
    for picture in pictures:
        try:
            dark = dark_on_bright(picture, parameters.polarity)
            found.append(calibrate(dark, parameters, 0, settings))
        except NoChamberFound:
            continue
    return found


def _median_chamber(seen: Sequence[Chamber], settings: CalibrationSettings) -> Chamber:
    """Return the medians of one chamber over the pictures, and what they are uncertain by.

    Raises
    ------
    TrackerError
        The pictures show it in different places.
    """
    u, v = _values(seen, "centre_u_px"), _values(seen, "centre_v_px")
    radius, radius_sd = _median(seen, "radius_px", "radius_sd_px")
    off_px = float(np.hypot(u - np.median(u), v - np.median(v)).max())
    if off_px > settings.most_move_px:
        raise TrackerError(
            f"the wall of {seen[0].name} lies up to {off_px:.1f} px from where most pictures show "
            "it: a rig file is for a camera that stands still; a replay without circles in it "
            "follows the rig"
        )
    scatter = hypot(_robust_sd(u), _robust_sd(v))
    centre_sd = max(float(np.median(_values(seen, "centre_sd_px"))), scatter)
    open_ = [chamber for chamber in seen if isfinite(chamber.exit_width_m)]
    agreed = replace(
        seen[0],
        centre_u_px=float(np.median(u)),
        centre_v_px=float(np.median(v)),
        radius_px=radius,
        residual_px=float(np.median(_values(seen, "residual_px"))),
        centre_sd_px=hypot(settings.common_to_pictures_sd_px, centre_sd),
        radius_sd_px=hypot(settings.common_to_pictures_sd_px, radius_sd),
    )
    if 2 * len(open_) <= len(seen):
        return replace(agreed, exit_width_m=nan, exit_width_sd_m=nan, exit_sd_rad=nan)
    return with_agreed_exit(agreed, open_, settings)


def with_agreed_exit(
    chamber: Chamber, seen: Sequence[Chamber], settings: CalibrationSettings
) -> Chamber:
    """Return a chamber with the exit that looks at it agree on: medians, and their uncertainty.

    Parameters
    ----------
    chamber : Chamber
    seen : sequence of Chamber
        The same one, with the exit that each look showed.
    settings : CalibrationSettings
    """
    width_m, width_sd_m = _median(seen, "exit_width_m", "exit_width_sd_m")
    turns = _values(seen, "exit_rad")
    off_rad = np.angle(np.exp(1j * (turns - turns[0])))
    turn_sd = max(float(np.median(_values(seen, "exit_sd_rad"))), _robust_sd(off_rad))
    return replace(
        chamber,
        exit_rad=float(turns[0] + np.median(off_rad)),
        exit_sd_rad=hypot(settings.common_to_pictures_sd_px / chamber.radius_px, turn_sd),
        exit_width_m=width_m,
        exit_width_sd_m=width_sd_m,
    )


def _median(chambers: Sequence[Chamber], name: str, sd_name: str) -> tuple[float, float]:
    """Return the median of a number, and the larger of its fits' own sd and its scatter.

    The latter is NaN where the number was given.
    """
    values, own = _values(chambers, name), float(np.median(_values(chambers, sd_name)))
    return float(np.median(values)), max(own, _robust_sd(values)) if isfinite(own) else nan


def _values(chambers: Sequence[Chamber], name: str) -> Floats:
    return np.array([getattr(chamber, name) for chamber in chambers], np.float64)


def _robust_sd(values: Floats) -> float:
    """Return the standard deviation that the median distance from the median tells."""
    return float(SD_OF_MAD * np.median(np.abs(values - np.median(values))))
