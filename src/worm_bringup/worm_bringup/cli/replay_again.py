"""The command that replays a trial again, as its results tell how they were made."""

import math
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.cli.options import TRACKER_NUMBERS
from worm_bringup.cli.usage_errors import option_name
from worm_model.inference.comparison import ModelParameters
from worm_msgs_py.units import MM_PER_M
from worm_tracker.parameters import MOST_HOLD_BACK_FRAMES, TrackerParameters

_BAG, _RIG_FILE = "BAG", "RIG_FILE"
_CIRCLES = {
    "--circle-px": ("centre_u_px", "centre_v_px", "radius_px"),
    "--circle-b-px": ("centre_b_u_px", "centre_b_v_px", "radius_b_px"),
}
_IN_FILES_ONLY = ("calibration_frames",)
_DEFAULTS_OF_NODES = {
    "tracker": asdict(TrackerParameters()) | {"hold_back_frames": MOST_HOLD_BACK_FRAMES},
    "analysis": asdict(AnalysisParameters()),
    "model": asdict(ModelParameters()),
}


@dataclass(frozen=True, slots=True)
class ReplayCommand:
    """A command, and what the words in it stand for that a person must put in.

    Attributes
    ----------
    line : str
        For a shell.
    stands_for : str
        Sentences; empty where the line can be used as it is.
    """

    line: str
    stands_for: str


def replay_command(results: Path, provenance: Mapping[str, Any], bag: Path | None) -> ReplayCommand:
    """Return the command that applies the corrections of a trial.

    Parameters
    ----------
    results : Path
        The results directory, which holds the corrections.
    provenance : mapping
        As read from its summary.
    bag : Path or None
        What holds the pictures; None: it is not known.
    """
    source = provenance["source"]
    words = ["worm", "replay", _BAG if bag is None else str(bag)]
    stands = [f"{_BAG} stands for the bag that was replayed, or recorded."] * (bag is None)
    if source.get("bag") and source.get("topic"):
        words += ["--topic", str(source["topic"])]
    for key, option in (
        ("start_offset_s", "--start-offset"),
        ("playback_duration_s", "--playback-duration"),
    ):
        if source.get(key) is not None and float(source[key]):
            words += [option, f"{float(source[key]):.12g}"]
    if "salvaged" in source:
        words.append("--salvage")
    words += _changed_options(provenance["parameters"])
    of_rig_file = list(_of_rig_file(provenance))
    if of_rig_file:
        words += ["--rig", _RIG_FILE]
        what = "; ".join(of_rig_file)
        stands.append(f"{_RIG_FILE} stands for a parameter file with what no option gives: {what}.")
    corrected = results if results.name.endswith("-corrected") else _corrected_place(results)
    words += ["--corrections", str(results), "--out", str(corrected)]
    return ReplayCommand(shlex.join(words), " ".join(stands))


def _corrected_place(results: Path) -> Path:
    place = results if results.name else results.absolute()
    return place.with_name(f"{place.name}-corrected")


def _changed_options(parameters: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    tracker = _changed("tracker", parameters)
    if "polarity" in tracker:
        yield from ("--polarity", str(tracker["polarity"]))
    if tracker.get("no_chamber"):
        yield "--no-chamber"
    for option, names in _CIRCLES.items():
        if names[0] in tracker:
            yield from (option, *(repr(float(tracker[name])) for name in names))
    for option, (name, unit) in TRACKER_NUMBERS.items():
        if name in tracker:
            yield from (option_name(option), _times(unit, float(tracker[name])))
    if "hold_back_frames" in tracker:
        yield from ("--hold-back-frames", str(tracker["hold_back_frames"]))
    if "max_megapixels" in tracker:
        yield from ("--max-megapixels", repr(float(tracker["max_megapixels"])))
    for name, value in _changed("analysis", parameters).items():
        if name == "body_width_m":
            yield from ("--body-width-mm", _times(1 / MM_PER_M, float(value)))
        else:
            yield from (option_name(name), repr(value))


def _changed(node: str, parameters: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the parameters of a node that differ from their defaults; null is not given."""
    default = _DEFAULTS_OF_NODES[node]
    return {
        name: value
        for name, value in parameters.get(node, {}).items()
        if value is not None and name in default and value != default[name]
    }


def _of_rig_file(provenance: Mapping[str, Any]) -> Iterator[str]:
    """Yield what was given that no option gives."""
    parameters = provenance["parameters"]
    for node in ("tracker", "model"):
        for name, value in _changed(node, parameters).items():
            if node == "model" or name in _IN_FILES_ONLY:
                yield f"{node}, {name}: {value}"
    if provenance.get("trial"):
        yield f"recorder, {', '.join(provenance['trial'])} as in summary.json"


def _times(unit: float, value: float) -> str:
    """Return the number that times the unit is the value, to the last bit where there is one."""
    near = value / unit
    tried = (near, math.nextafter(near, math.inf), math.nextafter(near, -math.inf))
    texts = (f"{near:.12g}", *(repr(number) for number in tried))
    return next((text for text in texts if float(text) * unit == value), repr(near))
