"""The boundary walk fitted to a trial: each parameter with its interval, and where it is from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import isfinite, radians, sin, sqrt

from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.inference.reversal_counts import Reversals
from worm_msgs_py import Geometry, Quantity
from worm_msgs_py.intervals import NOTHING, Interval
from worm_msgs_py.paper import BODY_ANGLE_DEG
from worm_msgs_py.units import MM_PER_M

FEWEST_PHASE_CHANGES = 10
"""Fewer changes of phase than this are not enough to count reversals."""
_DEFAULTS = WalkParameters()
CYCLE_MM = _DEFAULTS.mean_slide_mm + _DEFAULTS.mean_hop_mm


class Speed(StrEnum):
    """Which speed the walk has; the paper does not say."""

    TANGENTIAL = "v_b"
    """The mean speed along the wall, v_w sin ψ_b."""
    SWIMMING = "v_w"
    """v_w of v_b = v_w sin ψ_b."""


REVERSAL_NAMES = {
    ReversalRule.PER_CYCLE: "reversal_per_cycle",
    ReversalRule.PER_PHASE: "reversal_per_phase",
    ReversalRule.RATE: "reversal_rate",
}
PAPER_NUMBERS = {
    "d_c": _DEFAULTS.mean_slide_mm,
    "d_nc": _DEFAULTS.mean_hop_mm,
    "v_w": _DEFAULTS.speed_mm_s,
    "v_b": _DEFAULTS.speed_mm_s * sin(radians(BODY_ANGLE_DEG)),
    "reversal_per_cycle": _DEFAULTS.reversal,
    "reversal_per_phase": _DEFAULTS.reversal,
    "reversal_rate": _DEFAULTS.reversal / (CYCLE_MM / _DEFAULTS.speed_mm_s),
}
"""mm, mm/s, 1 and 1/s. The paper counts reversals in no stated unit: "30 % of the times"."""
LOWEST = dict.fromkeys(("d_c", "d_nc", "v_w", "v_b"), 1e-3)
"""A walk that stands still has no law."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """One parameter of the walk.

    Attributes
    ----------
    value, low, high : float
        Value and 95 % interval; the paper's values have none (NaN).
    is_measured : bool
        Whether it is the trial's own, or the paper's.
    """

    value: float
    low: float
    high: float
    is_measured: bool


@dataclass(frozen=True, slots=True)
class WalkFit:
    """A walk fitted to a trial, under every rule and speed.

    Attributes
    ----------
    radius_mm, exit_width_mm, depth_mm : float
        R, W and h.
    numbers : mapping of str to Fitted
        ``d_c``, ``d_nc`` (mm), ``v_w``, ``v_b`` (mm/s), ``reversal_per_cycle``,
        ``reversal_per_phase`` (1), ``reversal_rate`` (1/s).
    hop_may_land, effective_width : bool
        See `WalkParameters`.
    """

    radius_mm: float
    exit_width_mm: float
    depth_mm: float
    numbers: Mapping[str, Fitted]
    hop_may_land: bool = True
    effective_width: bool = True

    def names(self, rule: ReversalRule, speed: Speed) -> tuple[str, ...]:
        """Return the names of the numbers that a walk under this rule and speed uses."""
        return "d_c", "d_nc", speed.value, REVERSAL_NAMES[rule]

    def walk(
        self, rule: ReversalRule, speed: Speed, changed: Mapping[str, float] | None = None
    ) -> WalkParameters:
        """Return the walk under a rule and a speed.

        Parameters
        ----------
        rule, speed
            Which of the numbers it has.
        changed : mapping, optional
            Numbers to use in place of the fitted ones, by name.
        """
        names = self.names(rule, speed)
        values = {name: self.numbers[name].value for name in names} | dict(changed or {})
        return WalkParameters(
            radius_mm=self.radius_mm,
            exit_width_mm=self.exit_width_mm,
            depth_mm=self.depth_mm,
            speed_mm_s=values[speed.value],
            mean_slide_mm=values["d_c"],
            mean_hop_mm=values["d_nc"],
            reversal=values[REVERSAL_NAMES[rule]],
            rule=rule,
            hop_may_land=self.hop_may_land,
            effective_width=self.effective_width,
        )

    def origins(self, rule: ReversalRule, speed: Speed) -> tuple[tuple[str, bool], ...]:
        """Return of each number that this walk uses whether it is the trial's own."""
        return tuple((name, self.numbers[name].is_measured) for name in self.names(rule, speed))


def fit_walk(
    quantities: Sequence[Quantity],
    geometry: Geometry,
    reversals: Reversals | None = None,
    *,
    hop_may_land: bool = True,
    effective_width: bool = True,
    fewest_phase_changes: int = FEWEST_PHASE_CHANGES,
) -> WalkFit:
    """Fit the walk to what a trial measured; the paper stands in for what it did not.

    ⟨d_c⟩ and ⟨d_nc⟩ are the analysis' maximum-likelihood means, with what was cut short censored
    and the resolution's limit allowed for. Slides, hops and reversals are independent in the walk,
    so each is fitted by itself.

    Parameters
    ----------
    quantities : sequence of Quantity
        The trial's summary, with ``w_s``.
    geometry : Geometry
        For R and h; it must have a chamber.
    reversals : Reversals, optional
        Counted from phase to phase. Without, or with fewer than `fewest_phase_changes`, the rule
        `per_phase` turns around as often in a cycle as was measured for cycles.
    hop_may_land, effective_width : bool
        See `WalkParameters`.
    """
    found = {quantity.name: quantity for quantity in quantities}
    numbers = {name: _fitted(interval_of(found, name), name) for name in PAPER_NUMBERS}
    if reversals is not None and reversals.changes >= fewest_phase_changes:
        numbers["reversal_per_phase"] = _fitted(reversals.per_phase(), "reversal_per_phase")
    else:
        per_cycle = interval_of(found, "reversal_per_cycle")
        numbers["reversal_per_phase"] = _fitted(_halved(per_cycle), "reversal_per_phase")
    depth_mm = geometry.depth_m * MM_PER_M
    w_s = interval_of(found, "w_s")[0]
    return WalkFit(
        radius_mm=geometry.chambers[0].radius_m * MM_PER_M,
        exit_width_mm=sqrt(max(w_s**2 - depth_mm**2, 0.0)),
        depth_mm=depth_mm,
        numbers=numbers,
        hop_may_land=hop_may_land,
        effective_width=effective_width,
    )


def interval_of(found: Mapping[str, Quantity], name: str) -> Interval:
    """Return a quantity's value and interval; NaN for what there is not."""
    quantity = found.get(name)
    if quantity is None or quantity.value is None:
        return NOTHING
    low, high = (float("nan") if end is None else end for end in (quantity.low, quantity.high))
    return quantity.value, low, high


def _fitted(measured: Interval, name: str) -> Fitted:
    lowest = LOWEST.get(name, 0.0)
    if not (isfinite(measured[0]) and measured[0] >= lowest):
        nan = float("nan")
        return Fitted(PAPER_NUMBERS[name], nan, nan, is_measured=False)
    value, low, high = measured
    return Fitted(value, max(low, lowest), high, is_measured=True)


def _halved(per_cycle: Interval) -> Interval:
    """Return the chance per phase of which two a cycle turn around as often: 2q(1 − q) = r."""
    value, low, high = ((1.0 - sqrt(max(1.0 - 2.0 * chance, 0.0))) / 2.0 for chance in per_cycle)
    return value, low, high
