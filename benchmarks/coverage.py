"""How often a 95 % interval holds the truth: many trials of a worm whose laws are known.

Each seed is one trial of `known_worm`, analysed as any other. The truth is a parameter of the worm
where the measured quantity is one; where it is defined by the track (τ_h, C_θ, t_per, …) it
comes from a far longer life of the same worm, event by event and by plain array arithmetic. C_θ is
that within visits, as it is measured: visits of a worm that goes straight on are short, so it falls
faster than that of a walk without an exit. And t_per is what the fit gives with no end of data,
beside the walk's own 1/(2 × rate of reversal).

The bar is 90 % of 200 seeds. The interval of the fraction itself is Clopper and Pearson's.
"""

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import nan

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.stats import binomtest

from benchmarks.known_worm import (
    Camera,
    Emergence,
    KnownWorm,
    Search,
    Try,
    film,
    life,
    paper_rule,
)
from worm_analysis.accumulators.direction_correlation import SignCorrelation, lag_grid
from worm_analysis.analysis import Analysis
from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.direction_persistence import (
    correlation_curve,
    fit_decay_time,
    persistence_time,
)

Floats = NDArray[np.float64]
Answer = dict[str, tuple[float, float, float]]

LAGS_S = (1.0, 5.0, 20.0, 60.0, 100.0)
CELL_S = 0.1
TRUTH_S = 2.0e6
TRUTH_SEED = (1, 2, 3)
NORMAL = 1.96
GOOD = 0.90
LAWS = ("d_c_exponential_p", "d_nc_exponential_p", "delta_r_h_exponential_p")


def answer(
    worm: KnownWorm, camera: Camera | None, hours: float, rate_hz: float, seed: int
) -> Answer:
    """Return value, low and high of everything that one trial gives."""
    analysis = Analysis()
    analysis.set_geometry(worm.geometry)
    for state in film(worm, seed, 3600 * hours, rate_hz, camera):
        analysis.push(state)
    analysis.finish()
    found = {
        quantity.name: (
            quantity.value,
            nan if quantity.low is None else quantity.low,
            nan if quantity.high is None else quantity.high,
        )
        for quantity in analysis.summary()
        if quantity.value is not None
    }
    curve = analysis.correlation()
    for lag_s in LAGS_S:
        at = int(np.argmin(np.abs(curve.lag_s - lag_s)))
        c, half = float(curve.c[at]), NORMAL * float(curve.error[at])
        found[f"C_theta({lag_s:.0f} s)"] = (c, c - half, c + half)
    return found


def truths(worm: KnownWorm) -> dict[str, float]:
    """Return what each quantity should be."""
    rule = paper_rule(worm, TRUTH_SEED, TRUTH_S)
    found = {
        "d_c": rule.d_c * 1e3,
        "d_nc": rule.d_nc * 1e3,
        "delta_r_h": rule.delta_r_h * 1e3,
        "v_b": worm.speed * 1e3,
        "v_w": worm.speed / np.sin(worm.lean) * 1e3,
        "reversal_per_cycle": rule.reversal,
        "psi_b_positive_peak": float(np.degrees(worm.lean)),
        "psi_b_negative_peak": -float(np.degrees(worm.lean)),
        "success": worm.success,
        "failures_without_contact": 1 - worm.touching,
        "failures_in_elongation": worm.elongating,
        "failures_touching_in_elongation": worm.touching * worm.elongating,
        "beta": worm.beta * 1e-3,
        "const": worm.even / worm.deepest * 1e-3,
        "alpha": (1 - worm.even) * worm.beta / -np.expm1(-worm.beta * worm.deepest) * 1e-3,
    }
    return found | _truths_of_a_long_life(worm)


def _truths_of_a_long_life(worm: KnownWorm) -> dict[str, float]:
    cells = round(max(120.0, *LAGS_S) / CELL_S)
    products, pairs = np.zeros(cells + 1), np.zeros(cells + 1)
    sums = dict.fromkeys(("turns", "directed", "contact", "time", "skips"), 0.0)
    moments = np.zeros((2, 2))
    tau: list[float] = []
    rng = np.random.default_rng(TRUTH_SEED)
    first_t = nan
    for event in life(worm, TRUTH_SEED, TRUTH_S):
        if isinstance(event, Try):
            if first_t == first_t:
                tau.append(event.start - first_t)
            first_t = nan
            continue
        if isinstance(event, Emergence):
            continue
        if event.first:
            first_t = float(event.t[0])
        _add_search(worm, event, rng, sums, moments)
        _add_pairs(_directions(event), products, pairs)
    lag = np.arange(cells + 1)
    c = products / pairs
    grid = lag_grid(120.0, 10.0, CELL_S, 1.0)
    found = {f"C_theta({lag_s:.0f} s)": float(c[round(lag_s / CELL_S)]) for lag_s in LAGS_S}
    return found | {
        "t_per": fit_decay_time(lag[grid] * CELL_S, c[grid], pairs[grid].astype(np.int64)),
        "tau_h": float(np.mean(tau)),
        "n_s": 1800 * sums["skips"] / sums["time"],
        "reversal_rate": sums["turns"] / sums["directed"],
        "contact_fraction": sums["contact"] / sums["time"],
        "theta_dot_psi_b_correlation": float(
            moments[0, 1] / np.sqrt(moments[0, 0] * moments[1, 1])
        ),
    }


def _sampled(search: Search) -> tuple[Floats, Floats, Floats]:
    """Return times, θ and θ̇ over the last second, every cell; without the first second."""
    t = np.arange(search.t[0] + 1.0, search.t[-1], CELL_S)
    theta = np.interp(t, search.t, search.theta)
    return t, theta, theta - np.interp(t - 1.0, search.t, search.theta)


