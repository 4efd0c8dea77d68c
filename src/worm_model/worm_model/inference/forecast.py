"""When the head will find the exit, given where it is and which way it goes now."""

from dataclasses import replace
from math import copysign, isfinite, nan, pi, remainder

from worm_model.boundary_walk.fast_first_passage import FastFirstPassage
from worm_model.boundary_walk.first_passage import FirstPassage, SolvedWalk
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState
from worm_model.inference.scores import HORIZONS_S
from worm_msgs_py import Forecast, Observables, Where

QUANTILES = (0.05, 0.5, 0.95)
_CHAMBERS = (Where.CHAMBER_A, Where.CHAMBER_B)


class Forecaster:
    """Makes forecasts with one walk.

    Parameters
    ----------
    walk : WalkParameters
        The walk, fitted to the trial so far.
    measured : tuple of (str, bool)
        Of each of its numbers, whether it is the trial's own.
    """

    def __init__(self, walk: WalkParameters, measured: tuple[tuple[str, bool], ...]):
        self._solved = SolvedWalk(walk)
        self._fast_law = FastFirstPassage(self._solved, HORIZONS_S[-1])
        self._measured = measured
        self.mean_s = self._solved.first_passage().mean_s

    @property
    def walk(self) -> WalkParameters:
        """The walk that it forecasts with."""
        return self._solved.parameters

    @property
    def measured(self) -> tuple[tuple[str, bool], ...]:
        """Of each of its numbers, whether it is the trial's own."""
        return self._measured

    def __call__(self, observables: Observables) -> tuple[Forecast, FirstPassage | None]:
        """Return the forecast of a frame, and the exact law of the time that is left.

        There is none (NaN, None) where the head is not in a chamber, or in its exit, or where its
        direction or its contact cannot be told.
        """
        direction = direction_of(observables)
        contact = nan if observables.contact is None else float(observables.contact)
        forecast = Forecast(
            observables.frame,
            observables.stamp_ns,
            observables.where,
            observables.theta_h_rad,
            direction,
            contact,
            measured=self._measured,
        )
        state = self.state(observables.theta_h_rad, direction, contact)
        if observables.where not in _CHAMBERS or state is None:
            return forecast, None
        (low, median, high), within = self._fast_law(state, QUANTILES, HORIZONS_S)
        told = replace(
            forecast,
            median_s=median,
            low_s=low,
            high_s=high,
            within_10_s=within[0],
            within_30_s=within[1],
            within_60_s=within[2],
        )
        return told, self._solved.forecast(state)

    def state(self, theta_rad: float, direction: float, contact: float) -> WalkState | None:
        """Return the state of the walk; None where something of it is not known.

        A head that slides within the exit's arc has found it, says the walk; but w_s is wider than
        W. It is taken to be at the nearest edge of the arc.
        """
        if not (isfinite(theta_rad) and isfinite(direction) and isfinite(contact)):
            return None
        walk = self.walk
        edge_rad = walk.exit_edge_rad
        theta = remainder(theta_rad, 2.0 * pi)
        if contact and abs(theta) < edge_rad:
            theta = copysign(edge_rad, theta)
        return WalkState(
            theta,
            Direction.COUNTER_CLOCKWISE if direction > 0.0 else Direction.CLOCKWISE,
            Phase.SLIDE if contact else Phase.HOP,
        )


def direction_of(observables: Observables) -> float:
    """Return the direction along the wall: 1 counter-clockwise, −1 clockwise, NaN if unknown.

    That of θ̇_h; where it is not known yet, that in which the body points, as v_b = v_w sin ψ_b.
    """
    for value in (observables.theta_dot_rad_s, observables.psi_b_rad):
        if isfinite(value) and value != 0.0:
            return copysign(1.0, value)
    return nan
