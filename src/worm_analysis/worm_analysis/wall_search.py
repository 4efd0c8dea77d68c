"""The head's search along a chamber's wall: motion, contact, episodes, C_θ and their sums."""

from worm_analysis.angular_motion import NS, AngularSpeed
from worm_analysis.contacts import Approach, ClosedEpisode, ContactEpisodes, ContactSensor
from worm_analysis.correlation import SignCorrelation, lag_grid
from worm_analysis.episode_sums import EpisodeSums
from worm_analysis.frame_sums import FrameSums
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import Episode, Observables


class WallSearch:
    """Takes the frames in which the head is in a chamber and not in its exit.

    Parameters
    ----------
    parameters : AnalysisParameters
        Settings.
    radius_m : float
        R.

    Attributes
    ----------
    radius_m : float
        R.
    correlation : SignCorrelation
        C_θ(t).
    frames : FrameSums
        Statistics of frames.
    episodes : EpisodeSums
        Statistics of contacts and excursions.
    observed_s : float
        Time in a chamber, breaks left out.
    """

    def __init__(self, parameters: AnalysisParameters, radius_m: float):
        self.radius_m = radius_m
        self._max_gap_ns = round(parameters.max_gap_s * NS)
        self._sensor = ContactSensor(parameters.contact_factor, parameters.release_factor)
        self._approach = Approach(parameters.incidence_window_s)
        self._contacts = ContactEpisodes(radius_m, parameters.min_episode_s)
        self._speed = AngularSpeed(parameters.theta_dot_window_s)
        self._last_ns: int | None = None
        self._interval_s = 0.0
        self.correlation = SignCorrelation(
            lag_grid(
                parameters.max_lag_s,
                parameters.fine_lag_s,
                parameters.fine_step_s,
                parameters.coarse_step_s,
            ),
            parameters.fine_step_s,
        )
        self.frames = FrameSums(radius_m)
        self.episodes = EpisodeSums()
        self.observed_s = 0.0

    def move(
        self,
        chamber: str,
        stamp_ns: int,
        theta_rad: float,
        r_h_m: float,
        head_m: tuple[float, float],
        width_m: float,
    ) -> tuple[float, bool | None, list[Episode]]:
        """Take the head's position in a frame.

        Parameters
        ----------
        chamber : str
            The chamber that the head is in.
        stamp_ns : int
            Later than that of the last frame.
        theta_rad, r_h_m : float
            θ_h, unwrapped, and r_h.
        head_m : (float, float)
            x, y of the head in the chamber's frame.
        width_m : float
            d_w; NaN where it is not known.

        Returns
        -------
        theta_dot_rad_s : float
            θ̇_h; NaN where it cannot be had.
        contact : bool or None
            Whether the head touches the wall; None where it cannot be told.
        closed : list of Episode
            What this frame ends.
        """
        closed = self._heed_gap(stamp_ns)
        theta_dot = self._speed.push(stamp_ns, theta_rad)
        self.correlation.push(stamp_ns, theta_dot)
        depth_m = self.radius_m - r_h_m
        incidence = self._approach.push(stamp_ns, *head_m)
        contact = self._sensor.push(depth_m, width_m)
        if contact is not None:
            closed += self._keep(
                self._contacts.push(chamber, stamp_ns, theta_rad, depth_m, contact, incidence)
            )
        return theta_dot, contact, closed

    def count(self, observables: Observables, length_m: float) -> None:
        """Add the frame that was last moved to, now that all of it is known."""
        self.frames.push(observables, length_m, self._interval_s)

    def _heed_gap(self, stamp_ns: int) -> list[Episode]:
        closed: list[Episode] = []
        self._interval_s = 0.0
        if self._last_ns is not None:
            if stamp_ns - self._last_ns > self._max_gap_ns:
                closed = self.break_off()
            else:
                self._interval_s = (stamp_ns - self._last_ns) / NS
        self._last_ns = stamp_ns
        self.observed_s += self._interval_s
        return closed

    def end_contact(self) -> list[Episode]:
        """Say that the head has left the wall for the exit; return what that cuts short."""
        self._sensor.reset()
        self._approach.reset()
        return self._keep(self._contacts.cut())

    def break_off(self) -> list[Episode]:
        """Say that what follows is not connected: a gap, or another visit."""
        self._speed.reset()
        self.correlation.break_off()
        self._last_ns = None
        return self.end_contact()

    def _keep(self, closed: ClosedEpisode | None) -> list[Episode]:
        if closed is None:
            return []
        self.episodes.push(closed)
        return [closed.episode]
