"""Sums by name, of one trial or of several: all that a number rests on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from worm_analysis.statistics.block_jackknife import Units, Value
from worm_analysis.summary.settings import DEFAULTS, EstimateSettings
from worm_msgs_py.arrays import Floats

TrialSums = Mapping[str, Floats]
"""Sums of one trial by name: a row a block of time (or one row), SI, the number of items first."""


@dataclass(frozen=True, eq=False, slots=True)
class Sums:
    """What several trials add up to.

    Attributes
    ----------
    trials : sequence of mapping
        The sums of each trial; what a trial cannot have is missing.
    exit_width_mm : float
        W of all of them, for the paper's values; NaN where it is not known or not the same.
    lag_s : ndarray, shape (k,)
        Lags of C_θ, the same in all trials; empty where they differ.
    settings : EstimateSettings
        How numbers follow from the sums.
    """

    trials: Sequence[TrialSums]
    exit_width_mm: float = nan
    lag_s: Floats = field(default_factory=lambda: np.empty(0))
    settings: EstimateSettings = DEFAULTS
    _units: dict[str, Units] = field(default_factory=dict, init=False, repr=False)
    _found: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def has(self, name: str) -> bool:
        """Whether a trial has these sums."""
        return any(name in trial for trial in self.trials)

    def units(self, name: str) -> Units:
        """Return the parts that can be left out; KeyError where no trial has them."""
        found = self._units.get(name)
        if found is None:
            if not self.has(name):
                raise KeyError(name)
            found = self.units_of([trial[name] for trial in self.trials if name in trial])
            self._units[name] = found  # several numbers rest on the same sums
        return found

    def units_of(self, trials: Sequence[Floats]) -> Units:
        """Return the parts of sums that were made of these, such as some columns of them."""
        return Units(trials, self.settings.jackknife)

    def once(self, name: str, find: Callable[[], Value]) -> Value:
        """Return what follows from the sums and several numbers need, found the first time."""
        if name not in self._found:
            self._found[name] = find()
        found: Value = self._found[name]
        return found

    def total(self, name: str) -> Floats:
        """Return the sums over all trials, shape (k,); KeyError where no trial has them."""
        return self.units(name).total()

    def trials_with(self, name: str) -> int:
        """Return how many trials have something to add."""
        return sum(bool(trial[name].any()) for trial in self.trials if name in trial)

    def resamples_trials(self, name: str) -> bool:
        """Whether intervals allow for trials that differ."""
        return self.trials_with(name) >= self.settings.jackknife.fewest_trials
