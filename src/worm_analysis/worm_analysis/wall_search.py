"""The head's search along a chamber's wall: motion, contact, episodes, C_θ and their sums."""

from dataclasses import replace

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
        self._radius_m = radius_m
        self._max_gap_ns = round(parameters.max_gap_s * NS)
        self._sensor = ContactSensor(parameters.contact_factor, parameters.release_factor)
        self._approach = Approach(parameters.incidence_window_s)
        self._contacts = ContactEpisodes(radius_m, parameters.min_episode_s)
        self._speed = AngularSpeed(parameters.theta_dot_window_s)
        self._last_ns: int | None = None
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

    def push(
        self,
        chamber: str,
        observables: Observables,
        head_m: tuple[float, float],
        length_m: float,
        width_m: float,
    ) -> tuple[Observables, list[Episode]]:
        """Take a frame.

        Parameters
        ----------
        chamber : str
            The chamber that the head is in.
        observables : Observables
            Positions and angles; θ_h unwrapped.
        head_m : (float, float)
            x, y of the head in the chamber's frame.
        length_m, width_m : float
            Length of the body in this frame, and d_w; may be NaN.

        Returns
        -------
        Observables
            The same with θ̇_h, v_b and contact.
        list of Episode
            What closed.
        """
        stamp_ns, theta = observables.stamp_ns, observables.theta_h_rad
        closed: list[Episode] = []
        interval_s = 0.0
        if self._last_ns is not None:
            if stamp_ns - self._last_ns > self._max_gap_ns:
                closed += self.break_off()
            else:
                interval_s = (stamp_ns - self._last_ns) / NS
        self._last_ns = stamp_ns
        self.observed_s += interval_s
        theta_dot = self._speed.push(stamp_ns, theta)
        depth_m = self._radius_m - observables.r_h_m
        incidence = self._approach.push(stamp_ns, *head_m)
        contact = self._sensor.push(depth_m, width_m)
        if contact is not None:
            closed += self._keep(
                self._contacts.push(chamber, stamp_ns, theta, depth_m, contact, incidence)
            )
        observables = replace(
            observables,
            theta_dot_rad_s=theta_dot,
            v_b_m_s=self._radius_m * theta_dot,
            contact=contact,
        )
        self.correlation.push(stamp_ns, theta_dot)
        self.frames.push(observables, length_m, interval_s)
        return observables, closed

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
