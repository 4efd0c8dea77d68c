"""Where head and body are in the rig: which visit, whether at the exit, and what that closes."""

from math import hypot, nan

from worm_analysis.accumulators.passage_sums import PassageSums
from worm_analysis.events.attempts import Attempts
from worm_analysis.events.contacts import ClosedEpisode
from worm_analysis.events.exit_region import EXITS, ExitCorridor, ExitSettings
from worm_analysis.events.visits import Visits
from worm_analysis.kinematics.observables import wrap_angle
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import (
    Attempt,
    BodyState,
    Chamber,
    EpisodeKind,
    Event,
    Geometry,
    Keypoint,
    Visit,
    Where,
)
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.units import NS_PER_S

_CHAMBER_OF = {Where.CHAMBER_A: CHAMBER_A, Where.CHAMBER_B: CHAMBER_B}


class RigPosition:
    """Takes every frame with a head; follows visits and attempts.

    Parameters
    ----------
    parameters : AnalysisParameters
        What a user sets.
    settings : ExitSettings

    Attributes
    ----------
    sums : PassageSums
        Statistics of visits and attempts.
    searching : bool
        Whether the head is, in the last frame, in the chamber of the body and not in its exit.
    away : bool
        Whether it is in the exit or in the passage. Neither is true of a frame in which it cannot
        be told.
    """

    def __init__(self, parameters: AnalysisParameters, settings: ExitSettings = EXITS):
        self._settings = settings
        self._max_gap_ns = round(parameters.max_gap_s * NS_PER_S)
        self._attempts = Attempts(parameters.stroke_window_s, settings)
        self._visits = Visits(settings)
        self._last_ns = 0
        self._geometry: Geometry | None = None
        self._where = Where.UNKNOWN
        self._home: Chamber | None = None
        self._corridor = ExitCorridor(nan, nan, nan, nan, nan)
        self.sums = PassageSums()
        self.searching = False
        self.away = True

    @property
    def visit(self) -> int:
        """Number of the visit: it grows with every chamber that is entered."""
        return self._visits.number

    @property
    def home(self) -> str:
        """The chamber that the body is in; empty in the passage."""
        return self._visits.home

    @property
    def skips(self) -> tuple[int, int]:
        """Skips of the whole trial, over the exit and over one that is w_s wide, as in the walk."""
        return self._visits.skips, self._visits.wide_skips

    def push(
        self, state: BodyState, geometry: Geometry, threshold_m: float, noise_m: float
    ) -> list[Event]:
        """Take a frame with a head.

        Parameters
        ----------
        state : BodyState
            Metric coordinates in a chamber's frame.
        geometry : Geometry
            The one that the state rests on.
        threshold_m : float
            The distance that counts as contact; NaN where it is not known.
        noise_m : float
            Standard deviation of the head's place across a wall.
        """
        stamp_ns = state.stamp_ns
        if self._goes_on(state, geometry):
            self._last_ns = stamp_ns
            self._visits.stay(stamp_ns)
            self._attempts.watch(stamp_ns, (state.head.x_m, state.head.y_m), state.length_m)
            return []
        events: list[Event] = []
        if stamp_ns - self._last_ns > self._max_gap_ns:
            events += self._keep(self._attempts.cut())
            self._visits.lose()
        self._last_ns = stamp_ns
        head_in = _CHAMBER_OF.get(state.where, "")
        head_in = head_in if head_in == state.frame_id else ""
        if self._is_in_chamber(head_in, state, geometry):
            self._visits.locate(head_in, stamp_ns)
        if self._visits.home:
            events += self._at_exit(state, geometry, threshold_m, noise_m)
        elif state.where is Where.PASSAGE:
            self._visits.pass_through()
        self.away = self._attempts.active or not self.home
        self.searching = bool(head_in) and head_in == self.home and not self.away
        self._geometry, self._where = geometry, state.where
        return events

    def _goes_on(self, state: BodyState, geometry: Geometry) -> bool:
        """Whether the head searches on as in the last frame: nearly all frames are such."""
        return (
            self.searching
            and geometry is self._geometry
            and state.where is self._where
            and state.stamp_ns - self._last_ns <= self._max_gap_ns
            and not self._corridor.has_between_walls(state.head.x_m, state.head.y_m)
        )

    def in_mouth(self, theta_rad: float) -> bool:
        """Whether a head at this angle is before the exit, where there is no wall."""
        return abs(wrap_angle(theta_rad)) < self._corridor.half_arc_rad

    def observe(self, closed: list[ClosedEpisode]) -> None:
        """Add what only the search along the wall can tell: contacts and hops."""
        for item in closed:
            self._visits.may_touch(item.may_touch_rad)
            if item.episode.kind is EpisodeKind.CONTACT:
                self._visits.touch(*item.touch)
            elif item.episode.complete and not item.cut and self._is_near_wall(item):
                self._visits.hop(item.before_rad, item.end_rad, self._corridor)

    def _is_near_wall(self, item: ClosedEpisode) -> bool:
        """Tell a hop from a way through the middle of the chamber, which skips nothing."""
        deepest_m = self._settings.deepest_skip_in_radii * self._corridor.radius_m
        return item.episode.delta_r_m < deepest_m

    def ended_visits(self) -> list[Event]:
        """Return the visits that have ended, now that all of their contacts were observed."""
        return [event for visit in self._visits.ended() for event in self._keep(visit)]

    def finish(self) -> list[Event]:
        """End what is open, cut short."""
        self._visits.finish()
        return [*self._keep(self._attempts.cut()), *self.ended_visits()]

    def _is_in_chamber(self, head_in: str, state: BodyState, geometry: Geometry) -> bool:
        """Whether the head is in a chamber; to come into one it must be inside the circle."""
        if not head_in or self._attempts.active:
            return False
        inside = hypot(state.head.x_m, state.head.y_m) < geometry.chamber(head_in).radius_m
        return head_in == self._visits.home or inside

    def _at_exit(
        self, state: BodyState, geometry: Geometry, threshold_m: float, noise_m: float
    ) -> list[Event]:
        home = geometry.chamber(self._visits.home)
        if home is not self._home:
            self._home, self._corridor = home, ExitCorridor.of(home, geometry.depth_m)
        was_active = self._attempts.active
        attempt = self._attempts.push(
            home.name,
            self._corridor,
            state.stamp_ns,
            _in_frame(home, state.frame_id, state.head),
            _in_frame(home, state.frame_id, state.centroid),
            state.length_m,
            threshold_m,
            error_m=max(
                self._settings.noise_in_error * noise_m,
                self._settings.pixels_in_error / home.px_per_m,
            ),
            in_passage=state.where is Where.PASSAGE,
            through=_CHAMBER_OF.get(state.where, home.name) != home.name,
        )
        events: list[Event] = []
        if not was_active and (self._attempts.active or attempt):
            self._visits.find_exit(state.stamp_ns)
        events += self._keep(attempt)
        if attempt is not None and attempt.success:
            self._visits.leave()
        return events

    def _keep(self, event: Attempt | Visit | None) -> list[Event]:
        if event is None:
            return []
        if isinstance(event, Visit):
            self.sums.push_visit(event)
        else:
            self.sums.push_attempt(event)
        return [event]


def _in_frame(chamber: Chamber, frame_id: str, point: Keypoint) -> tuple[float, float]:
    """Return a point in a chamber's frame: as it stands, or from the picture if it is another's."""
    if frame_id == chamber.name:
        return point.x_m, point.y_m
    return chamber.to_metres(point.u_px, point.v_px)
