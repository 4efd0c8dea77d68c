"""Holds the exact boundary walk, fitted to a trial, against what the trial measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from worm_model.boundary_walk.direction_correlation import direction_correlation, persistence_time_s
from worm_model.boundary_walk.mean_passage import (
    mean_again_s,
    mean_tau_h_s,
    skips_per_trial,
)
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.inference.escape import EscapeTimes, escape_time
from worm_model.inference.fit import LOWEST, REVERSAL_NAMES, Speed, WalkFit, interval_of
from worm_model.inference.required_reversal import trial_needs
from worm_msgs_py import Comparison, Correlation, ModelQuantity, Quantity
from worm_msgs_py.declarations import declare, first_refusal_of
from worm_msgs_py.errors import BadInput
from worm_msgs_py.intervals import NOTHING, Interval
from worm_msgs_py.limits import Limit
from worm_msgs_py.paper import SUCCESS, TRIAL_S
from worm_msgs_py.units import MM_PER_M

_MODEL_SPAN = Limit(1e-3, 86_400.0, "s")
MOST_MODEL_LAGS = 10_000
PER_TRIAL = f"per {TRIAL_S / 60:.0f} min"


@dataclass(frozen=True, slots=True)
class ModelParameters:
    """Which boundary walk is run, and how often it forecasts.

    Raises
    ------
    BadInput
        Where a number makes no sense.
    """

    rule: str = declare(
        ReversalRule.PER_CYCLE.value,
        "What a reversal counts (boundary_walk.ReversalRule).",
        choices=tuple(ReversalRule),
    )
    speed: str = declare(
        Speed.TANGENTIAL.value,
        "The walk's speed: v_b, the mean speed along the wall, or v_w.",
        choices=tuple(Speed),
    )
    hop_may_land: bool = declare(True, "Whether a hop that ends above the exit finds it.")
    effective_width: bool = declare(True, "Whether the exit is √(W² + h²) wide.")
    longest_lag_s: float = declare(60.0, "Longest lag of the walk's C_θ(t).", _MODEL_SPAN)
    lag_step_s: float = declare(0.5, "Step of the lags.", _MODEL_SPAN)
    forecast_interval_s: float = declare(
        0.1, "Time of the frames' stamps between two forecasts.", _MODEL_SPAN
    )

    def __post_init__(self) -> None:
        wrong = first_refusal_of(self)
        if wrong:
            raise BadInput(wrong)
        if not self.longest_lag_s / MOST_MODEL_LAGS <= self.lag_step_s <= self.longest_lag_s:
            raise BadInput(
                f"lag_step_s is {self.lag_step_s:g}: give at most longest_lag_s, "
                f"{self.longest_lag_s:g} s, and at least a {MOST_MODEL_LAGS}th of it"
            )

    @property
    def lag_s(self) -> NDArray[np.float64]:
        """The lags of C_θ, from 0."""
        count = round(self.longest_lag_s / self.lag_step_s) + 1
        return np.arange(count, dtype=np.float64) * self.lag_step_s

    def walk(self, fit: WalkFit, changed: Mapping[str, float] | None = None) -> WalkParameters:
        """Return the walk that these parameters choose of a fit."""
        return fit.walk(ReversalRule(self.rule), Speed(self.speed), changed)

    def origins(self, fit: WalkFit) -> tuple[tuple[str, bool], ...]:
        """Return of each number that this walk uses whether it is the trial's own."""
        return fit.origins(ReversalRule(self.rule), Speed(self.speed))


def has_exit(quantities: Sequence[Quantity]) -> bool:
    """Tell whether a trial has an exit to be found: without, no walk can be fitted."""
    return any(q.name == "w_s" and q.value is not None for q in quantities)


def can_compare(quantities: Sequence[Quantity]) -> bool:
    """Tell whether a trial has what a comparison needs: an exit, and one number of its own."""
    own = ("d_c", "d_nc", "v_b", "v_w", "reversal_per_cycle", "reversal_rate")
    return has_exit(quantities) and any(q.name in own and q.value is not None for q in quantities)


def compare_with_walk(
    quantities: Sequence[Quantity],
    fit: WalkFit,
    stamp_ns: int,
    parameters: ModelParameters,
    *,
    escapes: EscapeTimes | None = None,
    scores: tuple[tuple[str, float], ...] = (),
    with_needs: bool = False,
) -> tuple[Comparison, Correlation]:
    """Hold the fitted walk against the measurement.

    Parameters
    ----------
    quantities : sequence of Quantity
        The trial's summary; `can_compare` must hold.
    fit : WalkFit
        The walk that was fitted to it.
    stamp_ns : int
        That of the summary's last frame.
    parameters : ModelParameters
    escapes : EscapeTimes, optional
    scores : tuple of (str, float)
    with_needs : bool
        Whether to answer the joint question too (`required_reversal`), in a third of a second.

    Returns
    -------
    comparison : Comparison
        ``NAME_is_measured`` says of each number of the walk whether it is the trial's own (1) or,
        where the trial has none, the paper's (0); its interval gives that of what is modelled.
    correlation : Correlation
        The walk's C_θ, exact: no error, no pairs.
    """
    found = {quantity.name: quantity for quantity in quantities}
    comparison = Comparison(
        stamp_ns=stamp_ns,
        parameters=_parameters(found, fit, parameters),
        quantities=(
            *_predicted(found, fit, parameters),
            *_escapes(found, fit, parameters, escapes or EscapeTimes(), stamp_ns),
            *_given(found, fit, parameters),
        ),
        needs=trial_needs(found, fit) if with_needs else (),
        scores=scores,
    )
    c = direction_correlation(parameters.walk(fit), parameters.lag_s)
    return comparison, Correlation(
        parameters.lag_s, c, np.zeros_like(c), np.zeros(len(c), np.int64), c
    )


