"""The head's entries into the exit: how far it gets, and whether the body follows."""

from collections import deque
from dataclasses import dataclass
from math import nan, sqrt

import numpy as np

from worm_analysis.events.exit_region import ExitCorridor
from worm_msgs_py import Attempt, StrokePhase
from worm_msgs_py.units import NS_PER_S


@dataclass(slots=True)
class _Entry:
    chamber: str
    start_ns: int
    last_ns: int
    depth_m: float = -np.inf
    touched: bool | None = False
    phase: StrokePhase = StrokePhase.UNKNOWN


class Attempts:
    """Follows the head through the exit (paper, section on Figs 8 and 9).

    An attempt starts when the head is beyond the circle between the passage's walls (where W is not
    known: when the tracker sees it in the passage). It succeeds when the centroid is in the
    corridor of the passage too, or the head in the other chamber, and fails when the head is back
    in the chamber. The centroid of a body that bends round the exit's corner leaves the circle
    beside the passage: that is no success.

    Parameters
    ----------
    stroke_window_s : float
        See `AnalysisParameters`.
    """

    def __init__(self, stroke_window_s: float):
        self._window_ns = round(stroke_window_s * NS_PER_S)
        self._lengths: deque[tuple[int, float]] = deque()
        self._entry: _Entry | None = None

    @property
    def active(self) -> bool:
        """Whether the head is in the exit."""
        return self._entry is not None

    def push(
        self,
        chamber: str,
        corridor: ExitCorridor,
        stamp_ns: int,
        head_m: tuple[float, float],
        centroid_m: tuple[float, float],
        length_m: float,
        threshold_m: float,
        *,
        in_passage: bool,
        through: bool = False,
    ) -> Attempt | None:
        """Take a frame with a head; return the attempt that it decides, if it does.

        Parameters
        ----------
        chamber : str
            The chamber that the body is in.
        corridor : ExitCorridor
            Its exit.
        stamp_ns : int
            Later than that of the last frame.
        head_m, centroid_m : (float, float)
            x, y in that chamber's frame; the centroid may be NaN.
        length_m : float
            Length of the body; may be NaN.
        threshold_m : float
            The distance that counts as contact, 0.3·d_w; NaN where it is not known.
        in_passage : bool
            Whether the tracker sees the head in the passage.
        through : bool
            Whether it sees the head in another chamber.
        """
        self.keep_length(stamp_ns, length_m)
        entry = self._entry
        if entry is None:
            if not (corridor.holds(*head_m) if corridor.is_known else in_passage):
                return None
            entry = self._entry = _Entry(chamber, stamp_ns, stamp_ns)
        entry.last_ns = stamp_ns
        margin_m = threshold_m if threshold_m == threshold_m else 0.0
        if corridor.is_left(*head_m, margin_m) if corridor.is_known else not in_passage:
            return self._close(stamp_ns, success=False, complete=True)
        self._go_deeper(entry, head_m[0] - corridor.mouth_x_m)
        clearance_m = corridor.half_width_m - abs(head_m[1])
        entry.touched = _touches(entry.touched, clearance_m, threshold_m)
        if through or corridor.encloses(*centroid_m, margin_m):
            return self._close(stamp_ns, success=True, complete=True)
        return None

    def cut(self) -> Attempt | None:
        """End an open attempt undecided: a gap, or the end of the track."""
        self._lengths.clear()
        if self._entry is None:
            return None
        return self._close(self._entry.last_ns, success=False, complete=False)

    def _close(self, end_ns: int, *, success: bool, complete: bool) -> Attempt:
        entry = self._entry
        assert entry is not None
        self._entry = None
        return Attempt(
            chamber=entry.chamber,
            start_ns=entry.start_ns,
            end_ns=end_ns,
            penetration_m=max(0.0, entry.depth_m),
            success=success,
            wall_contact=entry.touched,
            stroke_phase=entry.phase,
            complete=complete,
        )

    def keep_length(self, stamp_ns: int, length_m: float) -> None:
        """Take the body's length in a frame, NaN where there is none, for the stroke's phase."""
        if length_m == length_m:
            self._lengths.append((stamp_ns, length_m))
        while self._lengths and self._lengths[0][0] < stamp_ns - self._window_ns:
            self._lengths.popleft()

    def _go_deeper(self, entry: _Entry, depth_m: float) -> None:
        if depth_m > entry.depth_m:
            entry.depth_m = depth_m
            entry.phase = stroke_phase(self._lengths)


def _touches(before: bool | None, clearance_m: float, threshold_m: float) -> bool | None:
    """Contact once is contact; a frame in which it cannot be told leaves no plain "no"."""
    if before or clearance_m < threshold_m:
        return True
    told = clearance_m == clearance_m and threshold_m == threshold_m
    return before if told else None


def stroke_phase(lengths: deque[tuple[int, float]]) -> StrokePhase:
    """Return the phase of the peristaltic stroke from the body's length over part of a stroke.

    Parameters
    ----------
    lengths : deque of (int, float)
        Stamps in ns and lengths in m.

    Returns
    -------
    StrokePhase
        Elongation where a straight line through the lengths rises by more than two of its standard
        errors, contraction where it falls; unknown otherwise and with fewer than five frames.
    """
    n = len(lengths)
    if n < 5:
        return StrokePhase.UNKNOWN
    first = lengths[0][0]
    t = np.array([(stamp_ns - first) / NS_PER_S for stamp_ns, _ in lengths])
    length = np.array([value for _, value in lengths])
    t -= t.mean()
    length -= length.mean()
    spread = float(np.sum(t * t))
    slope = float(np.sum(t * length)) / spread if spread > 0 else nan
    residual = length - slope * t
    error = sqrt(float(np.sum(residual * residual)) / (n - 2) / spread) if spread > 0 else nan
    if slope > 2 * error:
        return StrokePhase.ELONGATION
    if slope < -2 * error:
        return StrokePhase.CONTRACTION
    return StrokePhase.UNKNOWN
