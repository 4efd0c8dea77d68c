"""Cuts the head's track into contacts with the wall and excursions from it, frame by frame."""

from collections import deque
from dataclasses import dataclass
from math import nan

from worm_analysis.kinematics.observables import incidence_angle
from worm_msgs_py import Episode, EpisodeKind
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class ClosedEpisode:
    """An episode with what the statistics need beyond its public record.

    Attributes
    ----------
    episode : Episode
        The record.
    turn_rad : float
        Δθ_h over the episode, signed.
    frames : int
        Number of frame intervals that it spans.
    start_seen : bool
        Whether the episode before it ended where it starts; False leaves its start unknown.
    before_rad, end_rad : float
        θ_h in the last frame before the episode, NaN where its start was not seen, and in its end.
    cut : bool
        Whether no episode follows it: the next one is not connected.
    """

    episode: Episode
    turn_rad: float
    frames: int
    start_seen: bool
    before_rad: float = nan
    end_rad: float = nan
    cut: bool = False


@dataclass(slots=True)
class _Run:
    """Frames of one kind in a row; `depth_m` is the largest R − r_h."""

    kind: EpisodeKind
    start_ns: int
    start_rad: float
    last_ns: int
    last_rad: float
    depth_m: float
    incidence_rad: float = nan
    frames: int = 0
    start_seen: bool = True
    before_rad: float = nan


class ContactSensor:
    """Tells contact from R − r_h, with two thresholds where hysteresis is asked for."""

    def __init__(self, contact_factor: float, release_factor: float):
        self._contact_factor = contact_factor
        self._release_factor = release_factor
        self._touching = False

    def push(self, depth_m: float, width_m: float) -> bool | None:
        """Return whether R − r_h is within the threshold; None where either is NaN."""
        factor = self._release_factor if self._touching else self._contact_factor
        limit = factor * width_m
        if depth_m != depth_m or limit != limit:
            return None
        self._touching = depth_m < limit
        return self._touching

    def reset(self) -> None:
        """Forget the last frame."""
        self._touching = False


class Approach:
    """The head's last positions, for the direction from which it comes to the wall."""

    def __init__(self, window_s: float):
        self._window_ns = round(window_s * NS_PER_S)
        self._positions: deque[tuple[int, float, float]] = deque()

    def push(self, stamp_ns: int, x_m: float, y_m: float) -> None:
        """Take a frame."""
        self._positions.append((stamp_ns, x_m, y_m))
        while len(self._positions) > 2 and self._positions[0][0] < stamp_ns - self._window_ns:
            self._positions.popleft()

    def incidence(self) -> float:
        """Return θ_h^i as if the head touched the wall in the last frame; NaN without a past."""
        if len(self._positions) < 2:
            return nan
        _, before_x, before_y = self._positions[0]
        _, x_m, y_m = self._positions[-1]
        if (before_x, before_y) == (x_m, y_m):
            return nan
        return float(incidence_angle(before_x, before_y, x_m, y_m))

    def reset(self) -> None:
        """Forget all positions."""
        self._positions.clear()


