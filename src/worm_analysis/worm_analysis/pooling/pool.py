"""Trials together: their sums added up, resampled by trial, and grouped by exit width."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import floor, isfinite, log10

import numpy as np
from numpy.typing import NDArray

from worm_analysis.pooling.trial_sums import TrialSums
from worm_analysis.results import Floats, ReportError

PAPER_WIDTHS_MM = (0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
SAME_EXIT = 0.15
SAME_RADIUS = 0.01
RESAMPLES = 1000


def group_width_mm(exit_width_mm: float) -> float:
    """Return the width by which a trial is grouped.

    A calibration gives W to a pixel, so a width within 15 % of one of the paper's is taken for it;
    any other is rounded to two digits. NaN where W is not known.
    """
    if not (isfinite(exit_width_mm) and exit_width_mm > 0):
        return float("nan")
    nearest = min(PAPER_WIDTHS_MM, key=lambda width: abs(width - exit_width_mm))
    if abs(nearest - exit_width_mm) <= SAME_EXIT * nearest:
        return nearest
    return round(exit_width_mm, 1 - floor(log10(exit_width_mm)))


@dataclass(frozen=True, eq=False)
class Pool:
    """Trials that are taken together.

    Attributes
    ----------
    trials : tuple of TrialSums
        At least one, all of one R.
    width_mm : float
        W of all of them; NaN for a pool of several widths, or of none that is known.
    """

    trials: tuple[TrialSums, ...]
    width_mm: float = float("nan")

    @classmethod
    def of(cls, trials: Iterable[TrialSums]) -> "Pool":
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
        widths = {group_width_mm(trial.exit_width_mm) for trial in found}
        return cls(found, widths.pop() if len(widths) == 1 else float("nan"))

    @cached_property
    def by_width(self) -> tuple["Pool", ...]:
        """A pool for each W, ascending; trials whose W is not known are in none."""
        groups: dict[float, list[TrialSums]] = {}
        for trial in self.trials:
            groups.setdefault(group_width_mm(trial.exit_width_mm), []).append(trial)
        return tuple(Pool(tuple(groups[w]), w) for w in sorted(groups) if isfinite(w))

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

    def total(self, name: str) -> Floats:
        """Return the sum over trials; empty where no trial has it."""
        rows = self._rows(name)
        return rows.sum(axis=0) if len(rows) else np.empty(0)

    def events(self, name: str) -> Floats:
        """Return the values of all trials' events, one after the other."""
        return np.concatenate([trial.events[name] for trial in self.trials])

    def resampled(self, name: str, resamples: int = RESAMPLES) -> Floats:
        """Return the sums of samples of trials drawn with replacement, shape (resamples, k)."""
        rows = self._rows(name)
        return np.asarray(self._draws(resamples, len(rows)) @ rows)

    def _rows(self, name: str) -> Floats:
        found = [trial.sums[name] for trial in self.trials if name in trial.sums]
        return np.array(found) if found else np.empty((0, 0))

    @staticmethod
    def _draws(resamples: int, trials: int) -> NDArray[np.float64]:
        """Return how often each trial is drawn; the same for every sum."""
        random = np.random.default_rng(0)
        return random.multinomial(trials, np.full(trials, 1 / trials), resamples).astype(float)


def _refuse_twins(trials: Sequence[TrialSums]) -> None:
    """Refuse a trial that is there twice: it would count for two."""
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
