"""A second worm of known laws, made apart from `known_worm`: hops of four shapes on a closed wall.

The wall has no exit. A hop is a function of the way along the wall: a step from the threshold of
contact on; half a sine from the wall on, so that some hops stay below the threshold; half a sine
that is the deeper the longer it is, so that the short ones hide in the noise; and small half sines
of a worm that turns round often. The radius jitters by white noise, or by noise that stays for a
time. The truth is what the paper's threshold counts on the depth without noise, 2000 times a
second. Nothing here is shared with `worm_analysis` or `known_worm`.

The table: bias against the truth of the same trials ± its standard error, and the part of the
trials whose interval holds the truth of a far longer life.
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import lru_cache, partial
from math import exp, nan, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.contact_noise import cell
from worm_analysis.analysis import Analysis
from worm_msgs_py import BodyState, Chamber, Geometry, Keypoint, Status, Where

Floats = NDArray[np.float64]

R, WIDTH, BODY_M = 0.01, 4e-4, 5e-3
THRESHOLD, TOUCH = 0.3 * WIDTH, 0.1 * WIDTH
DEEPEST = 0.9 * R
LONG_S, LONG_SEEDS = 1.0e4, range(1000, 1020)
LOOKS_A_SECOND, LONG_LOOKS = 2000, 500
NAMES = ("d_c", "d_nc", "delta_r_h", "reversal_per_cycle")
GEOMETRY = Geometry(
    1, 0, 1700, 800, (Chamber("chamber_a", 300.0, 500.0, 200.0, 0.2, R, exit_width_m=nan),)
)


@dataclass(frozen=True)
class RingWorm:
    """Means in m, a speed in m/s, and the chance of turning round after a hop."""

    shape: str = "step"
    """``step``, ``sine``, or ``deep``: half a sine that is the deeper the longer it is."""
    slide: float = 1.95e-3
    hop: float = 1.46e-3
    depth: float = 1.14e-3
    reversal: float = 0.031
    speed: float = 2.02e-3


WORMS = {
    "step": RingWorm(),
    "half sine": RingWorm("sine"),
    "half sine, small": RingWorm("sine", 1.2e-3, 2.0e-3, 0.7e-3, 0.3),
    "long = deep": RingWorm("deep"),
}


@dataclass(frozen=True)
class Noise:
    """Of the radius: deviation in m, how long it stays in s (0: white), and frames a second."""

    deviation: float = 0.0
    stays_s: float = 0.0
    rate_hz: float = 30.0

    @property
    def name(self) -> str:
        """Words for a table."""
        if not self.deviation:
            return "none"
        stays = f"{self.stays_s:g} s" if self.stays_s else "white"
        return f"{1e3 * self.deviation:.2f} mm, {stays}"


NOISES = (
    Noise(),
    Noise(rate_hz=60.0),
    Noise(2e-5),
    Noise(2e-5, 0.1, 60.0),
    Noise(2e-5, 1.0),
    Noise(3e-5, rate_hz=15.0),
    Noise(4e-5),
    Noise(4e-5, 0.1, 60.0),
    Noise(4e-5, 0.3),
    Noise(4e-5, 1.0),
)


@dataclass(frozen=True)
class Life:
    """Slides and hops in turn: times and places (m along the wall) at which they meet, depths."""

    t: Floats
    place: Floats
    deepest: Floats
    stepped: bool

    def at(self, t: Floats) -> tuple[Floats, Floats]:
        """Return depth and place at times."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.deepest) - 1)
        part = (t - self.t[k]) / np.diff(self.t)[k]
        hopping = self.deepest[k] > 0
        rise = 1.0 if self.stepped else np.sin(np.pi * part)
        return TOUCH + np.where(hopping, self.deepest[k] * rise, 0.0), np.interp(
            t, self.t, self.place
        )


def live(worm: RingWorm, seed: int, duration_s: float) -> Life:
    """Draw a life."""
    rng = np.random.default_rng((seed, 41))
    n = round(1.5 * duration_s * worm.speed / (worm.slide + worm.hop)) + 50
    ways = np.column_stack([rng.exponential(worm.slide, n), rng.exponential(worm.hop, n)])
    depth = rng.exponential(worm.depth, n)
    if worm.shape == "deep":
        depth = ways[:, 1] * worm.depth / worm.hop * rng.gamma(4.0, 0.25, n)
    if worm.shape == "step":
        depth = depth + THRESHOLD - TOUCH
    turned = np.cumsum(rng.random(n) < worm.reversal) % 2
    sign = 1.0 - 2.0 * np.concatenate([[0], turned[:-1]])
    deepest = np.column_stack([np.zeros(n), np.minimum(depth, DEEPEST)]).ravel()
    t = np.concatenate([[0.0], np.cumsum(ways.ravel()) / worm.speed])
    place = np.concatenate([[0.0], np.cumsum((sign[:, None] * ways).ravel())])
    return Life(t, place, deepest, worm.shape == "step")


