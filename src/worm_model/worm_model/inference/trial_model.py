"""Follows a trial with the boundary walk: fits it, forecasts with it, scores and compares it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from worm_model.boundary_walk.first_passage import FirstPassage
from worm_model.inference.comparison import (
    ModelParameters,
    can_compare,
    compare_with_walk,
    has_exit,
)
from worm_model.inference.escape import EscapeTimes
from worm_model.inference.fit import WalkFit, fit_walk
from worm_model.inference.forecast import Forecaster
from worm_model.inference.reversal_counts import PhaseDirections, Reversals
from worm_model.inference.scores import Scores
from worm_msgs_py import (
    Attempt,
    Comparison,
    Correlation,
    Episode,
    Event,
    Forecast,
    Geometry,
    Observables,
    Quantity,
    Visit,
    Where,
)
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class _Promise:
    """The forecast that a passage is scored by: the first one after its first contact."""

    stamp_ns: int
    where: Where
    law: FirstPassage
    mean_s: float


class TrialModel:
    """The boundary walk beside one trial.

    What it says depends on the order in which it is given things, and on nothing else.

    Parameters
    ----------
    parameters : ModelParameters
        Which walk, and how often it forecasts.
    """

    def __init__(self, parameters: ModelParameters):
        self._parameters = parameters
        self._interval_ns = max(round(parameters.forecast_interval_s * NS_PER_S), 1)
        self._next_ns: int | None = None
        self._geometry: Geometry | None = None
        self._forecaster: Forecaster | None = None
        self._reversals = Reversals()
        self._directions = PhaseDirections()
        self._escapes = EscapeTimes()
        self._scores = Scores()
        self._touched = False
        self._promise: _Promise | None = None
        self._last: tuple[tuple[Quantity, ...], WalkFit, int] | None = None

    def set_geometry(self, geometry: Geometry) -> None:
        """Take a calibration with a chamber: R and h are those of the rig, in each version."""
        if self._geometry is None:
            px_per_m = geometry.chambers[0].px_per_m
            self._reversals.resolution_m = 1.0 / px_per_m if px_per_m > 0.0 else 0.0
        self._geometry = geometry

    def needs_geometry(self, quantities: Sequence[Quantity]) -> bool:
        """Whether a summary has to wait for a calibration."""
        return self._geometry is None and has_exit(quantities)

    def take_state(self, observables: Observables) -> Forecast | None:
        """Take a frame; return a forecast where it is time for one and the exit is known."""
        if observables.where is Where.PASSAGE:
            self._directions.forget()
        elif observables.contact is not None:
            self._directions.see(observables.stamp_ns, observables.theta_h_rad)
            if self._promise is not None and self._promise.where is not observables.where:
                self._start_anew()
            self._touched |= observables.contact
        if not self._is_time(observables.stamp_ns) or self._forecaster is None:
            return None
        forecast, law = self._forecaster(observables)
        if law is not None and self._touched and self._promise is None:
            self._promise = _Promise(
                observables.stamp_ns, observables.where, law, self._forecaster.mean_s
            )
        return forecast

    def take_event(self, event: Event) -> None:
        """Take an event, after the frame at which it closed."""
        if isinstance(event, Episode):
            self._reversals.push(event, self._directions.turn_rad(event))
            return
        self._escapes.push(event)
        if isinstance(event, Visit):
            self._score(event)
        if isinstance(event, Visit | Attempt):
            self._start_anew()

    def take_summary(
        self, quantities: Sequence[Quantity], stamp_ns: int
    ) -> tuple[Comparison, Correlation] | None:
        """Take the analysis' numbers; return the comparison, None where there is nothing yet."""
        if self._geometry is None or not has_exit(quantities):
            return None
        fit = fit_walk(
            quantities,
            self._geometry,
            self._reversals,
            hop_may_land=self._parameters.hop_may_land,
            effective_width=self._parameters.effective_width,
        )
        walk, origins = self._parameters.walk(fit), self._parameters.origins(fit)
        known = self._forecaster
        if known is None or (known.walk, known.measured) != (walk, origins):
            self._forecaster = Forecaster(walk, origins)
        self._last = (tuple(quantities), fit, stamp_ns) if can_compare(quantities) else None
        return self._compare(with_needs=False)

    def finish(self) -> tuple[Comparison, Correlation] | None:
        """Return the last comparison again, with the joint question's answer."""
        return self._compare(with_needs=True)

    def _compare(self, *, with_needs: bool) -> tuple[Comparison, Correlation] | None:
        if self._last is None:
            return None
        return compare_with_walk(
            *self._last,
            self._parameters,
            escapes=self._escapes,
            scores=self._scores.named(),
            with_needs=with_needs,
        )

    def _is_time(self, stamp_ns: int) -> bool:
        if self._next_ns is not None and stamp_ns < self._next_ns:
            return False
        self._next_ns = (stamp_ns // self._interval_ns + 1) * self._interval_ns
        return True

    def _score(self, visit: Visit) -> None:
        """Score the forecast of a passage that has come to its end."""
        if visit.first_contact_ns is None:
            return
        promise = self._promise
        made = (
            promise is not None
            and promise.where.label == visit.chamber
            and visit.first_contact_ns <= promise.stamp_ns < visit.end_ns
        )
        if promise is None or not made or not isfinite(visit.tau_h_s):
            self._scores.unscored += 1
            return
        left_s = (visit.end_ns - promise.stamp_ns) / NS_PER_S
        law, mean_s = promise.law, promise.mean_s
        jumps_s, _ = law.atoms(left_s + mean_s)
        self._scores.push(law.within, left_s, mean_s, jumps_s.tolist())

    def _start_anew(self) -> None:
        """Say that a search has ended: the next contact begins the next one."""
        self._touched, self._promise = False, None
