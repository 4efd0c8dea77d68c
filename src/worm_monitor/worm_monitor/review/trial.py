"""One trial as the review page shows it: columns by frame, poses, events, the rig."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from worm_analysis.kinematics.observables import body_angle, polar_angle, wrap_angle
from worm_analysis.results import Results, chamber_of, read_results
from worm_analysis.results.parquet_table import damage_reported
from worm_analysis.results.picture import rests_on
from worm_analysis.results.summary import read_summary
from worm_monitor.json_numbers import JsonRow, rounded_all
from worm_monitor.overlay_json import drawn_pose
from worm_msgs_py import Chamber, Status
from worm_msgs_py.arrays import Floats, Floats32, Integers
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.errors import RUN_AGAIN, ReportError

_MARGIN_PX = 12
_MIDLINE = ("midline_u_px", "midline_v_px")


@dataclass(frozen=True, eq=False)
class ReviewedTrial:
    """What is shown of a results directory.

    Attributes
    ----------
    directory : Path
    results : Results
    rigs : tuple of tuple of Chamber
        All versions of the rig, the last one first.
    rig_of : ndarray of int
        Which of them a frame's millimetres rest on; -1: none that is known.
    """

    directory: Path
    results: Results
    rigs: tuple[tuple[Chamber, ...], ...]
    rig_of: Integers
    _midlines: tuple[tuple[Floats32, Integers], ...]

    @property
    def of_table(self) -> bool:
        """Whether the results were made of a table of tracks, without pictures."""
        return "table" in self.results.provenance["source"]

    @property
    def stamps_ns(self) -> Integers:
        """Stamp of each frame."""
        stamps: Integers = self.results.tracks["stamp_ns"]
        return stamps

    @property
    def frames(self) -> Integers:
        """Number of each frame."""
        frames: Integers = self.results.tracks["frame"].astype(np.int64)
        return frames

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height that hold the rig and all that was tracked: no table tells of more."""
        tracks = self.results.tracks
        far = []
        for axis in "uv":
            seen = [tracks[f"{point}_{axis}_px"] for point in KEYPOINTS]
            walls = [
                getattr(chamber, f"centre_{axis}_px") + chamber.radius_px
                for rig in self.rigs
                for chamber in rig
            ]
            every = np.concatenate([*seen, walls])
            every = every[np.isfinite(every)]
            far.append(int(every.max(initial=100.0)) + _MARGIN_PX)
        return far[0], far[1]

    def status(self, row: int) -> Status:
        """Return what came of a frame."""
        return Status.from_label(str(self.results.tracks["status"][row]))

    def pose(self, row: int) -> dict[str, Any]:
        """Return what is drawn over a frame's picture."""
        tracks = self.results.tracks
        told = drawn_pose(
            int(tracks["frame"][row]),
            str(tracks["status"][row]),
            float(tracks["head_certainty"][row]),
            {
                p: (float(tracks[f"{p}_u_px"][row]), float(tracks[f"{p}_v_px"][row]))
                for p in KEYPOINTS
            },
            (float(tracks["width_px"][row]), float(tracks["length_px"][row])),
        )
        return told | {"midline": list(self._midline(row))}

    def _midline(self, row: int) -> Iterator[JsonRow]:
        for values, ends in self._midlines:
            yield rounded_all(values[ends[row] : ends[row + 1]])


def read_reviewed_trial(directory: Path) -> ReviewedTrial:
    """Read a results directory.

    Raises
    ------
    ReportError
        As `read_results`; or there are no frames, or a status that this version does not know.
    """
    results = read_results(directory)
    if not len(results.tracks["frame"]):
        raise ReportError(f"{directory}: its trial has no frames: there is nothing to review")
    try:
        for label in np.unique(results.tracks["status"].astype(str)):
            Status.from_label(label)
    except ValueError as error:
        raise ReportError(f"{directory}: {error}: {RUN_AGAIN}") from None
    summary = read_summary(directory / "summary.json")
    rigs = _rigs(directory, results, summary)
    return ReviewedTrial(
        directory=directory,
        results=results,
        rigs=rigs,
        rig_of=_rig_of(results, rigs),
        _midlines=_read_midlines(directory / "tracks.parquet"),
    )


def plotted_columns(trial: ReviewedTrial) -> dict[str, Floats32]:
    """Return what is plotted, a number a frame; NaN where there is none.

    `*_exchanged` is what the symbol would be with head and tail exchanged. Distances in mm, angles
    in degrees in (-180, 180], t in s since the first frame.
    """
    tracks = trial.results.tracks
    tail = [tracks[f"tail_{axis}_mm"] for axis in "xy"]
    centroid = [tracks[f"centroid_{axis}_mm"] for axis in "xy"]
    in_chamber = np.isfinite(tracks["r_t_mm"])
    found: dict[str, Floats] = {
        "t": trial.results.t_s,
        "frame": tracks["frame"],
        "r": tracks["r_h_mm"],
        "r_exchanged": tracks["r_t_mm"],
        "theta": np.degrees(wrap_angle(tracks["theta_h_rad"])),
        "theta_exchanged": np.where(in_chamber, np.degrees(polar_angle(*tail)), np.nan),
        "psi": tracks["psi_b_deg"],
        "psi_exchanged": np.where(in_chamber, np.degrees(body_angle(*tail, *centroid)), np.nan),
        "certainty": tracks["head_certainty"],
        "contact": tracks["contact"],
    }
    return {name: np.asarray(values, dtype=np.float32) for name, values in found.items()}


def _rigs(
    directory: Path, results: Results, summary: Mapping[str, Any]
) -> tuple[tuple[Chamber, ...], ...]:
    try:
        earlier = [
            tuple(chamber_of(name, entry) for name, entry in old.items() if isinstance(entry, dict))
            for old in reversed(summary.get("earlier_geometries") or [])
        ]
    except (KeyError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        why = f"earlier_geometries are not of this version ({error!r})"
        raise ReportError(f"{directory / 'summary.json'}: {why}: {RUN_AGAIN}") from error
    return (results.chambers, *earlier)


def _rig_of(results: Results, rigs: tuple[tuple[Chamber, ...], ...]) -> Integers:
    """Return which rig each frame rests on; a frame without a pose has that of the one before."""
    tracks = results.tracks
    found = np.full(len(tracks["frame"]), -1, dtype=np.int64)
    for number, rig in enumerate(rigs):
        for chamber in rig:
            found[(found < 0) & rests_on(chamber, tracks)] = number
    known = np.flatnonzero(found >= 0)
    if not len(known):
        return np.zeros_like(found) if len(rigs) == 1 and rigs[0] else found
    last = np.searchsorted(known, np.arange(len(found)), side="right") - 1
    return np.asarray(found[known[np.maximum(last, 0)]])


def _read_midlines(path: Path) -> tuple[tuple[Floats32, Integers], ...]:
    """Return u and v of all midlines, and where each frame's begin and end."""
    with damage_reported(path):
        table = pq.read_table(path, columns=list(_MIDLINE)).combine_chunks()
        found = []
        for name in _MIDLINE:
            column = table.column(name).combine_chunks()
            lists = column.chunk(0) if hasattr(column, "chunk") else column
            values = lists.values.to_numpy(zero_copy_only=False)
            found.append((values, lists.offsets.to_numpy().astype(np.int64)))
        return tuple(found)