def _parameters(
    found: Mapping[str, Quantity], fit: WalkFit, parameters: ModelParameters
) -> tuple[tuple[str, float], ...]:
    walk = parameters.walk(fit)
    success = interval_of(found, "success")[0]
    values = {
        "R_m": walk.radius_mm / MM_PER_M,
        "W_m": walk.exit_width_mm / MM_PER_M,
        "h_m": walk.depth_mm / MM_PER_M,
        "exit_arc_m": walk.exit_arc_mm / MM_PER_M,
        "v_m_s": walk.speed_mm_s / MM_PER_M,
        "mean_slide_m": walk.mean_slide_mm / MM_PER_M,
        "mean_hop_m": walk.mean_hop_mm / MM_PER_M,
        "reversal": walk.reversal,
        **{f"rule_{rule.value}": float(rule is walk.rule) for rule in ReversalRule},
        "hop_may_land": float(walk.hop_may_land),
        "effective_width": float(walk.effective_width),
        "success": success if isfinite(success) else SUCCESS,
        **{f"{name}_is_measured": float(is_own) for name, is_own in parameters.origins(fit)},
        "success_is_measured": float(isfinite(success)),
    }
    return tuple(values.items())


def _predicted(
    found: Mapping[str, Quantity], fit: WalkFit, parameters: ModelParameters
) -> list[ModelQuantity]:
    """Return what follows from the walk's numbers: ⟨τ_h⟩, skips, t_per."""
    predictions: tuple[tuple[str, str, Callable[[WalkParameters], float]], ...] = (
        ("tau_h", "s", mean_tau_h_s),
        ("n_s", PER_TRIAL, skips_per_trial),
        ("t_per", "s", persistence_time_s),
    )
    return [
        ModelQuantity(name, unit, *interval_of(found, name), *propagated(fit, parameters, predict))
        for name, unit, predict in predictions
    ]


def propagated(
    fit: WalkFit, parameters: ModelParameters, predict: Callable[[WalkParameters], float]
) -> Interval:
    """Return a prediction, and the interval that the fitted numbers' own intervals give it.

    Each number is moved to the ends of its interval while the others stay; the changes add up in
    squares, as the numbers come from different episodes. NaN where no number has an interval.
    """
    value = predict(parameters.walk(fit))
    down = up = 0.0
    for name, _ in parameters.origins(fit):
        number = fit.numbers[name]
        changes = [
            predict(parameters.walk(fit, {name: max(end, LOWEST.get(name, 0.0))})) - value
            for end in (number.low, number.high)
            if isfinite(end)
        ]
        down += min([0.0, *changes]) ** 2
        up += max([0.0, *changes]) ** 2
    if not (isfinite(value) and (down or up)):
        return value, nan, nan
    return value, max(value - sqrt(down), 0.0), value + sqrt(up)


def _escapes(
    found: Mapping[str, Quantity],
    fit: WalkFit,
    parameters: ModelParameters,
    escapes: EscapeTimes,
    now_ns: int,
) -> list[ModelQuantity]:
    """Return the time of an escape, and in units of ⟨τ_h⟩; intervals from the success rate's."""
    walk = parameters.walk(fit)
    success = interval_of(found, "success")
    if not isfinite(success[0]):
        success = (SUCCESS, nan, nan)
    modelled = escape_time(mean_tau_h_s(walk), mean_again_s(walk), success, escapes.lost_s)
    measured = escapes.mean_s(now_ns)
    ratio = measured[0] / interval_of(found, "tau_h")[0]
    return [
        ModelQuantity("tau_escape", "s", *measured, *modelled.mean_s),
        ModelQuantity("escape_ratio", "1", ratio, nan, nan, *modelled.ratio),
    ]


def _given(
    found: Mapping[str, Quantity], fit: WalkFit, parameters: ModelParameters
) -> list[ModelQuantity]:
    """Return the walk's own numbers: what it was given cannot disagree."""
    rows = []
    for name, is_own in parameters.origins(fit):
        number = fit.numbers[name]
        unit, scale = ("1/s" if name == REVERSAL_NAMES[ReversalRule.RATE] else "1"), 1.0
        if name in LOWEST:
            unit, scale = ("m/s" if name in list(Speed) else "m"), MM_PER_M
        measured = (number.value, number.low, number.high) if is_own else NOTHING
        value, low, high = (end / scale for end in measured)
        rows.append(ModelQuantity(name, unit, value, low, high, number.value / scale, nan, nan))
    return rows
