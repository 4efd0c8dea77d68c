"""How good forecasts were: calibration, and scores beside those of a memoryless forecast."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import exp, expm1, isfinite, nan, sqrt

import numpy as np
from scipy.special import kolmogorov, stdtrit

from worm_msgs_py.arrays import Floats

Within = Callable[[Floats], Floats]
"""Probability that the head has found the exit within each of these times, s."""
HORIZONS_S = (10.0, 30.0, 60.0)
GOLDEN_SECTION = 0.6180339887498949
RESOLUTION_S = 0.05
"""About a frame: a passage is not known to happen sooner or later than this."""
_SCALES = (0.03, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def crps(within: Within, outcome_s: float, scale_s: float, jumps_s: Sequence[float] = ()) -> float:
    """Return the continuous ranked probability score of a forecast, s; 0 is perfect.

    ∫ (F(t) − 1{t ≥ outcome})² dt over all t ≥ 0 (Gneiting & Raftery, J. Am. Stat. Assoc. 102,
    359, 2007): for a forecast that is one value, the distance from the outcome.

    Parameters
    ----------
    within : callable
        F.
    outcome_s : float
        The time that it took.
    scale_s : float
        About the mean: what F lacks to 1 beyond the outcome and ten times this is left out.
    jumps_s : sequence of float
        Times at which F jumps.
    """
    last_s = outcome_s + _SCALES[-1] * scale_s
    ends = {0.0, outcome_s, *(scale_s * part for part in _SCALES), *jumps_s, last_s}
    edges = np.array(sorted(end for end in ends if 0.0 <= end <= last_s))
    half = np.diff(edges)[:, np.newaxis] / 2.0
    times = edges[:-1, np.newaxis] + half * (1.0 + _NODES)
    missed = within(times.ravel()).reshape(times.shape) - (times > outcome_s)
    return float((half * _WEIGHTS * missed**2).sum())


def crps_exponential(mean_s: float, outcome_s: float) -> float:
    """Return the same score of an exponential law, in closed form."""
    return outcome_s + 2.0 * mean_s * expm1(-outcome_s / mean_s) + mean_s / 2.0


def pit(within: Within, outcome_s: float, share: float) -> float:
    """Return the probability integral transform of an outcome: uniform where forecasts are right.

    Where F jumps within a frame of the outcome, `share` (0 to 1) says how far up the jump.
    """
    around = np.array([max(outcome_s - RESOLUTION_S, 0.0), outcome_s + RESOLUTION_S])
    low, high = (float(value) for value in within(around))
    return low + share * (high - low)


def uniformity(values: Floats) -> float:
    """Return the p-value of the Kolmogorov–Smirnov test that values are uniform in 0 to 1."""
    n = len(values)
    if n == 0:
        return nan
    ordered, rank = np.sort(values), np.arange(1, n + 1)
    apart = float(max(np.max(rank / n - ordered), np.max(ordered - (rank - 1) / n)))
    # Stephens' correction makes the limiting law good from a few values on.
    return float(kolmogorov(apart * (sqrt(n) + 0.12 + 0.11 / sqrt(n))))


@dataclass
class Scores:
    """Running scores of the forecasts made as a search began, one a passage.

    Passages that did not come to their end, or that began before a forecast could be made, are
    not scored but counted.

    Attributes
    ----------
    passages, unscored : int
        Passages with a score, and without.
    """

    passages: int = 0
    unscored: int = 0
    _pit: list[float] = field(default_factory=list)
    _crps_s: list[tuple[float, float]] = field(default_factory=list)
    _brier: list[tuple[float, ...]] = field(default_factory=list)

    def push(
        self, within: Within, outcome_s: float, scale_s: float, jumps_s: Sequence[float] = ()
    ) -> None:
        """Score a forecast.

        Parameters
        ----------
        within : callable
            What was forecast.
        outcome_s : float
            How long it took.
        scale_s : float
            ⟨τ_h⟩ of the same walk from anywhere: the mean of the memoryless forecast, exponential,
            which knows how long a search takes but not where the head is.
        jumps_s : sequence of float
            Times at which what was forecast jumps.
        """
        self.passages += 1
        # Multiples of the golden ratio fill 0 to 1 evenly, and are the same in every run.
        self._pit.append(pit(within, outcome_s, self.passages * GOLDEN_SECTION % 1.0))
        baseline = crps_exponential(scale_s, outcome_s)
        self._crps_s.append((crps(within, outcome_s, scale_s, jumps_s), baseline))
        found = [float(outcome_s <= horizon) for horizon in HORIZONS_S]
        told = within(np.array(HORIZONS_S)).tolist()
        told += [1.0 - exp(-horizon / scale_s) for horizon in HORIZONS_S]
        self._brier.append(
            tuple((p - happened) ** 2 for p, happened in zip(told, found * 2, strict=True))
        )

    def named(self) -> tuple[tuple[str, float], ...]:
        """Return the scores by name with their units; none before the first passage.

        `crps_gain_s` is by how much the forecasts beat the memoryless one, with its 95 % interval
        (Student's); `pit_p` is small where they are not calibrated.
        """
        if not self.passages:
            return ()
        model_s, memoryless_s = np.mean(self._crps_s, axis=0).tolist()
        gain = [baseline - own for own, baseline in self._crps_s]
        half = _half_width_of_mean(np.array(gain))
        mean = memoryless_s - model_s
        brier = np.mean(self._brier, axis=0).tolist()
        values = {
            "passages": float(self.passages),
            "passages_unscored": float(self.unscored),
            "crps_s": model_s,
            "crps_memoryless_s": memoryless_s,
            "crps_gain_s": mean,
            "crps_gain_low_s": mean - half,
            "crps_gain_high_s": mean + half,
            "pit_mean": float(np.mean(self._pit)),
            "pit_p": uniformity(np.array(self._pit)),
        }
        for number, horizon in enumerate(HORIZONS_S):
            values[f"brier_{horizon:.0f}_s"] = brier[number]
            values[f"brier_memoryless_{horizon:.0f}_s"] = brier[number + len(HORIZONS_S)]
        return tuple(values.items())


def _half_width_of_mean(values: Floats) -> float:
    """Half of the 95 % interval of a mean; NaN of fewer than two values."""
    n = len(values)
    if n < 2:
        return nan
    half = float(stdtrit(n - 1, 0.975)) * float(values.std(ddof=1)) / sqrt(n)
    return half if isfinite(half) else nan
