"""Runs the boundary walk with a trial's own parameters and holds it against the measurement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from worm_model.boundary_walk import (
    Estimate,
    ReversalRule,
    WalkParameters,
    WalkResult,
    simulate,
)
from worm_model.persistence import direction_correlation, persistence_time_s
from worm_msgs_py import Comparison, Correlation, Geometry, ModelQuantity, Quantity

TRIAL_S = 1800.0
"""Time to which the paper relates n_s."""
MM_PER_M = 1e3
_DEFAULTS = WalkParameters()


@dataclass(frozen=True, slots=True)
class ModelParameters:
    """How the walk is run.

    Attributes
    ----------
    walks : int
        Number of walks of the Monte Carlo.
    seed : int
        Its seed: the same measurement gives the same numbers.
    rule : str
        What a measured reversal counts: ``per_cycle``, ``per_phase`` or ``rate``
        (`boundary_walk.ReversalRule`); the trial gives it for ``per_cycle`` and ``rate``.
    hop_may_land, effective_width : bool
        See `boundary_walk.WalkParameters`.
    longest_lag_s, lag_step_s : float
        Lags of C_θ.

    Raises
    ------
    ValueError
        Where a number makes no sense.
    """

    walks: int = 2000
    seed: int = 0
    rule: str = ReversalRule.PER_CYCLE.value
    hop_may_land: bool = True
    effective_width: bool = True
    longest_lag_s: float = 60.0
    lag_step_s: float = 0.5

    def __post_init__(self) -> None:
        if self.walks < 2:
            raise ValueError(f"walks is {self.walks}; at least 2 are needed")
        if self.seed < 0:
            raise ValueError(f"seed is {self.seed}; it must not be below 0")
        if self.rule not in list(ReversalRule):
            raise ValueError(f"rule is {self.rule!r}; known: {', '.join(ReversalRule)}")
        if not 0.0 < self.lag_step_s <= self.longest_lag_s:
            raise ValueError("lag_step_s must be above 0 and not above longest_lag_s")

    @property
    def lag_s(self) -> NDArray[np.float64]:
        """The lags of C_θ, from 0."""
        count = round(self.longest_lag_s / self.lag_step_s) + 1
        return np.arange(count, dtype=np.float64) * self.lag_step_s


def can_compare(quantities: Sequence[Quantity]) -> bool:
    """Tell whether a trial has what a walk needs: an exit, and one parameter of its own."""
    values = {quantity.name: quantity.value for quantity in quantities}
    own = ("d_c", "d_nc", "v_b", "reversal_per_cycle", "reversal_rate")
    return values.get("w_s") is not None and any(values.get(name) is not None for name in own)


def compare(
    quantities: Sequence[Quantity], geometry: Geometry, stamp_ns: int, parameters: ModelParameters
) -> tuple[Comparison, Correlation]:
    """Run the walk with the measured parameters and hold it against the measurement.

    Parameters
    ----------
    quantities : sequence of Quantity
        The trial's summary; `can_compare` must hold.
    geometry : Geometry
        For R and h; it must have a chamber.
    stamp_ns : int
        Stamp of the last frame that the summary rests on.
    parameters : ModelParameters
        How the walk is run.

    Returns
    -------
    comparison : Comparison
        Its parameters say of each measured one, as ``NAME_is_measured``, whether it is the trial's
        own (1) or, where the trial has none, the paper's (0).
    correlation : Correlation
        The walk's C_θ, which is exact: no error, no pairs.
    """
    found = {quantity.name: quantity for quantity in quantities}
    walk, measured = walk_of_trial(found, geometry, parameters)
    result = simulate(walk, parameters.walks, parameters.seed)
    comparison = Comparison(
        stamp_ns=stamp_ns,
        parameters=_parameters(walk, measured, parameters),
        quantities=_quantities(found, walk, result),
    )
    lag_s = parameters.lag_s
    c = direction_correlation(walk, lag_s)
    none = np.zeros(len(lag_s), dtype=np.int64)
    return comparison, Correlation(lag_s, c, np.zeros(len(lag_s)), none, c)


def walk_of_trial(
    found: Mapping[str, Quantity], geometry: Geometry, parameters: ModelParameters
) -> tuple[WalkParameters, dict[str, bool]]:
    """Return the walk of a trial, and which of its parameters the trial gave itself."""
    rule = ReversalRule(parameters.rule)
    reversal_name = "reversal_rate" if rule is ReversalRule.RATE else "reversal_per_cycle"
    reversal = _DEFAULTS.reversal
    if rule is ReversalRule.RATE:
        cycle_s = (_DEFAULTS.mean_slide_mm + _DEFAULTS.mean_hop_mm) / _DEFAULTS.speed_mm_s
        reversal /= cycle_s
    paper = {
        "d_c": _DEFAULTS.mean_slide_mm,
        "d_nc": _DEFAULTS.mean_hop_mm,
        "v_b": _DEFAULTS.speed_mm_s,
        reversal_name: reversal,
    }
    own = {name: _value(found, name) for name in paper}
    if rule is ReversalRule.PER_PHASE and isfinite(own[reversal_name]):
        # Two chances a cycle turn the worm around as often as the one that was measured.
        own[reversal_name] = 0.5 * (1.0 - sqrt(max(1.0 - 2.0 * own[reversal_name], 0.0)))
    lowest = {"d_c": 1e-3, "d_nc": 1e-3, "v_b": 1e-3, reversal_name: 0.0}
    measured = {name: isfinite(own[name]) and own[name] >= lowest[name] for name in paper}
    used = {name: own[name] if measured[name] else paper[name] for name in paper}
    depth_mm = geometry.depth_m * MM_PER_M
    w_s = _value(found, "w_s")
    walk = WalkParameters(
        radius_mm=geometry.chambers[0].radius_m * MM_PER_M,
        exit_width_mm=sqrt(max(w_s**2 - depth_mm**2, 0.0)),
        depth_mm=depth_mm,
        speed_mm_s=used["v_b"],
        mean_slide_mm=used["d_c"],
        mean_hop_mm=used["d_nc"],
        reversal=used[reversal_name],
        rule=rule,
        hop_may_land=parameters.hop_may_land,
        effective_width=parameters.effective_width,
    )
    return walk, measured


def _parameters(
    walk: WalkParameters, measured: Mapping[str, bool], parameters: ModelParameters
) -> tuple[tuple[str, float], ...]:
    rules = list(ReversalRule)
    values = {
        "R_m": walk.radius_mm / MM_PER_M,
        "W_m": walk.exit_width_mm / MM_PER_M,
        "h_m": walk.depth_mm / MM_PER_M,
        "exit_arc_m": walk.exit_arc_mm / MM_PER_M,
        "v_m_s": walk.speed_mm_s / MM_PER_M,
        "mean_slide_m": walk.mean_slide_mm / MM_PER_M,
        "mean_hop_m": walk.mean_hop_mm / MM_PER_M,
        "reversal": walk.reversal,
        **{f"rule_{rule.value}": float(rule is walk.rule) for rule in rules},
        "hop_may_land": float(walk.hop_may_land),
        "effective_width": float(walk.effective_width),
        "walks": float(parameters.walks),
        "seed": float(parameters.seed),
        **{f"{name}_is_measured": float(is_own) for name, is_own in measured.items()},
    }
    return tuple(values.items())


def _quantities(
    found: Mapping[str, Quantity], walk: WalkParameters, result: WalkResult
) -> tuple[ModelQuantity, ...]:
    tau, skips = result.mean_tau_h_s(), result.skips_per_second()
    if not result.found.all():  # then the mean is but a lower bound
        tau = Estimate(nan, nan, nan)
    modelled = {
        "tau_h": ("s", 1.0, (tau.value, tau.low, tau.high)),
        "n_s": (
            f"per {TRIAL_S / 60:.0f} min",
            1.0,
            (TRIAL_S * skips.value, TRIAL_S * skips.low, TRIAL_S * skips.high),
        ),
        "d_c": ("m", MM_PER_M, (walk.mean_slide_mm / MM_PER_M, nan, nan)),
        "d_nc": ("m", MM_PER_M, (walk.mean_hop_mm / MM_PER_M, nan, nan)),
        "t_per": ("s", 1.0, (persistence_time_s(walk), nan, nan)),
    }
    return tuple(
        ModelQuantity(name, unit, *_measured(found.get(name), scale), *numbers)
        for name, (unit, scale, numbers) in modelled.items()
    )


def _measured(quantity: Quantity | None, scale: float) -> tuple[float, float, float]:
    if quantity is None:
        return nan, nan, nan
    value, low, high = (
        nan if number is None else number / scale
        for number in (quantity.value, quantity.low, quantity.high)
    )
    return value, low, high


def _value(found: Mapping[str, Quantity], name: str) -> float:
    quantity = found.get(name)
    return nan if quantity is None or quantity.value is None else quantity.value
