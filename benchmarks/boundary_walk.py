"""The boundary walk, solved exactly: against the Monte Carlo, and what a number costs.

    python -m benchmarks.boundary_walk [WALKS [SETS]]

For each rule, sets of parameters drawn at random are solved and simulated; a figure (mean, sd and
skips, and the survival function at three times) should lie within three standard errors of the
Monte Carlo, save 0.27 % of them by chance. At equal precision, the time of the Monte Carlo is that
of as many walks as give the mean a standard error of 0.1 %. Processor times, as the machine may be
busy with other work.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from worm_model.boundary_walk.first_passage import FirstPassage, SolvedWalk
from worm_model.boundary_walk.monte_carlo import WalkResult, simulate_walks
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.state import Direction, WalkState

WALKS, SETS = 1_000_000, 50
BATCH = 50_000
FEWER = 100_000, 5
"""Walks and sets where this is one of several benchmarks."""
BARS = {"exact_ms": 5.0, "forecast_ms": 5.0, "ratio": 1e4}
PRECISION = 1e-3
BEYOND_3 = 0.0027
TIMES = 0.25, 1.0, 3.0
"""Times of the survival function, in means."""


def random_parameters(random: np.random.Generator, rule: ReversalRule) -> WalkParameters:
    """Return a walk that a worm might do."""
    return WalkParameters(
        radius_mm=random.uniform(5.0, 15.0),
        exit_width_mm=random.uniform(0.25, 5.0),
        speed_mm_s=random.uniform(1.0, 4.0),
        mean_slide_mm=random.uniform(0.5, 5.0),
        mean_hop_mm=random.uniform(0.5, 5.0),
        reversal=random.uniform(0.02, 0.6),
        rule=rule,
        hop_may_land=bool(random.random() < 0.5),
    )


def many(parameters: WalkParameters, walks: int, seed: int) -> WalkResult:
    """Run walks in batches that stay in the processor's cache."""
    batches = [
        simulate_walks(parameters, min(BATCH, walks - first), seed * 10_000 + first // BATCH)
        for first in range(0, walks, BATCH)
    ]
    return WalkResult(
        np.concatenate([batch.tau_h_s for batch in batches]),
        np.concatenate([batch.skips for batch in batches]),
        np.concatenate([batch.found for batch in batches]),
    )


def deviations(exact: FirstPassage, result: WalkResult) -> dict[str, float]:
    """Return how many standard errors the Monte Carlo's figures lie from the exact ones."""
    n = len(result.tau_h_s)
    tau, sd = result.tau_h_s, float(result.tau_h_s.std())
    fourth = float(((tau - tau.mean()) ** 4).mean())
    error_of_sd = np.sqrt((fourth - sd**4) / n) / (2.0 * sd)
    found = {
        "mean": (tau.mean() - exact.mean_s) / (sd / np.sqrt(n)),
        "sd": (sd - exact.sd_s) / error_of_sd,
        "skips": (result.skips.mean() - exact.skips) / (result.skips.std() / np.sqrt(n)),
    }
    for part in TIMES:
        t_s = part * exact.mean_s
        survival = float(exact.survival(t_s))
        error = np.sqrt(survival * (1.0 - survival) / n)
        found[f"survival at {part:g} means"] = (np.mean(tau > t_s) - survival) / error
    return {name: float(value) for name, value in found.items()}


def best_s(work: Callable[[], object], rounds: int = 50) -> tuple[float, float]:
    """Return the best and the median processor time of some work."""
    times = []
    for _ in range(rounds):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times), float(np.median(times))


def agreement(walks: int, sets: int, console: Console) -> None:
    """Print how many figures lie within three standard errors."""
    random = np.random.default_rng(2303_00647)
    outside: dict[str, int] = {}
    total = 0
    squares = 0.0
    rules = list(ReversalRule)
    for number in track(range(sets * len(rules)), "walks", console=console, transient=True):
        rule = rules[number % len(rules)]
        parameters = random_parameters(random, rule)
        exact = SolvedWalk(parameters).first_passage()
        for name, z in deviations(exact, many(parameters, walks, number)).items():
            outside[name] = outside.get(name, 0) + (abs(z) > 3.0)
            total += 1
            squares += z**2
            if abs(z) > 3.0:
                console.print(f"{name}: {z:+.2f} standard errors; {parameters}")
    table = Table(
        "figure", "outside", title=f"{sets} sets, each rule; {walks} walks; 3 standard errors"
    )
    for name, count in outside.items():
        table.add_row(name, f"{count} of {total // len(outside)}")
    expected = BEYOND_3 * total
    table.add_row("all", f"{sum(outside.values())} of {total}; by chance {expected:.1f}")
    table.add_row("rms deviation", f"{np.sqrt(squares / total):.3f} standard errors")
    console.print(table)


@dataclass(frozen=True, slots=True)
class Costs:
    """Processor times; and the Monte Carlo's over that of the exact mean at equal precision."""

    exact_ms: float
    monte_carlo_s: float
    ratio: float
    forecast_ms: float
    forecast_median_ms: float


def costs() -> Costs:
    """Measure one exact mean, one forecast, and the Monte Carlo beside them in one run."""
    parameters = WalkParameters()
    exact_s, _ = best_s(lambda: SolvedWalk(parameters).first_passage().mean_s)
    times = []
    for seed in range(4):
        begin = time.process_time()
        result = simulate_walks(parameters, BATCH, seed)
        taken = time.process_time() - begin
        error = float(result.tau_h_s.std() / result.tau_h_s.mean()) / np.sqrt(BATCH)
        times.append(taken * (error / PRECISION) ** 2)
    walk = SolvedWalk(parameters)
    random = np.random.default_rng(0)

    def forecast() -> object:
        law = walk.forecast(WalkState(random.uniform(0.2, 2.0 * pi - 0.2), Direction.CLOCKWISE))
        return [law.quantile(p) for p in (0.05, 0.5, 0.95)], law.within([10.0, 30.0, 60.0])

    forecast()
    best, median = best_s(forecast, 200)
    least = float(min(times))
    return Costs(exact_s * 1e3, least, least / exact_s, best * 1e3, median * 1e3)


def main(arguments: list[str] | None = None) -> None:
    """Print both tables."""
    console = Console()
    found = costs()
    table = Table(
        "boundary walk", "", "bar", title="processor time, the best of several rounds, one run"
    )
    table.add_row("one exact mean", f"{found.exact_ms:.2f} ms", f"{BARS['exact_ms']:g} ms")
    table.add_row("Monte Carlo, to 0.1 %", f"{found.monte_carlo_s:.2f} s", "")
    table.add_row("ratio", f"{found.ratio:.0f}", f"{BARS['ratio']:.0f}")
    table.add_row(
        "one forecast: median, 90 % interval, three probabilities",
        f"{found.forecast_ms:.2f} ms (median {found.forecast_median_ms:.2f} ms)",
        f"{BARS['forecast_ms']:g} ms",
    )
    console.print(table)
    walks, sets = FEWER if arguments is None else (WALKS, SETS)
    numbers = [int(argument) for argument in arguments or []]
    agreement(*(numbers + [walks, sets][len(numbers) :]), console)


if __name__ == "__main__":
    main(sys.argv[1:])
