"""The whole analysis of a trial: one pass over the tracker's states, in bounded memory."""

from dataclasses import dataclass, replace
from math import nan

from worm_analysis.accumulators.body_size import BodySums
from worm_analysis.accumulators.exclusions import STALE, UNCERTAIN, UNTRACKED, Exclusions
from worm_analysis.accumulators.settings import SEARCH, SearchSettings
from worm_analysis.accumulators.trial_sums import ChamberSize, trial_sums
from worm_analysis.accumulators.wall_search import WallSearch
from worm_analysis.events.contacts import ClosedEpisode
from worm_analysis.events.exit_region import EXITS, ExitSettings
from worm_analysis.kinematics.angular_speed import UnwrappedAngle
from worm_analysis.kinematics.observables import (
    body_angle,
    head_angle,
    polar_angle,
    radial_distance,
)
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.rig_position import RigPosition
from worm_analysis.statistics.running_median import RunningMedian
from worm_analysis.summary.direction_persistence import correlation
from worm_analysis.summary.quantities import DEFINITIONS, quantities
from worm_analysis.summary.settings import DEFAULTS, EstimateSettings
from worm_analysis.summary.sums import Sums
from worm_msgs_py import (
    BodyState,
    Chamber,
    Correlation,
    Distribution,
    Event,
    Geometry,
    Observables,
    Quantity,
    Status,
    TrackedFrame,
)
from worm_msgs_py.arrays import Floats
from worm_msgs_py.paper import RADIUS_MM
from worm_msgs_py.units import MM_PER_M

WIDTH_BIN_M = 2e-6
WIDTH_BINS = 1000
"""d_w of a trial so far, to 2 mm."""


@dataclass(frozen=True, slots=True)
class AnalysisSettings:
    """What a user does not set: the constants of each stage, with the reason for each.

    Attributes
    ----------
    search : SearchSettings
        The search along the wall.
    exits : ExitSettings
        What happens at an exit.
    estimates : EstimateSettings
        How numbers follow; `minimum_n` is that of the parameters.
    """

    search: SearchSettings = SEARCH
    exits: ExitSettings = EXITS
    estimates: EstimateSettings = DEFAULTS