def counted(life: Life, duration_s: float, looks_a_second: int) -> dict[str, float]:
    """Return what the threshold counts without noise, mm."""
    t = np.arange(0.0, duration_s, 1 / looks_a_second)
    depth, place = life.at(t)
    touching = depth < THRESHOLD
    starts = np.flatnonzero(np.diff(touching)) + 1
    ways = np.diff(place[starts])
    deepest = np.maximum.reduceat(depth, starts)[:-1]
    contact = touching[starts[:-1]]
    first = int(np.argmax(contact))
    cycles = (len(ways) - first) // 2 * 2
    way = ways[first : first + cycles].reshape(-1, 2).sum(axis=1)
    return {
        "d_c": 1e3 * float(np.abs(ways[contact]).mean()),
        "d_nc": 1e3 * float(np.abs(ways[~contact]).mean()),
        "delta_r_h": 1e3 * float(deepest[~contact].mean() - THRESHOLD),
        "reversal_per_cycle": float(np.mean(np.diff(np.sign(way)) != 0)),
    }


@lru_cache(maxsize=8)
def long_truth(worm: RingWorm) -> dict[str, float]:
    """Return the same of many longer lives."""
    lives = [counted(live(worm, seed, LONG_S), LONG_S, LONG_LOOKS) for seed in LONG_SEEDS]
    return {name: float(np.mean([one[name] for one in lives])) for name in NAMES}


def film(life: Life, noise: Noise, seed: int, duration_s: float) -> Iterator[BodyState]:
    """Yield the states that a tracker gives of a life."""
    rng = np.random.default_rng((seed, 43))
    t = np.arange(0.0, duration_s, 1 / noise.rate_hz)
    depth, place = life.at(t)
    jitter = rng.normal(size=len(t))
    if noise.stays_s:
        kept = exp(-1 / noise.rate_hz / noise.stays_s)
        jitter[1:] *= sqrt(1 - kept * kept)
        jitter = lfilter([1.0], [1.0, -kept], jitter)
    outward = np.exp(1j * place / R)
    head = (R - depth + noise.deviation * jitter) * outward
    centroid = head - BODY_M * outward
    for k, (at, tip, middle) in enumerate(
        zip(t.tolist(), head.tolist(), centroid.tolist(), strict=True)
    ):
        yield BodyState(
            frame=k,
            stamp_ns=round(at * 1e9),
            frame_id="chamber_a",
            where=Where.CHAMBER_A,
            status=Status.TRACKED,
            geometry=1,
            confidence=1.0,
            head_certainty=1.0,
            head=Keypoint(0.0, 0.0, tip.real, tip.imag, 0.0),
            centroid=Keypoint(0.0, 0.0, middle.real, middle.imag),
            tail=Keypoint(0.0, 0.0, 0.0, 0.0),
            length_m=0.02,
            width_m=WIDTH,
        )


@dataclass
class Trial:
    """Value, low and high of what was told, why the rest was not, and the truth of the trial."""

    told: dict[str, tuple[float, float, float]]
    why: dict[str, str]
    counted: dict[str, float]


def trial(worm: RingWorm, noise: Noise, duration_s: float, seed: int) -> Trial:
    """Film and analyse one trial."""
    life = live(worm, seed, duration_s)
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    for state in film(life, noise, seed, duration_s):
        analysis.push(state)
    analysis.finish()
    numbers = [item for item in analysis.summary() if item.name in NAMES]
    told = {
        item.name: (item.value, item.low or nan, item.high or nan)
        for item in numbers
        if item.value is not None
    }
    why = {item.name: item.why for item in numbers if item.value is None}
    return Trial(told, why, counted(life, duration_s, LOOKS_A_SECOND))


def main() -> None:
    """Print a row for each worm and noise."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=10.0, help="length of each trial")
    parser.add_argument("--only", default="", help="worms whose name holds this")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    print("| hops | noise | 1/s | d_c | d_nc | Δr_h | reversals per cycle |")
    print("|---|---|---|---|---|---|---|")
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    with ProcessPoolExecutor(given.workers) as pool:
        for words, worm in WORMS.items():
            if given.only not in words:
                continue
            true = long_truth(worm)
            for noise in NOISES:
                run = partial(trial, worm, noise, 60 * given.minutes)
                trials = list(pool.map(run, seeds))
                cells = [cell(trials, name, true[name]) for name in NAMES]
                row = " | ".join([words, noise.name, f"{noise.rate_hz:.0f}", *cells])
                print(f"| {row} |", flush=True)


if __name__ == "__main__":
    main()
