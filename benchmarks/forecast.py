"""Forecasts: whether they are calibrated, what they gain over a memoryless one, and their cost.

Worms are simulated by Monte Carlo from random states on the wall; each is forecast from its state
with the exact law. The baselines are exponential: one with ⟨τ_h⟩, which knows how long a search
takes but not where the head is, and one with the mean of the very forecast, which lacks its shape
alone.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits

from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.inference.forecast import Forecaster
from worm_model.inference.scores import HORIZONS_S, Scores, crps_exponential

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from simulated_passages import observables, passages

STATES, WALKS = 200, 10
ROUNDS = 200
CASES = {
    "the paper's, W = 1 mm": WalkParameters(),
    "t_per = 27 s, W = 1 mm": replace(WalkParameters(), reversal=0.031),
    "per phase 0.45, W = 5 mm": replace(
        WalkParameters(), rule=ReversalRule.PER_PHASE, reversal=0.45, exit_width_mm=5.0
    ),
}


def score(walk: WalkParameters) -> dict[str, float]:
    """Return the scores of 2000 forecasts, and how many outcomes lay in their 90 % intervals."""
    scores, inside, own_mean = Scores(), 0, []
    mean_s = Forecaster(walk, ()).mean_s
    for forecast, law, times_s in passages(walk, STATES, WALKS, seed=1):
        for time_s in times_s:
            scores.push(law.within, time_s, mean_s, law.atoms(time_s)[0].tolist())
            own_mean.append(crps_exponential(law.mean_s, time_s))
        # A quantile may be a time that has a probability of its own.
        inside += int(
            np.count_nonzero((times_s > forecast.low_s - 1e-3) & (times_s < forecast.high_s + 1e-3))
        )
    shares = {"inside": inside / (STATES * WALKS), "crps_own_mean_s": float(np.mean(own_mean))}
    return dict(scores.named()) | shares


def seconds_a_forecast(walk: WalkParameters) -> tuple[float, float]:
    """Return the median time of a forecast and that of fitting a new walk, s of this processor."""
    random = np.random.default_rng(0)
    frames = [
        observables(
            random.uniform(0.3, 6.0), random.choice([-1.0, 1.0]), bool(random.random() < 0.5)
        )
        for _ in range(ROUNDS)
    ]
    made = []
    for _ in range(5):
        begin = time.process_time()
        forecaster = Forecaster(walk, ())
        forecaster(frames[0])
        made.append(time.process_time() - begin)
    spent = []
    for frame in frames:
        begin = time.process_time()
        forecaster(frame)
        spent.append(time.process_time() - begin)
    return float(np.median(spent)), float(np.median(made))


def main() -> None:
    """Print both tables."""
    calibration = Table("", *CASES, title=f"{STATES * WALKS} passages of simulated worms")
    cost = Table("", *CASES, title="processor time")
    with threadpool_limits(1):
        found = [score(walk) for walk in CASES.values()]
        spent = [seconds_a_forecast(walk) for walk in CASES.values()]
    rows = [
        ("PIT, mean (0.5)", "pit_mean", "{:.3f}"),
        ("PIT uniform, p", "pit_p", "{:.2f}"),
        ("in the 90 % interval", "inside", "{:.3f}"),
        ("CRPS, s", "crps_s", "{:.2f}"),
        ("CRPS of Exp(⟨τ_h⟩), s", "crps_memoryless_s", "{:.2f}"),
        ("gain, s", "crps_gain_s", "{:.2f}"),
        ("gain, from", "crps_gain_low_s", "{:.2f}"),
        ("gain, to", "crps_gain_high_s", "{:.2f}"),
        ("CRPS of Exp(its own mean), s", "crps_own_mean_s", "{:.2f}"),
    ]
    for horizon in HORIZONS_S:
        rows += [
            (f"Brier at {horizon:.0f} s", f"brier_{horizon:.0f}_s", "{:.4f}"),
            ("  of Exp(⟨τ_h⟩)", f"brier_memoryless_{horizon:.0f}_s", "{:.4f}"),
        ]
    for text, name, form in rows:
        calibration.add_row(text, *(form.format(case[name]) for case in found))
    cost.add_row("a forecast", *(f"{one * 1e3:.2f} ms" for one, _ in spent))
    cost.add_row("a new walk and its first forecast", *(f"{new * 1e3:.1f} ms" for _, new in spent))
    console = Console()
    console.print(calibration)
    console.print(cost)


if __name__ == "__main__":
    main()
