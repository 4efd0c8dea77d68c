"""Cuts the head's track into contacts with the wall and excursions from it, frame by frame."""

from collections import deque
from dataclasses import dataclass, field
from math import inf, nan

from worm_analysis.events.contact_state import ResolvedFrame
from worm_analysis.events.excursion_depth import (
    CONTACT_EPISODES,
    EpisodeSettings,
    ExcursionDepth,
    RadiusNoise,
)
from worm_analysis.kinematics.observables import incidence_angle
from worm_msgs_py import Episode, EpisodeKind
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class Expected:
    """What the frames of an episode say of contacts and excursions, by their probabilities.

    Attributes
    ----------
    turn_c_rad, turn_f_rad : float
        |Δθ_h| in contact and out of it.
    ends_c, ends_f : float
        Number of contacts, and of excursions, that end: also of those too short to be seen.
    """

    turn_c_rad: float = 0.0
    turn_f_rad: float = 0.0
    ends_c: float = 0.0
    ends_f: float = 0.0


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
    past_peak : bool
        Whether an excursion that was cut was on its way back: its Δr_h is known.
    expected : Expected
        What its frames add to the means of all episodes.
    touch : (int, float)
        Stamp and θ_h of the first frame that lies within the threshold by more than the noise; of
        the first of all where none does.
    may_touch_rad : float
        θ_h of the first frame that may be in contact; NaN where none may.
    beyond_rad : (float, float)
        How far the head went beyond the start of the episode, and beyond its end, where it turned
        round within it: further than in a frame, and than noise may do. Else 0.
    """

    episode: Episode
    turn_rad: float
    frames: int
    start_seen: bool
    before_rad: float = nan
    end_rad: float = nan
    cut: bool = False
    past_peak: bool = False
    expected: Expected = Expected()
    touch: tuple[int, float] = (0, nan)
    may_touch_rad: float = nan
    beyond_rad: tuple[float, float] = (0.0, 0.0)


@dataclass(slots=True)
class _Expectation:
    """What becomes an `Expected`, with the signs of θ_h; `share` is that of the last frame."""

    share: float = 0.0
    turn_c_rad: float = 0.0
    turn_f_rad: float = 0.0
    ends_c: float = 0.0
    ends_f: float = 0.0

    def go(self, way_rad: float) -> None:
        """Add the way from the last frame on, to contact and excursion by their probabilities."""
        self.turn_c_rad += way_rad * self.share
        self.turn_f_rad += way_rad * (1 - self.share)

    def take(self, frame: ResolvedFrame) -> None:
        """Add a frame's chances."""
        self.share = frame.share
        self.ends_c += frame.leaves
        self.ends_f += frame.touches

    def join(self, other: "_Expectation") -> None:
        """Add what follows."""
        self.share = other.share
        self.turn_c_rad += other.turn_c_rad
        self.turn_f_rad += other.turn_f_rad
        self.ends_c += other.ends_c
        self.ends_f += other.ends_f

    def told(self, sign: float) -> Expected:
        """Return it with the way as a length."""
        return Expected(sign * self.turn_c_rad, sign * self.turn_f_rad, self.ends_c, self.ends_f)


