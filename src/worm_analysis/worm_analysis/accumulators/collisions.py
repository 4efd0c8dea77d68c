"""How the head moves on after it has come to the wall, against the angle at which it came."""

from collections import deque

from worm_analysis.statistics.block_jackknife import BlockSums
from worm_analysis.statistics.thinned_points import ThinnedPoints
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import NS_PER_S


class Collisions:
    """θ̇_h over the Δt after a contact begins, against θ_h^i (paper, Fig. 4b).

    θ_h at the end of Δt is interpolated between the two frames around it. A contact after which
    the track breaks off within Δt, or whose incidence is not known, is not a pair.

    Parameters
    ----------
    window_s : float
        Δt.
    """

    def __init__(self, window_s: float):
        self._window_ns = round(window_s * NS_PER_S)
        self._open: deque[tuple[int, float, float]] = deque()
        self._last: tuple[int, float] = (0, 0.0)
        self._blocks = BlockSums(6)
        self._points = ThinnedPoints()

    def begin(self, stamp_ns: int, theta_rad: float, incidence_rad: float) -> None:
        """Take a contact: when, where and at which angle it began."""
        if incidence_rad == incidence_rad:
            self._open.append((stamp_ns, theta_rad, incidence_rad))

    def follow(self, stamp_ns: int, theta_rad: float) -> None:
        """Take every frame of the stretch, with θ_h unwrapped."""
        while self._open and stamp_ns - self._open[0][0] >= self._window_ns:
            start_ns, start_rad, incidence_rad = self._open.popleft()
            end_ns = start_ns + self._window_ns
            before_ns, before_rad = self._last
            if not before_ns <= end_ns:
                continue  # the contact was told so late that its Δt is over
            part = (end_ns - before_ns) / (stamp_ns - before_ns)
            turn_rad = before_rad + part * (theta_rad - before_rad) - start_rad
            speed = turn_rad * (NS_PER_S / self._window_ns)
            row = self._blocks.row(start_ns)
            row += (
                1.0,
                speed,
                incidence_rad,
                speed * speed,
                incidence_rad * incidence_rad,
                speed * incidence_rad,
            )
            self._points.push(incidence_rad, speed)
        self._last = (stamp_ns, theta_rad)

    def break_off(self) -> None:
        """Say that what follows is not connected."""
        self._open.clear()

    def sums(self) -> dict[str, Floats]:
        """Return the sums of 1, θ̇_h, θ_h^i, their squares and product, and some of the pairs."""
        return {
            "theta_dot_incidence": self._blocks.rows(),
            "collision_points": self._points.rows(),
        }
