"""The joint question: which reversal each observation needs, and so which can hold together.

The paper's reversals, its persistence of direction and its times to the exit cannot all be had from
one boundary walk. Here each observation alone is turned into the reversal that the exact walk
would need to give it, under every rule and at either speed; where the intervals do not meet, the
walk cannot hold these observations together (`worm_msgs_py.contract.agreement`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, isfinite, nan

import numpy as np
from scipy.optimize import brentq

from worm_model.boundary_walk.direction_correlation import persistence_time_s
from worm_model.boundary_walk.mean_passage import mean_again_s, mean_tau_h_s, skips_per_trial
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.inference.escape import escape_time
from worm_model.inference.fit import PAPER_NUMBERS, REVERSAL_NAMES, Speed, WalkFit, interval_of
from worm_msgs_py import NeededReversal, Quantity, paper
from worm_msgs_py.intervals import Interval

# Dense near 1: there, where phases alternate, ⟨τ_h⟩ has a maximum. A walk that turns at every
# change of phase keeps direction times phase for ever, so the last one is just below.
_PROBABILITIES = np.r_[np.geomspace(1e-4, 0.2, 8), np.linspace(0.3, 1.0 - 1e-9, 8)]
_RATES_S = np.geomspace(1e-5, 30.0, 20)
_TOLERANCE = 1e-9

Observable = Callable[[WalkParameters], float]


def paper_escape_ratio(walk: WalkParameters) -> float:
    """Return the mean time of an escape in units of ⟨τ_h⟩, with the paper's success rate."""
    success = (paper.SUCCESS, nan, nan)
    return escape_time(mean_tau_h_s(walk), mean_again_s(walk), success).ratio[0]


OBSERVABLES: Mapping[str, Observable] = {
    "t_per": persistence_time_s,
    "tau_h": mean_tau_h_s,
    "n_s": skips_per_trial,
    "escape_ratio": paper_escape_ratio,
}
"""What a walk says of each observation; the units are those of the summary."""
OF_TRIAL = ("t_per", "tau_h", "n_s")


@dataclass(frozen=True, slots=True)
class ObservedQuantity:
    """One observation that the walk should give.

    Attributes
    ----------
    name : str
        As the report calls it.
    interval : (float, float, float)
        Value and 95 % interval; an end may be infinite.
    observable : str
        Which of `OBSERVABLES` it is; empty for a counted reversal.
    is_measured : bool
        Whether it is the trial's own.
    """

    name: str
    interval: Interval
    observable: str = ""
    is_measured: bool = True


def needed_reversals(
    walk: WalkParameters, speed: Speed, observations: Sequence[ObservedQuantity]
) -> tuple[NeededReversal, ...]:
    """Return the reversal that each observation needs, for one rule and one speed.

    Parameters
    ----------
    walk : WalkParameters
        Everything but the reversal, which is passed over.
    speed : Speed
        Which speed `walk` has.
    observations : sequence of ObservedQuantity
        A counted reversal needs itself.
    """
    grid = _RATES_S if walk.rule is ReversalRule.RATE else _PROBABILITIES
    curves: dict[str, list[float]] = {}
    found = []
    for item in observations:
        needed = item.interval
        if item.observable:
            observe = _of_reversal(walk, OBSERVABLES[item.observable])
            if item.observable not in curves:
                curves[item.observable] = [observe(float(reversal)) for reversal in grid]
            needed = invert(observe, curves[item.observable], grid.tolist(), item.interval)
            if needed[2] >= grid[-1]:
                needed = (*needed[:2], inf if walk.rule is ReversalRule.RATE else 1.0)
        found.append(
            NeededReversal(
                walk.rule.value, speed.value, item.name, *needed, is_measured=item.is_measured
            )
        )
    return tuple(found)


def invert(
    observe: Callable[[float], float], curve: Sequence[float], grid: Sequence[float], goal: Interval
) -> Interval:
    """Return the reversals at which a function has a value, and values in an interval.

    Parameters
    ----------
    observe : callable
        The function; it is taken to have no turning point between two places of the grid.
    curve, grid : sequence of float
        Its values at reversals that ascend. Below the first one it is taken to be constant.
    goal : (float, float, float)
        The value and the interval that it should have.

    Returns
    -------
    (float, float, float)
        NaN where the function nowhere has the value, or nowhere one in the interval. Where it has
        it in several places: the first one, and the interval around it.
    """
    value, low, high = goal
    first = next(iter(_crossings(observe, curve, grid, value)), nan)
    ends = [*_crossings(observe, curve, grid, low), *_crossings(observe, curve, grid, high)]
    places = [0.0, *sorted(ends), grid[-1]]
    inside = [
        (left, right)
        for left, right in pairwise(places)
        if left < right and low <= observe((left + right) / 2.0) <= high
    ]
    here = [branch for branch in inside if branch[0] <= first <= branch[1]]
    return (first, *next(iter(here or inside), (nan, nan)))


