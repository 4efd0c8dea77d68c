"""The picture of a trial that its report opens with: which frame it is, and what is in it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from worm_analysis.results.results import Results
from worm_msgs_py import Chamber, Status
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.errors import ReportError
from worm_msgs_py.files.frame_pictures import frame_pictures
from worm_msgs_py.units import MM_PER_M

SAME_LENGTH = 0.1
"""A body whose length is this near to the median is seen whole."""
SAME_PLACE_PX = 1.0
"""A circle that leads from a head's millimetres so near to its pixels is the frame's own."""
_MIDLINE = ("midline_u_px", "midline_v_px")


@dataclass(frozen=True, eq=False, slots=True)
class TrialPicture:
    """One frame as the tracker saw it, and where the body was found in it.

    Attributes
    ----------
    row : int
        Its row in the tracks.
    grey : ndarray, shape (h, w)
        From 0, black, to 1.
    midline_u_px, midline_v_px : ndarray
        Head first.
    """

    row: int
    grey: NDArray[Any]
    midline_u_px: Floats
    midline_v_px: Floats


def row_to_show(results: Results, among: Collection[int] | None = None) -> int | None:
    """Choose the frame to show; None where none has a pose.

    Of the frames with a whole body and a certain head those in contact, if there are any: the one
    that the tracker trusts most, and the first of several.

    Parameters
    ----------
    results : Results
        The trial.
    among : collection of int, optional
        The frames whose pictures can be had; None: all.
    """
    tracks = results.tracks
    chosen = (tracks["status"] == Status.TRACKED.label) & np.isfinite(tracks["head_u_px"])
    if among is not None:
        chosen &= np.isin(tracks["frame"], list(among))
    length = tracks["length_px"]
    if not chosen.any():
        return None
    whole = np.abs(length / np.nanmedian(length[chosen]) - 1) < SAME_LENGTH
    placed = _on_the_last_circle(results) if results.chambers else np.ones_like(chosen)
    sure = tracks["head_certainty"] >= SURE_HEAD_CERTAINTY
    for wish in (placed, sure, whole, tracks["contact"] == 1.0):
        if (chosen & wish).any():
            chosen = chosen & wish
    trust = np.where(chosen, np.nan_to_num(tracks["confidence"]), -1.0)
    return int(np.argmax(trust))


def _on_the_last_circle(results: Results) -> NDArray[np.bool_]:
    """Whether a frame's millimetres are those of the circle that the results tell."""
    tracks = results.tracks
    found = np.zeros(len(tracks["stamp_ns"]), dtype=np.bool_)
    for chamber in results.chambers:
        found |= (tracks["where"] == chamber.name) & rests_on(chamber, tracks)
    return found


def rests_on(chamber: Chamber, tracks: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """Whether a frame's millimetres are those of this circle: they lead to the head's pixels."""
    u, v = chamber.to_pixels(tracks["head_x_mm"] / MM_PER_M, tracks["head_y_mm"] / MM_PER_M)
    off_px: Floats = np.hypot(u - tracks["head_u_px"], v - tracks["head_v_px"])
    return off_px < SAME_PLACE_PX


def read_kept_picture(results_dir: Path, results: Results) -> TrialPicture | None:
    """Return the picture that is kept beside a trial's tracks; None where there is none.

    Raises
    ------
    ReportError
        It is damaged, or of a frame that the tracks do not have.
    """
    found = frame_pictures(results_dir)
    if not found:
        return None
    from matplotlib.image import imread  # slow to import, and most results have no picture

    frame, path = next(iter(found.items()))
    try:
        (row,) = np.flatnonzero(results.tracks["frame"] == frame)
        grey = imread(path)
    except (OSError, ValueError, SyntaxError) as error:  # SyntaxError: what it calls a broken PNG
        raise ReportError(f"{path}: is no picture of this trial ({error}): remove it") from None
    lines = pq.read_table(
        results_dir / "tracks.parquet", columns=list(_MIDLINE), filters=[("frame", "=", frame)]
    )
    u, v = (np.asarray(lines.column(name)[0].as_py() or [], dtype=np.float64) for name in _MIDLINE)
    return TrialPicture(int(row), grey if grey.ndim == 2 else grey[..., 0], u, v)
