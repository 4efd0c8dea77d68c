"""Names in a parameter file that are no mistake although a node has them not: other nodes' own."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

OF_THE_GRAPH: dict[str, tuple[str, ...]] = {
    "image_source": (
        *(
            "bag",
            "topic",
            "rate",
            "loop",
            "start_offset",
            "playback_duration",
            "start_paused",
            "seek_to",
        ),
        *("salvage", "max_chunk_mib", "max_megapixels", "window"),
        *("camera", "record", "pictures", "reconnect", "reconnect_delay", "stall", "seed"),
        *("record_as", "jpeg_quality", "split_mib", "split_min"),
        *("width_px", "height_px", "frames_per_s", "exposure_ms"),
        *("region_u_px", "region_v_px", "region_width_px", "region_height_px"),
    ),
    "tracker": (
        *("polarity", "no_chamber", "radius_m", "centre_u_px", "centre_v_px", "radius_px"),
        *("centre_b_u_px", "centre_b_v_px", "radius_b_px", "exit_deg", "exit_width_m", "depth_m"),
        *("passage_m", "px_per_mm", "hold_back_frames", "calibration_frames", "max_megapixels"),
        *("live", "corrections"),
    ),
    "analysis": (
        *("contact_factor", "release_factor", "body_width_m", "min_episode_s"),
        *("theta_dot_window_s", "mean_window_s", "min_head_certainty", "incidence_window_s"),
        *("max_gap_s", "max_bridged_s", "max_lag_s", "fine_lag_s", "fine_step_s", "coarse_step_s"),
        *("stroke_window_s", "minimum_n", "summary_interval_s"),
    ),
    "model": (
        *("rule", "speed", "hop_may_land", "effective_width", "longest_lag_s", "lag_step_s"),
        "forecast_interval_s",
    ),
    "monitor": ("host", "port", "token", "replay", "player", "trial"),
    "recorder": (
        *(
            "out",
            "expect",
            "provenance",
            "pictures",
            "corrections",
            "trial",
            "animal",
            "date",
            "temperature_c",
            "operator",
        ),
        "notes",
    ),
    "overlay": ("jpeg_quality",),
    "foxglove": ("host", "port", "jpeg_quality"),
}
"""Names of the parameters by the node's name; of each node alone, the node itself knows more."""

_for_others: frozenset[str] = frozenset()  # of the files_of_a_rig that are in force


@contextmanager
def files_of_a_rig(args: Sequence[str]) -> Iterator[None]:
    """Let a node pass over names that the files of its command line have for other nodes.

    A file may speak to several nodes at once (``/**``), and two sources share a name: such a name
    is not misspelt where another node has it.
    """
    global _for_others
    before = _for_others
    files = [word for flag, word in pairwise(args) if flag == "--params-file"]
    _for_others = frozenset(name for file in files for name in _names_for_several(Path(file)))
    try:
        yield
    finally:
        _for_others = before


def for_others() -> frozenset[str]:
    """Return the names that a node passes over."""
    return _for_others


def nodes_of_section(section: str) -> tuple[str, ...]:
    """Return the names of the graph's nodes that a section of a parameter file may speak to."""
    last = section.rpartition("/")[2]
    if last in ("*", "**"):
        return tuple(OF_THE_GRAPH)
    return (last,) if last in OF_THE_GRAPH else ()


def _names_for_several(file: Path) -> Iterator[str]:
    """Yield a file's names; rcl has read it already, so nothing is said of its form."""
    content: Any = yaml.load(file.read_text(encoding="utf-8"), yaml.BaseLoader)
    for section, entry in content.items():
        given = entry.get("ros__parameters", {}) if isinstance(entry, dict) else {}
        for node in nodes_of_section(section):
            yield from (name for name in given if name in OF_THE_GRAPH[node])