class Analysis:
    """Observables, events and estimates of one trial.

    Everything depends on the states, their order and their stamps alone. A state without a head,
    whose status is not `TRACKED`, whose head is less certain than `min_head_certainty`, or with a
    stamp that does not advance, gives its positions as far as they go and adds to no estimate: it
    is as if the head were missing in that frame. `exclusions` counts them.

    Parameters
    ----------
    parameters : AnalysisParameters
        What a user sets; the defaults are the paper's.
    settings : AnalysisSettings
    """

    def __init__(
        self,
        parameters: AnalysisParameters | None = None,
        settings: AnalysisSettings = AnalysisSettings(),
    ):
        self._parameters = parameters or AnalysisParameters()
        self._settings = settings
        self._geometries: dict[int, Geometry] = {}
        self._geometry: Geometry | None = None
        self._widths = RunningMedian(WIDTH_BIN_M, WIDTH_BINS)
        self._body = BodySums()
        self._unwrapped = UnwrappedAngle()
        self._unwrapped_in = ("", 0)
        self._search = WallSearch(self._parameters, RADIUS_MM / MM_PER_M, settings.search)
        self._position = RigPosition(self._parameters, settings.exits)
        self._last_ns: int | None = None
        self._read: Sums | None = None
        self.exclusions = Exclusions()

    def set_geometry(self, geometry: Geometry) -> None:
        """Take a calibration, before the first state that rests on it."""
        self._geometries[geometry.version] = geometry

    def knows(self, geometry: int) -> bool:
        """Whether this version was given; 0 stands for none and is always known."""
        return geometry == 0 or geometry in self._geometries

    def push(self, frame: TrackedFrame | BodyState) -> tuple[Observables, list[Event]]:
        """Take the next frame.

        Parameters
        ----------
        frame : TrackedFrame or BodyState
            As the tracker gives it, in order; or its state alone, where the geometries come by
            `set_geometry`.

        Returns
        -------
        observables : Observables
            Of this frame, NaN where they cannot be had.
        events : list of Event
            What closed with this frame.

        Raises
        ------
        ValueError
            Where the geometry that the state rests on was not given.
        """
        state = frame.state if isinstance(frame, TrackedFrame) else frame
        if isinstance(frame, TrackedFrame) and frame.geometry is not None:
            self._geometries.setdefault(frame.geometry.version, frame.geometry)
        self._read = None
        geometry = self._geometries.get(state.geometry)
        if geometry is None and state.geometry != 0:
            raise ValueError(
                f"frame {state.frame} rests on geometry {state.geometry}, which has not come: "
                "call set_geometry first, or push the tracker's frame, which has it"
            )
        reason = self._reason_against(state)
        self.exclusions.count(reason)
        if reason != STALE:
            self._last_ns = state.stamp_ns
            if state.status is Status.TRACKED:
                self._widths.push(state.width_m)
                self._body.push(state.stamp_ns, state.length_m, state.width_m)
        chamber = _chamber_of(state, geometry)
        if geometry is None or chamber is None:
            return Observables(state.frame, state.stamp_ns, state.where), []
        if geometry is not self._geometry:
            self._adopt(geometry)
        if reason or state.head.x_m != state.head.x_m:
            return _observables(state), []
        return self._follow(state, geometry, chamber)

    def _reason_against(self, state: BodyState) -> str:
        """Say why a state cannot count; empty where it can."""
        if self._last_ns is not None and state.stamp_ns <= self._last_ns:
            return STALE
        if not state.status.may_have_head or state.head.u_px != state.head.u_px:
            return UNTRACKED
        if state.head_certainty < self._parameters.min_head_certainty:
            return UNCERTAIN
        return ""

    def finish(self) -> list[Event]:
        """End the trial; return what was still open, cut short."""
        self._read = None
        closed = self._search.finish()
        self._position.observe(closed)
        return [*(item.episode for item in closed), *self._position.finish()]

    def correlation(self) -> Correlation:
        """Return C_θ(t) so far."""
        sums = self._sums()
        if not sums.has("c_theta"):  # before there is a chamber
            sums = Sums([self._search.correlation.sums()], lag_s=sums.lag_s)
        t_per = DEFINITIONS["t_per"].of(sums)
        return correlation(sums.units("c_theta"), sums.lag_s, t_per.value, sums.settings)

    def distributions(self) -> list[Distribution]:
        """Return P(r), P(ψ), and those of d_c, d_nc, Δr_h, x_p, τ_h and θ_h⁰ so far."""
        self._search.flush()
        return [
            *self._search.frames.distributions(),
            *self._search.episodes.distributions(),
            *self._position.sums.distributions(),
        ]

    def sums(self) -> dict[str, Floats]:
        """Return all sums so far, by name, in SI: what this trial adds to a pool."""
        return trial_sums(
            self._search,
            self._position.sums,
            self._position.skips,
            self._body,
            self.exclusions,
            None if self._geometry is None else ChamberSize.of(self._geometry),
            self._parameters,
        )

    def summary(self) -> list[Quantity]:
        """Return every number of the trial so far, each with its interval and n."""
        rules = (rule.label for rule in self._search.sensitivity.rules)
        return quantities(self._sums(), rules)

    def _sums(self) -> Sums:
        """Return what the estimates rest on, made once for all that are asked for after a frame."""
        if self._read is None:
            width_m = nan if self._geometry is None else self._geometry.chambers[0].exit_width_m
            lag_s = self._search.correlation.lag_s
            settings = replace(self._settings.estimates, minimum_n=self._parameters.minimum_n)
            self._read = Sums([self.sums()], MM_PER_M * width_m, lag_s, settings)
        return self._read

    def _adopt(self, geometry: Geometry) -> None:
        """Rest the estimates on a geometry from the first state on that does, not earlier."""
        if self._geometry is None:
            radius_m = geometry.chambers[0].radius_m
            self._search = WallSearch(self._parameters, radius_m, self._settings.search)
        self._geometry = geometry

    def _follow(
        self, state: BodyState, geometry: Geometry, chamber: Chamber
    ) -> tuple[Observables, list[Event]]:
        """Take a frame with a head in the rig."""
        width_m = self._width_m()
        visit = self._position.visit
        threshold_m = self._parameters.contact_factor * width_m
        noise_m = self._search.contact.law.noise_above_bins * threshold_m
        passages = self._position.push(state, geometry, threshold_m, noise_m)
        closed: list[ClosedEpisode] = []
        if self._position.visit != visit:
            closed += self._search.break_off()
        elif self._position.away:
            closed += self._search.enter_exit(state.stamp_ns)
        theta_rad = self._unwrap(state)
        self._position.observe(closed)
        passages = [*self._position.ended_visits(), *passages]
        if not self._position.searching:
            still = _observables(state, theta_rad)
            return still, [*(item.episode for item in closed), *passages]
        head = state.head
        theta_dot, contact, ended = self._search.move(
            chamber.name,
            state.stamp_ns,
            theta_rad,
            radial_distance(head.x_m, head.y_m),
            (head.x_m, head.y_m),
            width_m,
            in_mouth=self._position.in_mouth(theta_rad),
            head_sd_m=state.head_sd_m,
        )
        v_b_m_s = self._search.radius_m * theta_dot
        observables = _observables(state, theta_rad, theta_dot, v_b_m_s, contact)
        self._search.count(observables, width_m)
        self._position.observe(ended)
        closed += ended
        return observables, [*(item.episode for item in closed), *passages]

    def _unwrap(self, state: BodyState) -> float:
        here = (state.frame_id, self._position.visit)
        if here != self._unwrapped_in:
            self._unwrapped.reset()
            self._unwrapped_in = here
        return self._unwrapped.push(polar_angle(state.head.x_m, state.head.y_m))

    def _width_m(self) -> float:
        given = self._parameters.body_width_m
        return self._widths.value() if given is None else given


def _chamber_of(state: BodyState, geometry: Geometry | None) -> Chamber | None:
    """Return the chamber in whose frame the state's coordinates are; None for the camera's."""
    for chamber in geometry.chambers if geometry else ():
        if chamber.name == state.frame_id:
            return chamber
    return None


def _observables(
    state: BodyState,
    theta_rad: float = nan,
    theta_dot_rad_s: float = nan,
    v_b_m_s: float = nan,
    contact: bool | None = None,
) -> Observables:
    """Return a frame's observables; what follows θ needs the past and is given."""
    head, centroid, tail = state.head, state.centroid, state.tail
    x, y = head.x_m, head.y_m
    return Observables(
        state.frame,
        state.stamp_ns,
        state.where,
        radial_distance(x, y),
        radial_distance(centroid.x_m, centroid.y_m),
        radial_distance(tail.x_m, tail.y_m),
        theta_rad,
        body_angle(x, y, centroid.x_m, centroid.y_m),
        head_angle(x, y, head.yaw_rad),
        theta_dot_rad_s,
        v_b_m_s,
        contact,
    )
