"""Which observations one reversal can hold together, read from the reversals that each needs."""

from collections.abc import Sequence
from dataclasses import dataclass

from worm_msgs_py.contract.model import NeededReversal

_TOUCH = 1e-6
"""Intervals that touch have a value in common, whatever rounding says."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """What a walk under one rule, at one speed, can hold together.

    Attributes
    ----------
    rule, speed : str
        As in `NeededReversal`.
    low, high : float
        The reversals that hold `held` together; probability, or 1/s.
    held, left : tuple of str
        The largest set of observations that have a reversal in common, and the others.
    """

    rule: str
    speed: str
    low: float
    high: float
    held: tuple[str, ...]
    left: tuple[str, ...]

    @property
    def holds_all(self) -> bool:
        """Whether one reversal gives every observation."""
        return not self.left

    def in_words(self) -> str:
        """Return the answer as a sentence without its full stop, with the names as they are."""
        rate = self.rule == "rate"
        kind = "a rate of reversals" if rate else f"reversals {self.rule.replace('_', ' ')}"
        case = f"{kind} at {self.speed}"
        if not self.held:
            return f"{case}: no reversal gives any of {', '.join(self.left)}"
        low, high = (f"{end:.2g}" for end in (self.low, self.high))
        unit = "/s" if rate else ""
        most = f"{low}{unit} or more" if high == "inf" else f"{low} to {high}{unit}"
        most = f"{low}{unit}" if low == high else most
        text = f"{case}: {most} gives {', '.join(self.held)}"
        return text if self.holds_all else f"{text}, but not {', '.join(self.left)}"


def agreements(needs: Sequence[NeededReversal]) -> tuple[Agreement, ...]:
    """Return the largest agreement for each rule and speed, in the order in which they come.

    Of several equally large sets the one at the lowest reversal is returned. An observation that
    no reversal gives is in none.
    """
    cases = dict.fromkeys((need.rule, need.speed) for need in needs)
    return tuple(
        _largest_agreement([need for need in needs if (need.rule, need.speed) == case])
        for case in cases
    )


def _largest_agreement(needs: Sequence[NeededReversal]) -> Agreement:
    best: list[NeededReversal] = []
    for place in sorted(need.low for need in needs if need.low == need.low):
        here = [
            n for n in needs if n.low <= place * (1.0 + _TOUCH) and place <= n.high * (1.0 + _TOUCH)
        ]
        best = here if len(here) > len(best) else best
    held = tuple(need.observation for need in best)
    return Agreement(
        needs[0].rule,
        needs[0].speed,
        max((need.low for need in best), default=float("nan")),
        min((need.high for need in best), default=float("nan")),
        held,
        tuple(need.observation for need in needs if need.observation not in held),
    )
