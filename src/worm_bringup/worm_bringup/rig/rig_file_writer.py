"""What a calibration has found, in words, as a rig file, and as a picture to look at."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, floor, hypot, isfinite, isnan, log10
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from worm_bringup.overlay.drawing import draw_over
from worm_bringup.overlay.shapes import Ink, Polyline, Shapes, shapes_of_rig
from worm_msgs_py.arrays import Picture
from worm_msgs_py.colours import CENTROID_COLOUR
from worm_msgs_py.contract.chamber import Chamber
from worm_msgs_py.units import MM_PER_M
from worm_tracker.calibration.calibrate_pictures import PicturesCalibration

_SCALE_BARS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
_FROM_EDGE = 0.04
"""Where the scale bar begins, in sides of the picture."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One parameter of the rig file.

    Attributes
    ----------
    value
        As the node takes it.
    sd : float
        One standard deviation, in its own unit; NaN where it was given.
    """

    value: Any
    sd: float = float("nan")


def found_entries(found: PicturesCalibration, told: Mapping[str, Any]) -> dict[str, Entry]:
    """Return the tracker's parameters: what was told, and what the pictures show."""
    entries = {name: Entry(value) for name, value in told.items() if not _is_nan(value)}
    entries["polarity"] = Entry(str(found.polarity))
    chambers = found.geometry.chambers
    entries["radius_m"] = Entry(chambers[0].radius_m)
    for chamber, letter in zip(chambers, ("", "b_"), strict=False):
        entries[f"centre_{letter}u_px"] = Entry(chamber.centre_u_px, chamber.centre_sd_px)
        entries[f"centre_{letter}v_px"] = Entry(chamber.centre_v_px, chamber.centre_sd_px)
        entries[f"radius_{letter}px"] = Entry(chamber.radius_px, chamber.radius_sd_px)
    first = chambers[0]
    if isfinite(first.exit_width_m):
        entries["exit_deg"] = Entry(degrees(first.exit_rad), degrees(first.exit_sd_rad))
        if "exit_width_m" not in told:
            entries["exit_width_m"] = Entry(first.exit_width_m, first.exit_width_sd_m)
    if len(chambers) > 1 and "passage_m" not in told:
        sd_px = hypot(*(sd for c in chambers for sd in (c.centre_sd_px, c.radius_sd_px)))
        length_m = found.geometry.passage_length_m
        entries["passage_m"] = Entry(length_m, sd_px / first.px_per_m)
    return entries


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and isnan(value)


def rig_text(
    source: str,
    found: PicturesCalibration,
    entries: Mapping[str, Entry],
    others: Mapping[str, Mapping[str, Any]],
) -> str:
    """Return the rig file: the tracker's parameters, and of other nodes what was told before.

    Parameters
    ----------
    source : str
        What the pictures come from, for people.
    """
    lines = [
        f"# The rig in {found.showing} of {found.looked_at} pictures of {json.dumps(source)}, by "
        "worm calibrate.",
        "# ± is one standard deviation; what has none was told, not measured.",
        "/**/tracker:",
        "  ros__parameters:",
    ]
    for name, entry in entries.items():
        lines.append(f"    {name}: {_written(entry)}")
    text = "\n".join(lines) + "\n"
    for node, parameters in others.items():
        section = {f"/**/{node}": {"ros__parameters": dict(parameters)}}
        text += yaml.safe_dump(section, allow_unicode=True, sort_keys=False)
    return text


def _written(entry: Entry) -> str:
    """Return a value as YAML, to a hundredth of what it is uncertain by, and that beside it."""
    if not isfinite(entry.sd):
        tidy = float(f"{entry.value:.12g}") if isinstance(entry.value, float) else entry.value
        return json.dumps(tidy, ensure_ascii=False)
    digits = 2 - floor(log10(entry.sd))
    return f"{round(entry.value, digits)}  # ± {entry.sd:.2g}"


def found_in_words(found: PicturesCalibration) -> list[str]:
    """Return lines for people: what was found, how sure it is, how well it fits."""
    contrast = "darker" if found.polarity == "dark" else "brighter"
    lines = [
        f"{found.showing} of {found.looked_at} pictures agree: worm and walls are {contrast} than "
        f"the water (polarity {found.polarity})"
    ]
    for chamber in found.geometry.chambers:
        lines += _chamber_in_words(chamber)
    first = found.geometry.chambers[0]
    scale, relative_sd = first.px_per_m / MM_PER_M, first.radius_sd_px / first.radius_px
    lines.append(
        f"scale: {scale:.4f} ± {scale * relative_sd:.4f} px/mm, if R is "
        f"{first.radius_m * MM_PER_M:g} mm"
    )
    if len(found.geometry.chambers) > 1:
        length_mm = found.geometry.passage_length_m * MM_PER_M
        lines.append(f"passage: L = {length_mm:.3f} mm from wall to wall")
    return lines


def _chamber_in_words(chamber: Chamber) -> list[str]:
    name = chamber.name.replace("_", " ")
    at = f"{chamber.centre_u_px:.3f}, {chamber.centre_v_px:.3f} ± {chamber.centre_sd_px:.3f} px"
    radius = f"{chamber.radius_px:.3f} ± {chamber.radius_sd_px:.3f} px"
    off = f"the wall is {chamber.residual_px:.3f} px off it (rms)"
    lines = [f"{name}: centre {at}, radius {radius}; {off}"]
    if not isfinite(chamber.exit_width_m):
        return [*lines, f"{name}: no exit is seen"]
    width_mm = chamber.exit_width_m * MM_PER_M
    sd_mm = chamber.exit_width_sd_m * MM_PER_M
    wide = f"W = {width_mm:.4f} ± {sd_mm:.4f} mm" if isfinite(sd_mm) else f"W = {width_mm:g} mm"
    turn = f"{degrees(chamber.exit_rad):.3f} ± {degrees(chamber.exit_sd_rad):.3f} degrees"
    return [*lines, f"{name}: exit at {turn} (counter-clockwise from the right), {wide}"]


def rig_picture(picture: Picture, found: PicturesCalibration) -> NDArray[np.uint8]:
    """Return a picture with walls, exits and a scale bar over it, in colour (h, w, 3)."""
    h, w = picture.shape
    px_per_mm = found.geometry.chambers[0].px_per_m / MM_PER_M
    fitting = [mm for mm in _SCALE_BARS_MM if mm * px_per_mm < 0.3 * w]
    bar_mm = max(fitting, default=_SCALE_BARS_MM[0])
    u, v = _FROM_EDGE * w, (1.0 - _FROM_EDGE) * h
    bar = Polyline(np.array([[u, v], [u + bar_mm * px_per_mm, v]]), Ink(CENTROID_COLOUR), 4.0)
    rig = shapes_of_rig(found.geometry)
    drawn = draw_over(picture, Shapes((*rig, bar), f"scale bar: {bar_mm:g} mm"))
    return np.asarray(drawn, np.uint8)


def as_png(picture: NDArray[np.uint8]) -> bytes:
    """Return a colour picture as a PNG file."""
    done, data = cv2.imencode(".png", picture)
    assert done
    return bytes(data)