def trial_observations(
    found: Mapping[str, Quantity], fit: WalkFit, rule: ReversalRule
) -> list[ObservedQuantity]:
    """Return what a trial observed: counted reversals, t_per, ⟨τ_h⟩ and n_s, as far as it did.

    What has no interval is left out: nothing could be said to agree with it.
    """
    counted = fit.numbers[REVERSAL_NAMES[rule]]
    items = [ObservedQuantity("reversal", (counted.value, counted.low, counted.high))]
    items = items if counted.is_measured else []
    items += [ObservedQuantity(name, interval_of(found, name), name) for name in OF_TRIAL]
    return [item for item in items if all(map(isfinite, item.interval))]


def trial_needs(found: Mapping[str, Quantity], fit: WalkFit) -> tuple[NeededReversal, ...]:
    """Answer the joint question for a trial, under every rule and at either speed."""
    return tuple(
        need
        for speed in (Speed.SWIMMING, Speed.TANGENTIAL)
        if fit.numbers[speed.value].is_measured
        for rule in ReversalRule
        for need in needed_reversals(
            fit.walk(rule, speed), speed, trial_observations(found, fit, rule)
        )
    )


def paper_needs(exit_width_mm: float = 1.0) -> tuple[NeededReversal, ...]:
    """Answer the joint question for the paper's own numbers.

    Its times and skips are given in figures alone. By its text and the caption of Fig. 6 they are
    those of its simulation at v_w with reversals of 35 to 55 %, whatever rule that had: so they
    are computed with each rule in turn.

    Parameters
    ----------
    exit_width_mm : float
        W.
    """
    needs: list[NeededReversal] = []
    for speed in (Speed.SWIMMING, Speed.TANGENTIAL):
        for rule in ReversalRule:
            walk = WalkParameters(
                exit_width_mm=exit_width_mm,
                speed_mm_s=PAPER_NUMBERS[speed.value],
                reversal=PAPER_NUMBERS[REVERSAL_NAMES[rule]],
                rule=rule,
            )
            simulated = replace(walk, speed_mm_s=PAPER_NUMBERS["v_w"])
            needs += needed_reversals(walk, speed, _paper_observations(simulated))
    return tuple(needs)


def _paper_observations(simulated: WalkParameters) -> list[ObservedQuantity]:
    rate = simulated.rule is ReversalRule.RATE
    cycle_mm = simulated.mean_slide_mm + simulated.mean_hop_mm
    unit = simulated.speed_mm_s / cycle_mm if rate else 1.0
    text, figure = (
        tuple(chance * unit for chance in stated)
        for stated in (paper.REVERSAL, paper.REVERSAL_OF_FIG_6)
    )

    def drawn(observable: str) -> Interval:
        value, *ends = (
            OBSERVABLES[observable](replace(simulated, reversal=chance)) for chance in figure
        )
        return value, min(ends), max(ends)

    def of_paper(name: str, interval: Sequence[float], observable: str = "") -> ObservedQuantity:
        value, low, high = interval
        return ObservedQuantity(name, (value, low, high), observable, is_measured=False)

    return [
        of_paper("reversal", text),
        of_paper("reversal_fig_6", figure),
        of_paper("t_per", paper.T_PER_S, "t_per"),
        of_paper("tau_h_text", paper.TAU_H_OF_THE_TEXT_S, "tau_h"),
        of_paper("tau_h", drawn("tau_h"), "tau_h"),
        of_paper("n_s", drawn("n_s"), "n_s"),
        of_paper("escape_ratio", paper.ESCAPE_RATIO, "escape_ratio"),
    ]


def _of_reversal(walk: WalkParameters, observable: Observable) -> Callable[[float], float]:
    return lambda reversal: observable(replace(walk, reversal=reversal))


def _crossings(
    observe: Callable[[float], float], curve: Sequence[float], grid: Sequence[float], level: float
) -> list[float]:
    if not isfinite(level):
        return []
    above = [number - level for number in curve]
    found = [place for place, number in zip(grid, above, strict=True) if number == 0.0]
    for index in range(len(grid) - 1):
        if above[index] * above[index + 1] < 0.0:
            root = brentq(
                lambda reversal: observe(reversal) - level,
                grid[index], grid[index + 1], xtol=_TOLERANCE, rtol=_TOLERANCE,
            )  # fmt: skip
            found.append(float(root))
    return sorted(found)
