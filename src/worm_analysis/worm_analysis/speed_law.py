"""v_w of the law ⟨v_b⟩ = v_w sin⟨ψ_b⟩, from means over short windows of the trial."""

from math import nan

import numpy as np
from numpy.typing import NDArray

from worm_analysis.angular_motion import NS
from worm_analysis.blocks import BlockSums, jackknife_half_width
from worm_analysis.frame_rows import Frames
from worm_analysis.observables import wrap_angle

Floats = NDArray[np.float64]

FULL = 0.5
"""A window of which less than this part was seen is left out."""


class SpeedLaw:
    """Sums over windows of time of the mean of v_b and the sine of the mean of ψ_b.

    The paper fits the line to the means of whole trials (Fig. 4c). Within one trial the body turns
    round, so means are taken over windows of one undulatory stroke, short beside t_per; frame by
    frame, the stroke's sway of ψ_b, which does not change the speed, would flatten the line. A
    window ends at every gap and with every visit.

    Parameters
    ----------
    radius_m : float
        R.
    window_s : float
        Length of a window.

    Attributes
    ----------
    windows : int
        Windows so far.
    """

    def __init__(self, radius_m: float, window_s: float):
        self._radius_m = radius_m
        self._window_ns = round(window_s * NS)
        self._blocks = BlockSums(2)
        self._start_ns: int | None = None
        self._key = (-1, -1)
        self._first_ns = self._last_ns = 0
        self._reference_rad = 0.0
        self._sums = np.zeros(3)
        self.windows = 0

    def add(self, frames: Frames) -> None:
        """Take frames with the head in a chamber; those without a speed or a body angle go by."""
        known = np.isfinite(frames.theta_dot_rad_s) & np.isfinite(frames.psi_b_rad)
        if not known.any():
            return
        stamps_ns, stretch = frames.stamp_ns[known], frames.stretch[known]
        speed, psi_b = frames.theta_dot_rad_s[known], frames.psi_b_rad[known]
        if self._start_ns is None:
            self._start_ns = int(stamps_ns[0])
        window = (stamps_ns - self._start_ns) // self._window_ns
        change = (np.diff(window) != 0) | (np.diff(stretch) != 0)
        for part in np.split(np.arange(len(window)), np.flatnonzero(change) + 1):
            key = (int(stretch[part[0]]), int(window[part[0]]))
            if key != self._key:
                self.close()
                self._key, self._first_ns = key, int(stamps_ns[part[0]])
                self._reference_rad = float(psi_b[part[0]])
            away = wrap_angle(psi_b[part] - self._reference_rad)
            rows = np.stack([np.ones(len(part)), self._radius_m * speed[part], away])
            # One after the other, as if frames came one by one.
            self._sums = np.cumsum(np.column_stack([self._sums, rows]), axis=1)[:, -1]
            self._last_ns = int(stamps_ns[part[-1]])

    def close(self) -> None:
        """End the window that is open."""
        if self._last_ns - self._first_ns >= FULL * self._window_ns:
            n, v, away = self._sums
            s = np.sin(self._reference_rad + away / n)
            self._blocks.row(self._first_ns)[:] += (v / n * s, s * s)
            self.windows += 1
        self._key = (-1, -1)
        self._first_ns = self._last_ns = 0
        self._sums = np.zeros(3)

    def speed(self) -> tuple[float, float | None]:
        """Return v_w in m/s, by least squares through the origin, and half of its interval."""

        def estimate(sums: Floats) -> Floats:
            with np.errstate(divide="ignore", invalid="ignore"):
                slope: Floats = sums[:, 0] / sums[:, 1]
            return slope

        total = self._blocks.total()
        if not total[1] > 0:
            return nan, None
        return float(total[0] / total[1]), jackknife_half_width(self._blocks, estimate)
