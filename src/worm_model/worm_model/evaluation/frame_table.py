"""What the evaluation needs of a table, tracks or truth alike, as arrays over the frames."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats
from worm_msgs_py.errors import EvaluationError


@dataclass(frozen=True, slots=True)
class EvaluationSettings:
    """How much two tables must have in common, and what a figure needs.

    Attributes
    ----------
    least_in_common : float
        Part of the frames of the shorter table that the other must have, too.
    fewest_frames : int
        A 95th percentile, a share of frames, or a worm's shift needs as many.
    fewest_episodes : int
        True contacts that the figures of contacts need.
    head_judged_from_s : float
        Which end is the head is judged from then on.
    longest_gap_s : float
        As in the analysis, frames that do not tell the contact split no episode if they are few.
    """

    least_in_common: float = 0.9
    fewest_frames: int = 20
    fewest_episodes: int = 5
    head_judged_from_s: float = 5.0
    longest_gap_s: float = 0.5


EVALUATION = EvaluationSettings()


@dataclass(frozen=True, slots=True)
class ChamberCircle:
    """A chamber's wall in the picture, and its exit's direction (NaN where there is none)."""

    centre_u_px: float
    centre_v_px: float
    radius_px: float
    exit_deg: float


@dataclass(frozen=True, eq=False, slots=True)
class FrameTable:
    """A trial, frame by frame. None stands for a column that the table does not have.

    Attributes
    ----------
    name : str
        What an error calls it, such as its file.
    head_px, centroid_px, tail_px : ndarray, shape (n, 2)
        Picture coordinates (u, v); NaN where they are not known.
    stamp_ns, frame : ndarray of int, shape (n,), or None
        At least one of them.
    midline_px : list of ndarray, shape (k, 2), or None
        Head first; empty where there is none.
    tracked : ndarray of bool, shape (n,)
        Whether the frame has a head and a status that gives a pose, also a bridged one.
    head_certainty, r_h_mm : ndarray, shape (n,), or None
    contact : ndarray, shape (n,), or None
        1 in contact, 0 not, NaN unknown.
    where : ndarray of str, shape (n,), or None
    circles : dict
        By the chamber's name, as they are at the end of the trial.
    """

    name: str
    head_px: Floats
    centroid_px: Floats
    tail_px: Floats
    tracked: NDArray[np.bool_]
    stamp_ns: NDArray[np.int64] | None = None
    frame: NDArray[np.int64] | None = None
    midline_px: list[Floats] | None = None
    head_certainty: Floats | None = None
    r_h_mm: Floats | None = None
    contact: Floats | None = None
    where: NDArray[np.str_] | None = None
    circles: dict[str, ChamberCircle] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.head_px)


def common_rows(
    tracks: FrameTable, truth: FrameTable, settings: EvaluationSettings = EVALUATION
) -> tuple[str, NDArray[np.intp], NDArray[np.intp]]:
    """Find the frames that both tables have.

    Returns
    -------
    key : str
        ``stamp_ns``, or ``frame`` where no stamps agree.
    tracks_rows, truth_rows : ndarray of int
        Rows of the same frames, in the order of the key.

    Raises
    ------
    EvaluationError
        Where they have no frame in common, or a key occurs twice.
    """
    for key in ("stamp_ns", "frame"):
        one, other = getattr(tracks, key), getattr(truth, key)
        if one is None or other is None:
            continue
        for record, values in ((tracks, one), (truth, other)):
            if len(np.unique(values)) < len(values):
                raise EvaluationError(f"{record.name}: two rows have the same {key}")
        _, left, right = np.intersect1d(one, other, assume_unique=True, return_indices=True)
        shorter = min(len(one), len(other))
        if 0 < len(left) < settings.least_in_common * shorter:
            raise EvaluationError(
                f"{tracks.name} and {truth.name} have {len(left)} of {shorter} frames in common by "
                f"{key}: they are not of the same trial: name its own truth"
            )
        if len(left):
            _refuse_other_times(tracks, truth, left, right)
            _refuse_another_worm(tracks, truth, left, right, settings.fewest_frames)
            return key, left, right
    raise EvaluationError(
        f"{tracks.name} and {truth.name} have no frame in common, by stamp_ns or by frame: are they"
        " of the same trial?"
    )


def _refuse_other_times(
    tracks: FrameTable, truth: FrameTable, left: NDArray[np.intp], right: NDArray[np.intp]
) -> None:
    """Refuse frames of the same number that are not as far apart: stamps may begin anywhere."""
    if tracks.stamp_ns is None or truth.stamp_ns is None or len(left) < 2:
        return
    one, other = tracks.stamp_ns[left], truth.stamp_ns[right]
    if np.ptp(one - other) > np.median(np.abs(np.diff(other))) / 2:
        raise EvaluationError(
            f"{tracks.name} and {truth.name} have the same frame numbers at other times: they are "
            "not of the same trial: name its own truth"
        )


def _refuse_another_worm(
    tracks: FrameTable,
    truth: FrameTable,
    left: NDArray[np.intp],
    right: NDArray[np.intp],
    fewest: int,
) -> None:
    """Refuse tracks whose centroid is mostly far from the truth's, whichever end is the head."""
    off = np.hypot(*(tracks.centroid_px[left] - truth.centroid_px[right]).T)
    body = np.hypot(*(truth.head_px[right] - truth.centroid_px[right]).T)
    known = np.isfinite(off) & np.isfinite(body)
    if np.count_nonzero(known) < fewest:
        return
    off_px, body_px = float(np.median(off[known])), float(np.median(body[known]))
    if off_px > body_px:
        raise EvaluationError(
            f"{tracks.name}: the centroid is {off_px:.0f} px from that of {truth.name} in the "
            f"median, more than half a body: they are not of the same trial: name its own truth"
        )
