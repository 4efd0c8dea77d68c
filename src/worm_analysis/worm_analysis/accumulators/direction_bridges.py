"""Gaps in the track, such as folds, with a known direction along the wall on both sides."""

from dataclasses import dataclass

import numpy as np

from worm_analysis.accumulators.frame_rows import Frames
from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, slots=True)
class DirectionBridge:
    """A gap in the direction of motion that is known before and after it.

    Attributes
    ----------
    row : int
        The first frame with a direction after it, by its place among the frames handed on.
    start_ns, end_ns : int
        The last stamp with a direction before it, and that of `row`.
    before, after : float
        sgn θ̇_h on either side, ±1.
    """

    row: int
    start_ns: int
    end_ns: int
    before: float
    after: float


class DirectionBridges:
    """Finds the gaps over which the direction can be followed.

    The worm turns round by folding on itself, and a folded worm may have no head for seconds: time
    is not lost at random. A gap is bridged where the head was in one chamber, and not in its exit,
    on both sides, and where it is short beside the time in which the direction turns: two
    reversals within one gap would not be seen.

    Parameters
    ----------
    longest_ns : int
        From the last frame with a direction to the next one.
    """

    def __init__(self, longest_ns: int):
        self._longest_ns = longest_ns
        self._last = (0, -1, -1, 0.0)

    def push(self, frames: Frames) -> list[DirectionBridge]:
        """Take frames in their order; return the gaps that end in them."""
        at = np.flatnonzero(np.isfinite(frames.theta_dot_rad_s))
        if not len(at):
            return []
        last_ns, last_stretch, last_search, last_sign = self._last
        stamps = np.concatenate([[last_ns], frames.stamp_ns[at]])
        stretch = np.concatenate([[last_stretch], frames.stretch[at]])
        search = np.concatenate([[last_search], frames.search[at]])
        sign: Floats = np.concatenate([[last_sign], np.sign(frames.theta_dot_rad_s[at])])
        self._last = (int(stamps[-1]), int(stretch[-1]), int(search[-1]), float(sign[-1]))
        found = (stretch[1:] != stretch[:-1]) & (search[1:] == search[:-1])
        found &= (np.diff(stamps) <= self._longest_ns) & (sign[1:] * sign[:-1] != 0)
        return [
            DirectionBridge(
                int(at[k]), int(stamps[k]), int(stamps[k + 1]), float(sign[k]), float(sign[k + 1])
            )
            for k in np.flatnonzero(found)
        ]
