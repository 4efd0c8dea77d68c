"""v_w of the law ⟨v_b⟩ = v_w sin⟨ψ_b⟩, from means over short windows of the trial."""

import numpy as np

from worm_analysis.accumulators.frame_rows import Frames
from worm_analysis.accumulators.settings import SEARCH, SearchSettings
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_analysis.statistics.thinned_points import ThinnedPoints
from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.units import NS_PER_S


class SpeedLaw:
    """Sums over windows of time of the mean of v_b and the sine of the mean of ψ_b.

    The paper fits the line to the means of whole trials (Fig. 4c). Within one trial the body turns
    round, so means are taken over windows of one undulatory stroke, short beside t_per; frame by
    frame, the stroke's sway of ψ_b, which does not change the speed, would flatten the line. Where
    the body turns round within a window, ψ_b is averaged on either side of the normal apart, and
    the sines of the two means by their times: the sine of a mean across the turn would be too
    large. Windows follow each other from the start of each unbroken stretch.

    Parameters
    ----------
    radius_m : float
        R.
    window_s : float
        Length of a window.
    settings : SearchSettings
    """

    def __init__(self, radius_m: float, window_s: float, settings: SearchSettings = SEARCH):
        self._radius_m = radius_m
        self._window_ns = round(window_s * NS_PER_S)
        self._least_ns = settings.least_window_seen * self._window_ns
        self._blocks = BlockSums(3)
        self._stretch = -1
        self._stretch_ns = 0
        self._window = -1
        self._first_ns = self._last_ns = 0
        self._sums = np.zeros(5)
        self._points = ThinnedPoints()

    def add(self, frames: Frames) -> None:
        """Take frames with the head in a chamber; those without a speed or a body angle go by."""
        known = np.isfinite(frames.theta_dot_rad_s) & np.isfinite(frames.psi_b_rad)
        if not known.any():
            return
        stamps_ns, stretch = frames.stamp_ns[known], frames.stretch[known]
        v, psi_b = self._radius_m * frames.theta_dot_rad_s[known], frames.psi_b_rad[known]
        left = psi_b > 0
        rows = np.stack([v, left, psi_b * left, ~left, psi_b * ~left])
        for piece in np.split(np.arange(len(stretch)), np.flatnonzero(np.diff(stretch)) + 1):
            if int(stretch[piece[0]]) != self._stretch:
                self.close()
                self._stretch, self._stretch_ns = int(stretch[piece[0]]), int(stamps_ns[piece[0]])
            window = (stamps_ns[piece] - self._stretch_ns) // self._window_ns
            for part in np.split(piece, np.flatnonzero(np.diff(window)) + 1):
                self._add_part(stamps_ns[part], rows[:, part])

    def _add_part(self, stamps_ns: Integers, rows: Floats) -> None:
        """Take frames that lie in one window."""
        window = (int(stamps_ns[0]) - self._stretch_ns) // self._window_ns
        if window != self._window:
            self.close()
            self._window, self._first_ns = window, int(stamps_ns[0])
        # One after the other, as if frames came one by one.
        self._sums = np.cumsum(np.column_stack([self._sums, rows]), axis=1)[:, -1]
        self._last_ns = int(stamps_ns[-1])

    def close(self) -> None:
        """End the window that is open."""
        if self._last_ns - self._first_ns >= self._least_ns:
            v, n_left, left, n_right, right = self._sums
            s = n_left * np.sin(left / max(n_left, 1.0))
            s += n_right * np.sin(right / max(n_right, 1.0))
            v, s = v / (n_left + n_right), s / (n_left + n_right)
            self._blocks.row(self._first_ns)[:] += (1.0, v * s, s * s)
            self._points.push(s, v)
        self._window = -1
        self._first_ns = self._last_ns = 0
        self._sums = np.zeros(5)

    def sums(self) -> dict[str, Floats]:
        """Return the sums of 1, v·s and s² over windows, and (s, v) of some of the windows."""
        return {"v_w": self._blocks.rows(), "window_points": self._points.rows()}
