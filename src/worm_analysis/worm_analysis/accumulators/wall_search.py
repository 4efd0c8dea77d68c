"""The head's search along a chamber's wall: motion, contact, episodes, C_θ and their sums."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from worm_analysis.accumulators.collisions import Collisions
from worm_analysis.accumulators.contact_sensitivity import Sensitivity, threshold_rules
from worm_analysis.accumulators.direction_bridges import DirectionBridge, DirectionBridges
from worm_analysis.accumulators.direction_correlation import SignCorrelation, lag_grid
from worm_analysis.accumulators.episode_sums import EpisodeSums
from worm_analysis.accumulators.frame_rows import FrameRows, Frames
from worm_analysis.accumulators.frame_sums import FrameSums
from worm_analysis.accumulators.settings import SEARCH, SearchSettings
from worm_analysis.accumulators.swimming_speed import SpeedLaw
from worm_analysis.events.contact_state import HiddenContact, ResolvedFrame, tells_contact
from worm_analysis.events.contacts import Approach, ClosedEpisode, ContactEpisodes
from worm_analysis.events.excursion_depth import RadiusNoise
from worm_analysis.kinematics.angular_speed import AngularSpeed
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import EpisodeKind, Observables
from worm_msgs_py.units import NS_PER_S


@dataclass(slots=True)
class GapTimes:
    """Time of the search in which something is missing.

    Attributes
    ----------
    bridged_s, missing_s : float
        Without a head for longer than `max_gap_s`: where the direction is followed over it, and
        where it is not.
    contact_untold_s : float
        With a head of which it cannot be told whether it touches the wall.
    contact_told_ns : int or None
        Stamp of the last frame in which it could; None where what was before is not connected.
    in_exit : bool
        Whether the head has been in the exit since it was last seen in the chamber.
    """

    bridged_s: float = 0.0
    missing_s: float = 0.0
    contact_untold_s: float = 0.0
    contact_told_ns: int | None = None
    in_exit: bool = False


class WallSearch:
    """Takes the frames in which the head is in a chamber and not in its exit.

    Frames are gathered and handed on a thousand at a time; `flush` hands on what is there, and
    must be called before the sums are read.

    Parameters
    ----------
    parameters : AnalysisParameters
        What a user sets.
    radius_m : float
        R.
    settings : SearchSettings

    Attributes
    ----------
    settings : SearchSettings
        As given.
    radius_m : float
        R.
    correlation : SignCorrelation
        C_θ(t).
    frames : FrameSums
        Statistics of frames.
    speed_law : SpeedLaw
        v_w.
    collisions : Collisions
        θ̇_h against θ_h^i.
    episodes : EpisodeSums
        Statistics of contacts and excursions.
    sensitivity : Sensitivity
        d_c and d_nc under other rules of contact.
    contact : HiddenContact
        Tells contact, and the noise of the radius.
    observed_s : float
        Time in a chamber, breaks left out.
    gaps : GapTimes
        The time of the breaks within visits.
    """

    def __init__(
        self, parameters: AnalysisParameters, radius_m: float, settings: SearchSettings = SEARCH
    ):
        self.settings = settings
        self.radius_m = radius_m
        self._max_gap_ns = round(parameters.max_gap_s * NS_PER_S)
        self._max_bridged_s = parameters.max_bridged_s
        self._contact_factor = parameters.contact_factor
        self.contact = HiddenContact(settings.contact)
        self._chamber = ""
        self._approach = Approach(parameters.incidence_window_s)
        self._contacts = ContactEpisodes(radius_m, parameters.min_episode_s, settings.episodes)
        self._speed = AngularSpeed(parameters.theta_dot_window_s)
        self._rows = FrameRows()
        self._stretch = self._approaches = self._searches = 0
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
        self._stretch_correlated = 0
        longest_s = parameters.max_bridged_s + parameters.theta_dot_window_s
        self._bridges = DirectionBridges(round(longest_s * NS_PER_S))
        self.frames = FrameSums(radius_m)
        self.speed_law = SpeedLaw(radius_m, parameters.mean_window_s, settings)
        self.collisions = Collisions(parameters.theta_dot_window_s)
        self.episodes = EpisodeSums(radius_m, settings)
        self.sensitivity = Sensitivity(threshold_rules(parameters, settings), radius_m)
        self.observed_s = 0.0
        self.gaps = GapTimes()

    def move(
        self,
        chamber: str,
        stamp_ns: int,
        theta_rad: float,
        r_h_m: float,
        head_m: tuple[float, float],
        width_m: float,
        *,
        in_mouth: bool,
        head_sd_m: float,
    ) -> tuple[float, bool | None, list[ClosedEpisode]]:
        """Take the head's position in a frame.

        Parameters
        ----------
        chamber : str
            The chamber that the head is in.
        stamp_ns : int
            Later than that of the last frame.
        theta_rad, r_h_m, width_m : float
            θ_h, unwrapped, r_h, and d_w, which is NaN where it is not known.
        head_m : (float, float)
            x, y of the head in the chamber's frame.
        in_mouth : bool
            Whether the head is before the exit, where there is no wall.
        head_sd_m : float
            How far it may be from there: with too much of it contact is not told.

        Returns
        -------
        theta_dot_rad_s : float
            θ̇_h; NaN where it cannot be had.
        contact : bool or None
            Whether the head touches the wall, as far as is known now; None where it cannot be told.
        closed : list of ClosedEpisode
            What is now known to have ended.
        """
        closed = self._heed_gap(stamp_ns)
        theta_dot = self._speed.push(stamp_ns, theta_rad)
        self._chamber = chamber
        threshold_m = self._contact_factor * width_m
        if not (in_mouth or tells_contact(head_sd_m, threshold_m, self.settings.contact)):
            self.gaps.contact_untold_s += self._interval_s
            return theta_dot, None, closed
        closed += self._heed_untold_contact(stamp_ns)
        contact, resolved = self.contact.push(
            stamp_ns, theta_rad, self.radius_m - r_h_m, head_m, threshold_m, in_mouth=in_mouth
        )
        return theta_dot, contact, closed + self._take_resolved(resolved)

    def _heed_untold_contact(self, stamp_ns: int) -> list[ClosedEpisode]:
        """End the episode that was open before contact could not be told for too long."""
        last_ns, closed = self.gaps.contact_told_ns, list[ClosedEpisode]()
        if last_ns is not None and stamp_ns - last_ns > self._max_gap_ns:
            gap_s = (stamp_ns - last_ns) / NS_PER_S
            gap_s = gap_s if gap_s <= self._max_bridged_s else nan
            closed = self._end_approach(into_exit=False, gap_s=gap_s)
        self.gaps.contact_told_ns = stamp_ns
        return closed

    def _take_resolved(self, resolved: Sequence[ResolvedFrame]) -> list[ClosedEpisode]:
        """Take frames of which contact is now known for good."""
        closed: list[ClosedEpisode] = []
        if resolved:
            law, threshold_m = self.contact.law, self.contact.threshold_m
            self._contacts.noise = RadiusNoise(law.noise_above_bins * threshold_m, law.kept)
            self._contacts.edge_m = law.edge * threshold_m
        for frame in resolved:
            self._approach.push(frame.stamp_ns, *frame.head_m)
            for ended in self._contacts.push(self._chamber, frame, self._approach):
                closed += self._keep(ended)
                if ended.episode.kind is EpisodeKind.FREE and self._contacts.collision:
                    self.collisions.begin(*self._contacts.collision)
            self.collisions.follow(frame.stamp_ns, frame.theta_rad)
        return closed

    def count(self, observables: Observables, width_m: float) -> None:
        """Add the frame that was last moved to, now that all of it is known."""
        contact = observables.contact
        enough = self._rows.push(
            (observables.stamp_ns, self._stretch, self._approaches, self._searches),
            (
                self._interval_s,
                observables.r_h_m,
                observables.r_c_m,
                observables.r_t_m,
                observables.theta_h_rad,
                observables.theta_dot_rad_s,
                observables.psi_b_rad,
                observables.psi_h_rad,
                nan if contact is None else contact,
                (self.radius_m - observables.r_h_m) / width_m
                if width_m and contact is not None
                else nan,
            ),
        )
        if enough:
            self.flush()

    def flush(self) -> None:
        """Hand on the frames that were gathered."""
        if not len(self._rows):
            return
        frames = self._rows.take()
        bridges = self._bridges.push(frames)
        self.frames.add(frames, bridges)
        self.speed_law.add(frames)
        self.sensitivity.add(frames)
        self._correlate(frames, bridges)

    def _correlate(self, frames: Frames, bridges: Sequence[DirectionBridge]) -> None:
        ending_at = {bridge.row: bridge for bridge in bridges}
        for part in frames.stretches():
            directed = np.flatnonzero(np.isfinite(frames.theta_dot_rad_s[part]))
            if not len(directed):
                continue
            if int(frames.stretch[part.start]) != self._stretch_correlated:
                bridge = ending_at.get(part.start + int(directed[0]))
                if bridge is None:
                    self.correlation.break_off()
                else:
                    self.correlation.bridge(bridge)
                self._stretch_correlated = int(frames.stretch[part.start])
            self.correlation.add(frames.stamp_ns[part], frames.theta_dot_rad_s[part])

    def _heed_gap(self, stamp_ns: int) -> list[ClosedEpisode]:
        closed: list[ClosedEpisode] = []
        self._interval_s = 0.0
        if self._last_ns is not None:
            if stamp_ns - self._last_ns > self._max_gap_ns:
                closed = self._break_at_gap((stamp_ns - self._last_ns) / NS_PER_S)
            else:
                self._interval_s = (stamp_ns - self._last_ns) / NS_PER_S
        self._last_ns = stamp_ns
        self.gaps.in_exit = False
        self.observed_s += self._interval_s
        return closed

    def _break_at_gap(self, gap_s: float) -> list[ClosedEpisode]:
        """End the stretch; the search goes on where the gap is short enough to be bridged."""
        if self.gaps.in_exit:
            return self.break_off()
        if gap_s > self._max_bridged_s:
            self.gaps.missing_s += gap_s
            return self.break_off()
        self.gaps.bridged_s += gap_s
        return self._end_stretch(gap_s)

    def enter_exit(self, stamp_ns: int) -> list[ClosedEpisode]:
        """Say that the head is in the exit in this frame; return what that ends."""
        told_ns = self.gaps.contact_told_ns
        seen = told_ns is not None and stamp_ns - told_ns <= self._max_gap_ns
        if seen:
            self.sensitivity.ended_in_exit(self._approaches)
        self.gaps.in_exit = True
        self._searches += 1
        return self._end_approach(into_exit=seen)

    def _end_approach(self, *, into_exit: bool, gap_s: float = nan) -> list[ClosedEpisode]:
        closed = self._take_resolved(self.contact.cut())
        self.gaps.contact_told_ns = None
        self._approach.reset()
        self.collisions.break_off()
        self._approaches += 1
        ended = self._contacts.cut(into_exit=into_exit)
        return closed if ended is None else closed + self._keep(ended, gap_s)

    def break_off(self) -> list[ClosedEpisode]:
        """Say that what follows is not connected: a long gap, or another visit."""
        self._searches += 1
        return self._end_stretch(nan)

    def _end_stretch(self, gap_s: float) -> list[ClosedEpisode]:
        self._speed.reset()
        self._stretch += 1
        self._last_ns = None
        return self._end_approach(into_exit=False, gap_s=gap_s)

    def finish(self) -> list[ClosedEpisode]:
        """End the trial."""
        closed = self.break_off()
        self.flush()
        self.speed_law.close()
        self.sensitivity.cut()
        return closed

    def _keep(self, closed: ClosedEpisode, gap_s: float = nan) -> list[ClosedEpisode]:
        self.episodes.push(closed, gap_s)
        return [closed]