@dataclass(slots=True)
class _Run:
    """Frames of one kind in a row."""

    kind: EpisodeKind
    start_ns: int
    start_rad: float
    last_ns: int
    last_rad: float
    depths: ExcursionDepth
    edge_m: float
    clear_m: float
    may_touch: float
    in_mouth: bool = False
    touch: tuple[int, float] | None = None
    may_touch_rad: float = nan
    incidence_rad: float = nan
    frames: int = 0
    start_seen: bool = True
    before_rad: float = nan
    low_rad: float = inf
    high_rad: float = -inf
    expectation: _Expectation = field(default_factory=_Expectation)

    def take(self, frame: ResolvedFrame) -> None:
        """Add a frame; `in_mouth` stays only as long as all of them are before the exit."""
        self.expectation.go(frame.theta_rad - self.last_rad)
        self.expectation.take(frame)
        self.last_ns, self.last_rad = frame.stamp_ns, frame.theta_rad
        self.low_rad = min(self.low_rad, frame.theta_rad)
        self.high_rad = max(self.high_rad, frame.theta_rad)
        self.in_mouth &= frame.in_mouth
        is_near = frame.depth_m < self.edge_m and not frame.in_mouth
        if (is_near or frame.share > self.may_touch) and self.may_touch_rad != self.may_touch_rad:
            self.may_touch_rad = frame.theta_rad
        if self.kind is EpisodeKind.FREE:
            self.depths.push(frame.depth_m)
        elif self.touch is None and frame.depth_m < self.clear_m:
            self.touch = frame.stamp_ns, frame.theta_rad

    def join(self, other: "_Run") -> None:
        """Take in a run that follows."""
        self.frames += other.frames + 1
        self.last_ns, self.last_rad = other.last_ns, other.last_rad
        self.low_rad = min(self.low_rad, other.low_rad)
        self.high_rad = max(self.high_rad, other.high_rad)
        if self.may_touch_rad != self.may_touch_rad:
            self.may_touch_rad = other.may_touch_rad
        self.expectation.join(other.expectation)

    def beyond(self, end_rad: float, frames: int, least_rad: float) -> tuple[float, float]:
        """Return how far θ_h went beyond start and end, 0 where no turn is told.

        That is where it is less than on average in a frame, or than `least_rad`.
        """
        above = self.high_rad - max(self.start_rad, end_rad)
        below = min(self.start_rad, end_rad) - self.low_rad
        way_rad = abs(end_rad - self.start_rad) + 2 * (max(above, 0.0) + max(below, 0.0))
        least = max(least_rad, way_rad / max(frames, 1))
        above, below = (way if way > least else 0.0 for way in (above, below))
        return (below, above) if end_rad >= self.start_rad else (above, below)


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
    settings : EpisodeSettings

    Attributes
    ----------
    noise : RadiusNoise
        That of the radius, for Δr_h of the excursions to come.
    edge_m : float
        R − r_h where contact ends, without noise.
    """

    def __init__(
        self, radius_m: float, min_episode_s: float, settings: EpisodeSettings = CONTACT_EPISODES
    ):
        self._radius_m = radius_m
        self._settings = settings
        self.noise, self.edge_m = RadiusNoise(), 0.0
        self._min_ns = round(min_episode_s * NS_PER_S)
        self._chamber = ""
        self._run: _Run | None = None
        self._candidate: _Run | None = None

    def push(self, chamber: str, frame: ResolvedFrame, approach: Approach) -> list[ClosedEpisode]:
        """Take a frame; return the episodes that it ends, one at most but behind an exit.

        Parameters
        ----------
        chamber : str
            Where the head is; the same until `cut`.
        frame : ResolvedFrame
            The next one.
        approach : Approach
            Gives θ_h^i if a contact starts here.
        """
        self._chamber = chamber
        kind = EpisodeKind.CONTACT if frame.contact else EpisodeKind.FREE
        if self._run is None:
            self._run = self._begin(kind, frame)
            self._run.start_seen = False
            return []
        closed = self._leave_mouth(frame)
        if kind is self._run.kind:
            self._take_back_candidate()
            self._run.frames += 1
            self._run.take(frame)
            return closed
        if self._candidate is None:
            self._run.expectation.go(frame.theta_rad - self._run.last_rad)
            self._candidate = self._begin(kind, frame)
            self._candidate.incidence_rad = approach.incidence() if frame.contact else nan
            self._candidate.before_rad = self._run.last_rad
        else:
            self._candidate.frames += 1
            self._candidate.take(frame)
        candidate = self._candidate
        if not candidate.in_mouth and frame.stamp_ns - candidate.start_ns >= self._min_ns:
            closed.append(self._close_at_candidate(candidate))
        return closed

    def _leave_mouth(self, frame: ResolvedFrame) -> list[ClosedEpisode]:
        """Count the way over the exit as an excursion, once the head has not entered it.

        A head that slides over the exit, at the wall before and after it, makes none.
        """
        run, over = self._run, self._candidate
        if run is None or over is None or not over.in_mouth or frame.in_mouth:
            return []
        if frame.contact and over.depths.maximum() < self.edge_m:
            return []
        run.expectation.ends_c += 1
        return [self._close_at_candidate(over)]

    def _begin(self, kind: EpisodeKind, frame: ResolvedFrame) -> _Run:
        stamp_ns, theta_rad = frame.stamp_ns, frame.theta_rad
        depths = ExcursionDepth(self.noise, self._settings)
        at = stamp_ns, theta_rad
        clear_m = self.edge_m - self.noise.deviation_m
        run = _Run(
            kind, *at, *at, depths, self.edge_m, clear_m, self._settings.may_touch, frame.in_mouth
        )
        run.take(frame)
        return run

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
        come down to the wall. A contact that meets the exit is not: it would have gone on; nor do
        the last frames before the exit, where there is no wall to touch, make an excursion.
        """
        run = self._run
        if run is None:
            return None
        self._take_back_candidate()
        self._run = None
        landed = into_exit and run.kind is EpisodeKind.FREE and run.start_seen
        if into_exit and run.kind is EpisodeKind.FREE:
            run.expectation.ends_f += 1
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
            if candidate.in_mouth:  # where nothing can be told of contact
                candidate.expectation = _Expectation(candidate.expectation.share)
            run.join(candidate)
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
        noise_rad = self.noise.deviation_m / self._radius_m
        episode = Episode(
            chamber=self._chamber,
            kind=run.kind,
            start_ns=run.start_ns,
            end_ns=end_ns,
            distance_m=self._radius_m * abs(turn_rad),
            delta_r_m=nan if in_contact else run.depths.maximum(),
            incidence_rad=run.incidence_rad if in_contact else nan,
            complete=complete,
        )
        return ClosedEpisode(
            episode,
            turn_rad,
            frames,
            run.start_seen,
            run.before_rad,
            end_rad,
            cut,
            not in_contact and cut and run.depths.is_past_peak,
            run.expectation.told(1.0 if turn_rad >= 0 else -1.0),
            run.touch or (run.start_ns, run.start_rad),
            run.may_touch_rad,
            run.beyond(end_rad, frames, self._settings.turn_deviations * noise_rad),
        )