def _directions(search: Search) -> Floats:
    return np.sign(_sampled(search)[2])


def _add_search(
    worm: KnownWorm,
    search: Search,
    rng: np.random.Generator,
    sums: dict[str, float],
    moments: Floats,
) -> None:
    t, _, speed = _sampled(search)
    sign = np.sign(speed)
    turns = sign[1:] != sign[:-1]
    spent = np.diff(search.t)
    sums["turns"] += int(turns.sum())
    sums["directed"] += CELL_S * len(turns)
    sums["contact"] += float(spent[::2].sum())
    sums["time"] += float(spent.sum())
    sums["skips"] += search.skips
    phase = np.clip(np.searchsorted(search.t, t, side="right") - 1, 0, len(search.depth) - 1)
    heading = np.sign(np.diff(search.theta))[phase]
    sway = worm.sway * (np.sin(2 * np.pi * t / 12) + rng.normal(0, 1, len(t)))
    x, y = speed, heading * worm.lean + sway  # both are symmetric: their means are 0
    moments += np.array([[x @ x, x @ y], [x @ y, y @ y]])


def _add_pairs(sign: Floats, products: Floats, pairs: Floats) -> None:
    n, most = len(sign), len(products)
    if n == 0:
        return
    size = 1 << int(np.ceil(np.log2(2 * n)))
    spectrum = np.fft.rfft(sign, size)
    lags = min(n, most)
    products[:lags] += np.fft.irfft(spectrum * spectrum.conj(), size)[:lags]
    pairs[:lags] += n - np.arange(lags)


def telegraph(rate: float = 0.5, duration_s: float = 2e5) -> tuple[float, float]:
    """Return the largest error of C_θ of a telegraph process, and the relative one of t_per."""
    n = round(duration_s / CELL_S)
    flips = np.random.default_rng(5).random(n) < 0.5 * -np.expm1(-2 * rate * CELL_S)
    signs = np.where(np.cumsum(flips) % 2, -1.0, 1.0)
    correlation = SignCorrelation(lag_grid(120.0, 10.0, CELL_S, 1.0), CELL_S)
    correlation.add(np.arange(n) * round(CELL_S * 1e9), signs)
    units = Units([correlation.sums()["c_theta"]])
    c, _ = correlation_curve(units)
    t_per, _, _ = persistence_time(units, correlation.lag_s)
    worst = float(np.abs(c - np.exp(-2 * rate * correlation.lag_s)).max())
    return worst, t_per * 2 * rate - 1


def rows(answers: Sequence[Answer], truth: dict[str, float]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each quantity: truth, mean, bias, how many seeds, coverage."""
    for name, true in truth.items():
        told = [found[name] for found in answers if not np.isnan(found.get(name, (nan,))[0])]
        told = [item for item in told if not np.isnan(item[1:]).all()]
        if not told:
            yield (name, f"{true:.4g}", "–", "–", "0", "–", "")
            continue
        value, low, high = np.array(told).T
        holds = ~((true < low) | (true > high))  # an end that the data do not bound holds all
        share = binomtest(int(holds.sum()), len(holds)).proportion_ci()
        error = value.std(ddof=1) / np.sqrt(len(value)) if len(value) > 1 else nan
        yield (
            name,
            f"{true:.4g}",
            f"{value.mean():.4g}",
            f"{value.mean() - true:+.3g} ± {error:.1g}",
            str(len(told)),
            f"{100 * holds.mean():.1f} % [{100 * share.low:.0f}, {100 * share.high:.0f}]",
            "" if holds.mean() >= GOOD else "below the bar",
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--hours", type=float, default=1.0, help="length of each trial")
    parser.add_argument("--rate", type=float, default=30.0, help="frames/s")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--jitter-mm", type=float, default=0.0, help="white, of the head's radius")
    parser.add_argument("--slow-jitter-mm", type=float, default=0.0, help="correlated over 0.1 s")
    parser.add_argument("--wall-offset-mm", type=float, default=0.0)
    parser.add_argument("--gaps-per-min", type=float, default=0.0, help="of 0.7 s on average")
    parser.add_argument("--half-sine", action="store_true", help="hops are half sines of depth")
    parser.add_argument("--emerges", action="store_true", help="visits begin in the exit's mouth")
    given = parser.parse_args()
    worm = KnownWorm(half_sine=given.half_sine, emerges=given.emerges)
    camera = Camera(
        jitter=1e-3 * given.jitter_mm,
        slow_jitter=1e-3 * given.slow_jitter_mm,
        wall_offset=1e-3 * given.wall_offset_mm,
        gaps_per_s=given.gaps_per_min / 60,
        gap_s=0.7,
    )
    truth = truths(worm)
    with ProcessPoolExecutor(given.workers) as pool:
        answers = list(
            pool.map(partial(answer, worm, camera, given.hours, given.rate), range(given.seeds))
        )
    table = Table(
        "quantity", "truth", "mean", "bias", "seeds", "held by the 95 % interval", "",
        title=f"{given.seeds} trials of {given.hours:g} h at {given.rate:g} frames/s",
    )  # fmt: skip
    for row in rows(answers, truth):
        table.add_row(*row)
    console = Console(width=110)
    console.print(table)
    cycle_s = (worm.d_c + worm.d_nc) / worm.speed
    console.print(f"The walk's own 1/(2 × rate of reversal): {cycle_s / 2 / worm.reversal:.2f} s")
    for name in LAWS:
        refused = [found[name][0] < 0.05 for found in answers if name in found]
        console.print(f"{name} below 0.05 in {sum(refused)} of {len(refused)} trials")
    worst, relative = telegraph()
    console.print(
        f"telegraph process: C_θ off by at most {worst:.4f}, t_per by {100 * relative:+.2f} %"
    )


if __name__ == "__main__":
    main()
