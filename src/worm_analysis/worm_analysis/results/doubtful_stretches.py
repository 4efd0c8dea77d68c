"""Where a person should look at a trial's frames: which end is the head, and where it is."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from worm_analysis.results.parquet_table import Columns
from worm_msgs_py import Status
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.units import NS_PER_S

_Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class DoubtSettings:
    """What is worth a look.

    Attributes
    ----------
    most_apart_s : float
        Doubtful frames of one kind that are no further apart are one stretch; and ends are compared
        over a gap that is no longer: in more time a worm may have turned round.
    exchanged_over_kept : float
        Way of both ends to the other's place, over that to their own, below which they are
        exchanged. From frame to frame an end moves by a small part of the body; in a coil both may
        be about 1.
    """

    most_apart_s: float = 1.0
    exchanged_over_kept: float = 0.5


DOUBT = DoubtSettings()
FOLDS = (Status.FOLDED, Status.LOOP_IN_DOUBT, Status.COILED)
"""Of a body that touches or crosses itself."""


class Doubt(StrEnum):
    """Why a person should look."""

    EXCHANGED = "exchanged"
    """Head and tail change places between two frames: before it or after it they are wrong."""
    UNSURE_HEAD = "unsure_head"
    """Which end is the head is not sure."""
    FOLDED = "folded"
    """The body touches or crosses itself, told or not: an end may be taken for the other."""
    LOST = "lost"
    """Head and tail are not told: no worm, several, a bad picture, an end at the border."""


@dataclass(frozen=True, slots=True)
class DoubtfulStretch:
    """Frames that a person should look at.

    Attributes
    ----------
    why : Doubt
    first_frame, last_frame : int
        Inclusive; of an exchange the frames before and after it.
    first_stamp_ns, last_stamp_ns : int
        When they were taken.
    least_certainty : float
        The least certainty of the head in it, 0.5 to 1; NaN where no head is told.
    """

    why: Doubt
    first_frame: int
    last_frame: int
    first_stamp_ns: int
    last_stamp_ns: int
    least_certainty: float

    @property
    def duration_s(self) -> float:
        """From the first to the last of its frames."""
        return (self.last_stamp_ns - self.first_stamp_ns) / NS_PER_S


def doubtful_stretches(tracks: Columns, settings: DoubtSettings = DOUBT) -> list[DoubtfulStretch]:
    """Return the stretches of a trial's tracks where a person should look, the worst first.

    Exchanges of head and tail come first, because frames on one side of each are wrong; then
    the longest stretch first, whatever it is. A stretch of one kind may lie in one of another.

    Parameters
    ----------
    tracks : mapping of column name to ndarray
        As in `Results.tracks`: `frame`, `stamp_ns`, `status`, `head_certainty` and head and tail in
        pixels.
    settings : DoubtSettings
    """
    status = tracks["status"]
    told = np.isin(status, [each.label for each in Status if each.may_have_head])
    folded = np.isin(status, [each.label for each in FOLDS])
    flagged = {
        Doubt.UNSURE_HEAD: told & (tracks["head_certainty"] < SURE_HEAD_CERTAINTY),
        Doubt.FOLDED: folded,
        Doubt.LOST: ~told & ~folded,
    }
    runs = [
        (why, first, last)
        for why, flags in flagged.items()
        for first, last in _runs(flags, tracks["stamp_ns"], settings)
    ]
    runs += [(Doubt.EXCHANGED, before, after) for before, after in _exchanges(tracks, settings)]
    found = [_stretch(tracks, told, *run) for run in runs]
    return sorted(
        found,
        key=lambda each: (each.why is not Doubt.EXCHANGED, -each.duration_s, each.first_frame),
    )


def _runs(
    flags: _Flags, stamps_ns: NDArray[np.int64], settings: DoubtSettings
) -> Iterator[tuple[int, int]]:
    """Yield the first and last row of each run of flagged rows."""
    rows = np.flatnonzero(flags)
    if not rows.size:
        return
    apart = np.diff(stamps_ns[rows]) > settings.most_apart_s * NS_PER_S
    starts = np.concatenate([[0], 1 + np.flatnonzero(apart)])
    ends = np.concatenate([starts[1:] - 1, [rows.size - 1]])
    for start, end in zip(starts, ends, strict=True):
        yield int(rows[start]), int(rows[end])


def _exchanges(tracks: Columns, settings: DoubtSettings) -> Iterator[tuple[int, int]]:
    """Yield the rows before and after each exchange of head and tail."""
    head, tail = (tracks[f"{end}_u_px"] + 1j * tracks[f"{end}_v_px"] for end in ("head", "tail"))
    rows = np.flatnonzero(np.isfinite(head) & np.isfinite(tail))
    before, after = rows[:-1], rows[1:]
    kept = abs(head[after] - head[before]) + abs(tail[after] - tail[before])
    exchanged = abs(head[after] - tail[before]) + abs(tail[after] - head[before])
    near = np.diff(tracks["stamp_ns"][rows]) <= settings.most_apart_s * NS_PER_S
    for row in np.flatnonzero(near & (exchanged < settings.exchanged_over_kept * kept)):
        yield int(before[row]), int(after[row])


def _stretch(tracks: Columns, told: _Flags, why: Doubt, first: int, last: int) -> DoubtfulStretch:
    certainty = tracks["head_certainty"][first : last + 1][told[first : last + 1]]
    least = float(np.min(certainty, initial=inf))
    return DoubtfulStretch(
        why,
        int(tracks["frame"][first]),
        int(tracks["frame"][last]),
        int(tracks["stamp_ns"][first]),
        int(tracks["stamp_ns"][last]),
        nan if least == inf else least,
    )
