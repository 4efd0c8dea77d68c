"""What the panels are drawn from: the sums of one trial, or of several that are pooled."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from worm_analysis.pooling import Pool, Pooled, WalkPrediction, pooled_trial
from worm_analysis.pooling.pool import BY_TRIALS, WITHIN_TRIALS
from worm_analysis.report.panel import counted, number_of
from worm_analysis.results import Results
from worm_analysis.statistics.block_jackknife import JACKKNIFE
from worm_analysis.summary.direction_persistence import correlation
from worm_msgs_py import Comparison, Correlation, Quantity

BY_TRIALS_TEXT = (
    "95 % intervals come from leaving out blocks of time and whole trials in turn: they allow for "
    "trials that differ."
)
WITHIN_TRIALS_TEXT = (
    f"Where there are fewer than {JACKKNIFE.fewest_trials} trials, intervals rest on blocks of "
    "time and on the items alone, as if all trials were alike: they are too narrow where trials "
    "differ."
)


@dataclass(frozen=True, eq=False)
class ReportData:
    """One trial or several, as the panels show them.

    Attributes
    ----------
    pool : Pool or None
        None where there is no chamber.
    quantity : callable
        From a name to the number, of all trials together.
    correlation : Correlation or None
        C_θ(t).
    walks : tuple of WalkPrediction
        What the boundary walk predicts; empty where it was not asked.
    comparisons : mapping of float to Comparison
        The walk beside the trials of each W.
    walk_correlation : Correlation or None
        C_θ of the walk with a single trial's parameters.
    several : bool
        Whether n is to be told with the number of trials.
    """

    pool: Pool | None
    quantity: Callable[[str], Quantity]
    correlation: Correlation | None = None
    walks: tuple[WalkPrediction, ...] = ()
    comparisons: Mapping[float, Comparison] = field(default_factory=dict)
    walk_correlation: Correlation | None = None
    several: bool = False

    @property
    def by_width(self) -> list[tuple[Pool, dict[str, Pooled]]]:
        """The trials of each W, and their numbers."""
        return [(part, part.numbers) for part in self.pool.by_width] if self.pool else []

    def counted(self, number: int, items: str) -> str:
        """Write n: the number of items, after that of the trials where there are several."""
        if not self.several or self.pool is None:
            return counted(number, items)
        return self.counted_in(self.pool, number, items)

    def counted_in(self, part: Pool, number: int, items: str) -> str:
        """Write n of a part of the trials, such as those of one W."""
        if not self.several:
            return counted(number, items)
        return f"{counted(len(part.trials), 'trials')}, {number_of(number, items)}"

    @property
    def interval_text(self) -> str:
        """How intervals came about, in words; empty for a single trial's report."""
        if not self.several or self.pool is None:
            return ""
        parts = (self.pool, *self.pool.by_width)
        ways = {pooled.by for part in parts for pooled in part.numbers.values()}
        texts = [(BY_TRIALS, BY_TRIALS_TEXT), (WITHIN_TRIALS, WITHIN_TRIALS_TEXT)]
        return " ".join(text for way, text in texts if way in ways)


def of_trial(results: Results) -> ReportData:
    """Return what is data of one trial: its numbers are those of its summary."""
    if not results.chambers:
        return ReportData(None, results.quantity)
    return ReportData(
        Pool.of([pooled_trial(results)]),
        results.quantity,
        correlation=results.correlation,
        walk_correlation=results.model_correlation,
    )


def of_pool(
    pool: Pool,
    walks: tuple[WalkPrediction, ...] = (),
    comparisons: Mapping[float, Comparison] | None = None,
) -> ReportData:
    """Return what is data of several trials."""

    def quantity(name: str) -> Quantity:
        found = pool.numbers.get(name)
        return Quantity(name, None, why="not pooled") if found is None else found.quantity

    sums = pool.sums
    c_theta = None
    if sums.has("c_theta"):
        c_theta = correlation(
            sums.units("c_theta"), sums.lag_s, quantity("t_per").value, sums.settings
        )
    return ReportData(pool, quantity, correlation=c_theta, walks=walks,
                      comparisons=comparisons or {}, several=True)  # fmt: skip
