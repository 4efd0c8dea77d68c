"""The head's polar angle through time: unwrapped, and its rate over the last second."""

from collections import deque
from math import nan

from worm_analysis.kinematics.observables import wrap_angle
from worm_msgs_py.units import NS_PER_S


class UnwrappedAngle:
    """θ_h without jumps of 2π, starting anew with each visit of a chamber.

    Each frame takes the branch that is nearest to the last frame with a head, however long ago
    that was: frames without a head leave the count of turns as it is.
    """

    def __init__(self) -> None:
        self._last = nan

    def push(self, theta_rad: float) -> float:
        """Return the unwrapped angle; NaN for NaN."""
        if theta_rad != theta_rad:
            return nan
        if self._last == self._last:
            turn: float = wrap_angle(theta_rad - self._last)
            theta_rad = self._last + turn
        self._last = theta_rad
        return theta_rad

    def reset(self) -> None:
        """Start anew: the next angle is taken as it is, in (−π, π]."""
        self._last = nan


class AngularSpeed:
    """θ̇_h = Δθ_h/Δt over the last Δt, whatever the times of the frames.

    θ_h at t − Δt is interpolated between the two frames around it (paper, section on Fig. 4).

    Parameters
    ----------
    window_s : float
        Δt.
    """

    def __init__(self, window_s: float):
        self._window_ns = round(window_s * NS_PER_S)
        self._samples: deque[tuple[int, float]] = deque()

    def push(self, stamp_ns: int, theta_rad: float) -> float:
        """Take a frame with a head; return θ̇_h in rad/s, NaN until Δt is covered."""
        samples = self._samples
        samples.append((stamp_ns, theta_rad))
        target = stamp_ns - self._window_ns
        while len(samples) > 1 and samples[1][0] <= target:
            samples.popleft()
        start, past = samples[0]
        if start > target:
            return nan
        if start < target:
            after, later = samples[1]
            past += (later - past) * ((target - start) / (after - start))
        return (theta_rad - past) * (NS_PER_S / self._window_ns)

    def reset(self) -> None:
        """Forget all frames: what follows is not connected to them."""
        self._samples.clear()
