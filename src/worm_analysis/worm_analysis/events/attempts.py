"""The head's entries into the exit: how far it gets, and whether the body follows."""

from collections import deque
from dataclasses import dataclass
from math import dist, inf, nan, sqrt

import numpy as np

from worm_analysis.events.exit_region import EXITS, ExitCorridor, ExitSettings
from worm_msgs_py import Attempt, StrokePhase
from worm_msgs_py.units import NS_PER_S

Point = tuple[float, float]
SeenHead = tuple[int, Point]
"""A stamp in ns, and where the head is then."""


@dataclass(slots=True)
class _Clearance:
    """How near the head comes to the passage's walls, in the frames and between them.

    Attributes
    ----------
    seen_m : float
        The least that is seen of a head in the exit.
    mean_m : float
        The least mean of two frames that follow each other, the one before the first among them.
    speed_m_s, longest_s : float
        How fast the head goes from frame to frame, and how long it is not seen, at most.
    known : bool
        Whether it can be told of every frame.
    """

    seen_m: float = inf
    mean_m: float = inf
    speed_m_s: float = 0.0
    longest_s: float = 0.0
    known: bool = True

    def take(
        self, before: SeenHead | None, head: SeenHead, half_width_m: float, *, inside: bool
    ) -> None:
        """Add a frame and the way to it."""
        clearance_m = half_width_m - abs(head[1][1])
        self.known &= clearance_m == clearance_m and before is not None
        if inside:
            self.seen_m = min(self.seen_m, clearance_m)
        if before is not None:
            spent_s = (head[0] - before[0]) / NS_PER_S
            self.mean_m = min(self.mean_m, (half_width_m - abs(before[1][1]) + clearance_m) / 2)
            self.speed_m_s = max(self.speed_m_s, dist(before[1], head[1]) / spent_s)
            self.longest_s = max(self.longest_s, spent_s)

    def touches(self, threshold_m: float, error_m: float, settings: ExitSettings) -> bool | None:
        """Return whether it is contact; None where it may or may not be one.

        Between two frames, a head that is no faster than from frame to frame comes nearer than the
        mean of both by half of its way at most. Between frames that are far apart a head that sways
        is faster, and its way is taken to be that of a random walk, whose speed falls as the root
        of the time over which it is seen.
        """
        if self.seen_m < threshold_m - error_m:
            return True
        faster = sqrt(max(self.longest_s / settings.seen_well_s, 1.0))
        nearer_m = faster * self.speed_m_s * self.longest_s / 2
        least_m = min(self.seen_m, self.mean_m - nearer_m)
        return False if self.known and least_m > threshold_m + error_m else None


@dataclass(slots=True)
class _Entry:
    chamber: str
    start_ns: int
    last_ns: int
    clearance: _Clearance
    depth_m: float = -np.inf
    phase: StrokePhase = StrokePhase.UNKNOWN


class Attempts:
    """Follows the head through the exit (paper, section on Figs 8 and 9).

    An attempt starts when the head is beyond the circle between the passage's walls (where W is not
    known: when the tracker sees it in the passage). It succeeds when the centroid is in the
    corridor of the passage too, or the head in the other chamber, and fails when the head is back
    in the chamber. The centroid of a body that bends round the exit's corner leaves the circle
    beside the passage: that is no success. It touches the passage's walls where a frame shows it
    within the distance that counts as contact; that it does not is told only where it cannot have
    come so near between two frames either.

    Parameters
    ----------
    stroke_window_s : float
        See `AnalysisParameters`.
    settings : ExitSettings
    """

    def __init__(self, stroke_window_s: float, settings: ExitSettings = EXITS):
        self._settings = settings
        self._window_ns = round(stroke_window_s * NS_PER_S)
        self._lengths: deque[tuple[int, float]] = deque()
        self._head: SeenHead | None = None
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
        head_m: Point,
        centroid_m: Point,
        length_m: float,
        threshold_m: float,
        *,
        error_m: float,
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
        length_m, threshold_m : float
            That of the body, and the distance that counts as contact, 0.3·d_w; NaN if not known.
        error_m : float
            How far the head may be from where it is seen.
        in_passage, through : bool
            Whether the tracker sees the head in the passage, and in another chamber.
        """
        before = self._head
        self.watch(stamp_ns, head_m, length_m)
        entry = self._entry
        if entry is None:
            if not (corridor.holds(*head_m) if corridor.is_known else in_passage):
                return None
            entry = self._entry = _Entry(chamber, stamp_ns, stamp_ns, _Clearance())
        entry.last_ns = stamp_ns
        margin_m = threshold_m if threshold_m == threshold_m else 0.0
        left = corridor.is_left(*head_m, margin_m) if corridor.is_known else not in_passage
        entry.clearance.take(before, (stamp_ns, head_m), corridor.half_width_m, inside=not left)
        if not left:
            self._go_deeper(entry, head_m[0] - corridor.mouth_x_m)
            if not (through or corridor.encloses(*centroid_m)):
                return None
        touched = entry.clearance.touches(threshold_m, error_m, self._settings)
        return self._close(stamp_ns, touched, success=not left, complete=True)

    def cut(self) -> Attempt | None:
        """End an open attempt undecided: a gap, or the end of the track."""
        self._lengths.clear()
        self._head = None
        if self._entry is None:
            return None
        return self._close(self._entry.last_ns, None, success=False, complete=False)

    def _close(
        self, end_ns: int, touched: bool | None, *, success: bool, complete: bool
    ) -> Attempt:
        entry = self._entry
        assert entry is not None
        self._entry = None
        if success:
            self._head = None  # the next one is at another exit
        return Attempt(
            chamber=entry.chamber,
            start_ns=entry.start_ns,
            end_ns=end_ns,
            penetration_m=max(0.0, entry.depth_m),
            success=success,
            wall_contact=touched,
            stroke_phase=entry.phase,
            complete=complete,
        )

    def watch(self, stamp_ns: int, head_m: Point, length_m: float) -> None:
        """Take a frame of a head in the chamber, for the way to the next one and the stroke.

        The length is NaN where there is none.
        """
        self._head = stamp_ns, head_m
        if length_m == length_m:
            self._lengths.append((stamp_ns, length_m))
        while self._lengths and self._lengths[0][0] < stamp_ns - self._window_ns:
            self._lengths.popleft()

    def _go_deeper(self, entry: _Entry, depth_m: float) -> None:
        if depth_m > entry.depth_m:
            entry.depth_m = depth_m
            entry.phase = stroke_phase(self._lengths, self._settings)


def stroke_phase(lengths: deque[tuple[int, float]], settings: ExitSettings = EXITS) -> StrokePhase:
    """Return the phase of the peristaltic stroke from the body's length over part of a stroke.

    Parameters
    ----------
    lengths : deque of (int, float)
        Stamps in ns and lengths in m.
    settings : ExitSettings

    Returns
    -------
    StrokePhase
        Elongation where a straight line through the lengths rises by more than two of its standard
        errors, contraction where it falls; unknown otherwise and with fewer than five frames.
    """
    n = len(lengths)
    if n < settings.fewest_lengths:
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
    if slope > settings.length_slope_errors * error:
        return StrokePhase.ELONGATION
    if slope < -settings.length_slope_errors * error:
        return StrokePhase.CONTRACTION
    return StrokePhase.UNKNOWN
