"""Trials together: their sums added up, their numbers, and the groups by exit width."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, nan

import numpy as np

from worm_analysis.pooling.pooled_trial import PooledTrial
from worm_analysis.statistics.heterogeneity import same_number_p
from worm_analysis.summary.definition import Definition
from worm_analysis.summary.quantities import DEFINITIONS, definitions
from worm_analysis.summary.settings import DEFAULTS, EstimateSettings
from worm_analysis.summary.sums import Sums, TrialSums
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.paper import SAME_WIDTH

PIXEL_MM = 0.03
"""Exits whose widths differ by no more are one exit, however narrow: a pixel or so."""
SAME_RADIUS = 0.01
"""Chambers whose radii differ by less than this part are of one size."""
RULE = "advance_at_"
"""What the names of the sums under another rule of contact begin with, before its label."""
BY_TRIALS, WITHIN_TRIALS, NO_INTERVAL = "trials", "within trials", ""


@dataclass(frozen=True, slots=True)
class Pooled:
    """A number of a pool.

    Attributes
    ----------
    quantity : Quantity
        `n` counts episodes, visits, attempts or frames.
    trials : int
        Trials that it rests on.
    by : str
        What the interval comes from: ``trials``, left out in turn as blocks of time are; ``within
        trials``, blocks of time and items alone, where there are fewer than five trials; or
        nothing.
    """

    quantity: Quantity
    trials: int
    by: str = NO_INTERVAL


def group_widths_mm(exit_widths_mm: Sequence[float]) -> list[float]:
    """Return, for each trial, the mean W of the trials that are taken to have the same exit.

    A calibration gives W to a pixel, so trials whose widths differ by no more than 8 % (or a
    pixel or so) are of one exit. NaN where W is not known.
    """
    groups: list[list[float]] = []
    for width_mm in sorted(width for width in exit_widths_mm if isfinite(width) and width > 0):
        if not groups or width_mm - groups[-1][0] > max(SAME_WIDTH * width_mm, PIXEL_MM):
            groups.append([])
        groups[-1].append(width_mm)
    mean_of = {width: round(float(np.mean(group)), 3) for group in groups for width in group}
    return [mean_of.get(width, nan) for width in exit_widths_mm]


@dataclass(frozen=True, eq=False)
class Pool:
    """Trials that are taken together.

    Attributes
    ----------
    trials : tuple of PooledTrial
        At least one, all of one R.
    width_mm : float
        W of all of them, the mean one; NaN for a pool of several widths, or of none that is known.
    settings : EstimateSettings
        How numbers follow from the sums; `minimum_n` is the largest of the trials'.
    """

    trials: tuple[PooledTrial, ...]
    width_mm: float = float("nan")
    settings: EstimateSettings = DEFAULTS

    @classmethod
    def of(cls, trials: Iterable[PooledTrial]) -> "Pool":
        """Return the pool of all trials.

        Raises
        ------
        ReportError
            Where two of them were made in chambers of different radii, or are the same trial.
        """
        found = tuple(trials)
        first = found[0]
        for trial in found[1:]:
            if abs(trial.radius_mm - first.radius_mm) > SAME_RADIUS * first.radius_mm:
                raise ReportError(
                    f"{trial.directory}: its chamber has R = {trial.radius_mm:.4g} mm, that of "
                    f"{first.directory} {first.radius_mm:.4g} mm: pool trials of one radius"
                )
        _refuse_twins(found)
        widths = set(group_widths_mm([trial.exit_width_mm for trial in found]))
        return cls(found, widths.pop() if len(widths) == 1 else float("nan"))

    @cached_property
    def by_width(self) -> tuple["Pool", ...]:
        """A pool for each W, ascending; trials whose W is not known are in none."""
        groups: dict[float, list[PooledTrial]] = {}
        for trial, width_mm in zip(self.trials, self.widths_mm, strict=True):
            groups.setdefault(width_mm, []).append(trial)
        known = filter(isfinite, sorted(groups))
        return tuple(Pool(tuple(groups[w]), w, self.settings) for w in known)

    @property
    def widths_mm(self) -> list[float]:
        """The W that each trial is grouped by: the mean one of its group."""
        return group_widths_mm([trial.exit_width_mm for trial in self.trials])

    @property
    def radius_mm(self) -> float:
        """R."""
        return self.trials[0].radius_mm

    @property
    def lags_agree(self) -> bool:
        """Whether all trials have C_θ at the same lags, so that it can be added up."""
        lags = [trial.lag_s for trial in self.trials]
        same = all(len(lag) == len(lags[0]) and np.allclose(lag, lags[0]) for lag in lags)
        return len(lags[0]) > 1 and same

    @cached_property
    def sums(self) -> Sums:
        """The sums of all trials; those of C_θ only where all have it at the same lags."""
        trials: list[TrialSums] = [trial.sums for trial in self.trials]
        if not self.lags_agree:
            trials = [{k: v for k, v in sums.items() if k != "c_theta"} for sums in trials]
        most_n = max(trial.minimum_n for trial in self.trials)
        settings = replace(self.settings, minimum_n=most_n)
        return Sums(trials, self.width_mm, self.trials[0].lag_s, settings)

    @cached_property
    def numbers(self) -> dict[str, Pooled]:
        """Every number by name; one that cannot be had has a reason."""
        return {item.name: self._number(item) for item in definitions(self.rules)}

    @property
    def rules(self) -> list[str]:
        """The labels of the other rules of contact that all trials have sums under."""
        return [
            name.removeprefix(RULE)
            for name in self.trials[0].sums
            if name.startswith(RULE) and all(name in trial.sums for trial in self.trials)
        ]

    def _number(self, definition: Definition) -> Pooled:
        name = definition.sums
        try:
            quantity = definition.of(self.sums)
        except (ValueError, IndexError) as error:  # sums of other columns than today's
            where = ", ".join(filter(None, (trial.directory for trial in self.trials[:3])))
            raise ReportError(
                f"{where or 'these results'}: sums of another version ({name}: {error}): "
                f"{RUN_AGAIN}"
            ) from error
        way = NO_INTERVAL
        if quantity.low is not None or quantity.high is not None:
            way = BY_TRIALS if self.sums.resamples_trials(name) else WITHIN_TRIALS
        return Pooled(quantity, self.sums.trials_with(name), way)

    def same_in_all_p(self, name: str) -> float:
        """Return the probability that the trials' own values differ so much by chance alone.

        NaN where fewer than two trials have a value with an interval.
        """
        own = [
            DEFINITIONS[name].of(Sums([trial.sums], nan, trial.lag_s, self.sums.settings))
            for trial in self.trials
        ]
        return same_number_p(
            [
                (q.value, q.low, q.high)
                for q in own
                if q.value is not None and q.low is not None and q.high is not None
            ]
        )

    def total(self, name: str) -> Floats:
        """Return the sums over all trials; empty where no trial has them."""
        return self.sums.total(name) if self.sums.has(name) else np.empty(0)

    def count(self, name: str, column: int = 0) -> int:
        """Return one of the sums, which is a number of items; 0 where no trial has them."""
        return round(self.total(name)[column]) if self.sums.has(name) else 0

    def points(self, name: str) -> Floats:
        """Return the values of all trials' episodes, visits or frames, one after the other."""
        return np.concatenate([trial.points[name] for trial in self.trials])

    def pairs(self, name: str) -> Floats:
        """Return the points that all trials saved with their sums, shape (n, 2)."""
        saved = [trial.sums[name] for trial in self.trials if name in trial.sums]
        pairs: Floats = np.concatenate([np.empty((0, 2)), *saved])
        return pairs


def _refuse_twins(trials: Sequence[PooledTrial]) -> None:
    """Refuse a trial that is there twice: it would be counted twice."""
    known: dict[str, str] = {}
    for trial in trials:
        source = trial.provenance.get("source") or {}
        if not source.get("sha256"):
            continue
        key = repr(sorted(source.items(), key=str))
        if key in known:
            raise ReportError(
                f"{trial.directory}: is the same trial as {known[key]} ({trial.name}): leave one "
                "out"
            )
        known[key] = trial.directory