class ContactEpisodes:
    """Turns the frames of a chamber into episodes (paper, section on Fig. 3).

    An episode lasts from its first frame to the first frame of the next one, and so do d_c and
    d_nc: they tile the track. A run shorter than `min_episode_s` is taken into the episode around
    it.

    Parameters
    ----------
    radius_m : float
        R, which turns Δθ_h into a distance along the wall.
    min_episode_s : float
        See `AnalysisParameters`.
    """

    def __init__(self, radius_m: float, min_episode_s: float):
        self._radius_m = radius_m
        self._min_ns = round(min_episode_s * NS_PER_S)
        self._chamber = ""
        self._run: _Run | None = None
        self._candidate: _Run | None = None

    def push(
        self,
        chamber: str,
        stamp_ns: int,
        theta_rad: float,
        depth_m: float,
        contact: bool,
        approach: Approach,
    ) -> ClosedEpisode | None:
        """Take a frame; return the episode that it ends, if it does.

        Parameters
        ----------
        chamber : str
            Where the head is; the same until `cut`.
        stamp_ns : int
            Later than that of the last frame.
        theta_rad : float
            θ_h, unwrapped.
        depth_m : float
            R − r_h.
        contact : bool
            Whether the head touches the wall.
        approach : Approach
            Gives θ_h^i if a contact starts here.
        """
        self._chamber = chamber
        kind = EpisodeKind.CONTACT if contact else EpisodeKind.FREE
        if self._run is None:
            self._run = _Run(kind, stamp_ns, theta_rad, stamp_ns, theta_rad, depth_m)
            self._run.start_seen = False
            return None
        if kind is self._run.kind:
            self._take_back_candidate()
            _extend(self._run, stamp_ns, theta_rad, depth_m)
            return None
        if self._candidate is None:
            self._candidate = _Run(
                kind, stamp_ns, theta_rad, stamp_ns, theta_rad, depth_m,
                approach.incidence() if contact else nan, before_rad=self._run.last_rad,
            )  # fmt: skip
        else:
            _extend(self._candidate, stamp_ns, theta_rad, depth_m)
        if stamp_ns - self._candidate.start_ns < self._min_ns:
            return None
        return self._close_at_candidate(self._candidate)

    @property
    def collision(self) -> tuple[int, float, float] | None:
        """Where the current contact began: stamp, θ_h and θ_h^i; None out of contact."""
        run = self._run
        if run is None or run.kind is EpisodeKind.FREE:
            return None
        return run.start_ns, run.start_rad, run.incidence_rad

    def cut(self, *, into_exit: bool = False) -> ClosedEpisode | None:
        """End the episode where its last frame was: a gap, the exit or the end of the track.

        An excursion that ends in the exit is complete: the head came down there, as it would have
        come down to the wall. A contact that meets the exit is not: it would have gone on.
        """
        run = self._run
        if run is None:
            return None
        self._take_back_candidate()
        self._run = None
        landed = into_exit and run.kind is EpisodeKind.FREE and run.start_seen
        return self._closed(run, run.last_ns, run.last_rad, run.frames, complete=landed, cut=True)

    def _close_at_candidate(self, candidate: _Run) -> ClosedEpisode:
        run = self._run
        assert run is not None
        self._run, self._candidate = candidate, None
        return self._closed(
            run, candidate.start_ns, candidate.start_rad, run.frames + 1, complete=run.start_seen
        )

    def _take_back_candidate(self) -> None:
        run, candidate = self._run, self._candidate
        if run is not None and candidate is not None:
            run.frames += candidate.frames + 1
            run.depth_m = max(run.depth_m, candidate.depth_m)
            run.last_ns, run.last_rad = candidate.last_ns, candidate.last_rad
            self._candidate = None

    def _closed(
        self,
        run: _Run,
        end_ns: int,
        end_rad: float,
        frames: int,
        *,
        complete: bool,
        cut: bool = False,
    ) -> ClosedEpisode:
        turn_rad = end_rad - run.start_rad
        in_contact = run.kind is EpisodeKind.CONTACT
        episode = Episode(
            chamber=self._chamber,
            kind=run.kind,
            start_ns=run.start_ns,
            end_ns=end_ns,
            distance_m=self._radius_m * abs(turn_rad),
            delta_r_m=nan if in_contact else run.depth_m,
            incidence_rad=run.incidence_rad if in_contact else nan,
            complete=complete,
        )
        return ClosedEpisode(
            episode, turn_rad, frames, run.start_seen, run.before_rad, end_rad, cut
        )


def _extend(run: _Run, stamp_ns: int, theta_rad: float, depth_m: float) -> None:
    run.last_ns, run.last_rad = stamp_ns, theta_rad
    run.depth_m = max(run.depth_m, depth_m)
    run.frames += 1
