"""What the panels are drawn from: the sums of one trial, or of several that are pooled."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import nan

import numpy as np

from worm_analysis.pooling import Pool, WalkPrediction, trial_sums
from worm_analysis.pooling.estimates import (
    BY_EVENTS,
    BY_TRIALS,
    FEWEST_TRIALS,
    FITS,
    Pooled,
    pooled_quantities,
)
from worm_analysis.report.panel import counted, thousands
from worm_analysis.results import Results
from worm_msgs_py import Correlation, Quantity

BY_TRIALS_TEXT = (
    "Intervals hold 95 % of the results when the trials are drawn again with replacement: they "
    "allow for trials that differ."
)
BY_EVENTS_TEXT = (
    f"Where there are fewer than {FEWEST_TRIALS} trials, intervals rest on events alone, as if all "
    "trials were alike: they are too narrow where trials differ."
)


@dataclass(frozen=True, eq=False)
class Evidence:
    """One trial or several.

    Attributes
    ----------
    pool : Pool or None
        None where there is no chamber.
    quantity : callable
        From a name to the number, of all trials together.
    by_width : tuple of (Pool, mapping of str to Pooled)
        The numbers of each W.
    correlation : Correlation or None
        C_θ(t).
    walks : tuple of WalkPrediction
        What the boundary walk predicts; empty where it was not asked.
    walk_correlation : Correlation or None
        C_θ of the walk with a single trial's parameters.
    several : bool
        Whether n is to be told with the number of trials.
    """

    pool: Pool | None
    quantity: Callable[[str], Quantity]
    by_width: tuple[tuple[Pool, dict[str, Pooled]], ...] = ()
    correlation: Correlation | None = None
    walks: tuple[WalkPrediction, ...] = ()
    walk_correlation: Correlation | None = None
    several: bool = False
    everything: dict[str, Pooled] = field(default_factory=dict)

    def counted(self, number: int, items: str) -> str:
        """Write n: the number of items, after that of the trials where there are several."""
        if not self.several or self.pool is None:
            return counted(number, items)
        return self.counted_in(self.pool, number, items)

    def counted_in(self, part: Pool, number: int, items: str) -> str:
        """Write n of a part of the trials, such as those of one W."""
        if not self.several:
            return counted(number, items)
        trials = len(part.trials)
        word = "trial" if trials == 1 else "trials"
        return f"n\u00a0=\u00a0{thousands(trials)} {word}, {thousands(number)} {items}"

    @property
    def interval_text(self) -> str:
        """How intervals came about, in words; empty for a single trial's report."""
        if not self.several or self.pool is None:
            return ""
        ways = {pooled.by for pooled in self.everything.values()}
        ways |= {pooled.by for _, numbers in self.by_width for pooled in numbers.values()}
        texts = [(BY_TRIALS, BY_TRIALS_TEXT), (BY_EVENTS, BY_EVENTS_TEXT)]
        return " ".join(text for way, text in texts if way in ways)


def of_trial(results: Results) -> Evidence:
    """Return the evidence of one trial: its numbers are those of its summary."""
    if not results.chambers:
        return Evidence(None, results.quantity)
    pool = Pool.of([trial_sums(results)])
    return Evidence(
        pool,
        results.quantity,
        by_width=_by_width(pool),
        correlation=results.correlation,
        walk_correlation=results.model_correlation,
    )


def of_pool(pool: Pool, walks: tuple[WalkPrediction, ...] = ()) -> Evidence:
    """Return the evidence of several trials."""
    numbers = {pooled.quantity.name: pooled for pooled in pooled_quantities(pool)}

    def quantity(name: str) -> Quantity:
        found = numbers.get(name)
        return Quantity(name, None, why="not pooled") if found is None else found.quantity

    return Evidence(
        pool,
        quantity,
        by_width=_by_width(pool),
        correlation=_correlation(pool, quantity("t_per").value),
        walks=walks,
        several=True,
        everything=numbers,
    )


def _by_width(pool: Pool) -> tuple[tuple[Pool, dict[str, Pooled]], ...]:
    return tuple(
        (part, {pooled.quantity.name: pooled for pooled in pooled_quantities(part)})
        for part in pool.by_width
    )


def _correlation(pool: Pool, t_per_s: float | None) -> Correlation | None:
    """Return C_θ over all pairs of all trials, its error from drawing the trials again."""
    if not pool.lags_agree:
        return None
    lag_s = pool.trials[0].lag_s
    products, pairs = np.split(pool.total("c_theta"), 2)
    c = np.divide(products, pairs, out=np.full(len(pairs), nan), where=pairs > 0)
    error = np.full(len(c), nan)
    if len(pool.trials) >= FEWEST_TRIALS:
        above, below = np.split(pool.resampled("c_theta", FITS), 2, axis=1)
        drawn = np.divide(above, below, out=np.full(above.shape, nan), where=below > 0)
        known = np.isfinite(drawn).all(axis=0)
        error[known] = drawn[:, known].std(axis=0)
    model = np.full(len(c), nan) if t_per_s is None else np.exp(-lag_s / t_per_s)
    return Correlation(lag_s, c, error, np.rint(pairs).astype(np.int64), model)
