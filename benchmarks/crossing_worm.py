"""v_b of a worm that turns round often, hops below the threshold, and crosses the middle.

Its track is made here from segments alone, in a ring without an exit: slides along the wall, hops
that are half sines of depth from the wall on, and straight ways across the chamber to any other
place of the wall. All are run through at one speed, which is what v_b should be. Nothing is shared
with `known_worm` or `worm_analysis`.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from math import nan, pi

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from worm_analysis.analysis import Analysis
from worm_msgs_py import BodyState, Chamber, Geometry, Keypoint, Quantity, Status, Where

Complexes = NDArray[np.complex128]

R, WIDTH, TOUCH = 0.01, 4e-4, 4e-5
SPEED, SLIDE, HOP, DEPTH = 2.02e-3, 1.95e-3, 1.46e-3, 1.14e-3
NAME = "chamber_a"
RING = Geometry(1, 0, 1700, 800, (Chamber(NAME, 300.0, 500.0, 200.0, 0.2, R, exit_width_m=nan),))


@dataclass(frozen=True)
class Segment:
    """A way at the wall with a hop of some depth, or straight across from angle to angle."""

    start_s: float
    duration_s: float
    begin: float
    end: float
    depth: float = 0.0
    straight: bool = False

    def at(self, part: NDArray[np.float64]) -> Complexes:
        """Return places after parts of its duration."""
        if self.straight:
            a, b = (R - TOUCH) * np.exp(1j * np.array([self.begin, self.end]))
            return np.asarray(a + (b - a) * part)
        radius = R - TOUCH - self.depth * np.sin(pi * part)
        return np.asarray(radius * np.exp(1j * (self.begin + (self.end - self.begin) * part)))


def segments(seed: int, until_s: float, reversal: float, crossing: float) -> Iterator[Segment]:
    """Yield the worm's way; `crossing` is the chance that it crosses instead of a hop."""
    rng = np.random.default_rng((seed, 21))
    time_s, theta, direction = 0.0, rng.uniform(0, 2 * pi), 1.0
    while time_s < until_s:
        for slides in (True, False):
            length, depth = rng.exponential(SLIDE if slides else HOP), rng.exponential(DEPTH)
            end = theta + direction * length / R
            straight = not slides and bool(rng.random() < crossing)
            if straight:
                end = theta + rng.uniform(0.2, 2 * pi - 0.2)
                length = 2 * (R - TOUCH) * abs(np.sin((end - theta) / 2))
            depth = 0.0 if slides else min(depth, 0.9 * R)
            yield Segment(time_s, length / SPEED, theta, end, depth, straight)
            time_s, theta = time_s + length / SPEED, end
        direction *= rng.choice([-1, 1]) if straight else 1 - 2 * (rng.random() < reversal)


def places(way: list[Segment], t: NDArray[np.float64]) -> Complexes:
    """Return where the head is at times."""
    which = np.searchsorted([segment.start_s for segment in way], t, side="right") - 1
    found = np.empty(len(t), dtype=np.complex128)
    for k in np.unique(which):
        here = which == k
        found[here] = way[k].at((t[here] - way[k].start_s) / way[k].duration_s)
    return found


def measured(
    seed: int, duration_s: float, rate_hz: float, reversal: float, crossing: float, jitter_m: float
) -> Quantity:
    """Return v_b of one trial; the jitter is that of x and of y."""
    t = np.arange(0, duration_s, 1 / rate_hz)
    rng = np.random.default_rng((seed, 22))
    head = places(list(segments(seed, duration_s, reversal, crossing)), t)
    head += jitter_m * (rng.normal(size=len(t)) + 1j * rng.normal(size=len(t)))
    analysis = Analysis()
    analysis.set_geometry(RING)
    for frame, (time_s, at) in enumerate(zip(t.tolist(), head.tolist(), strict=True)):
        analysis.push(
            BodyState(
                frame=frame,
                stamp_ns=round(time_s * 1e9),
                frame_id=NAME,
                where=Where.CHAMBER_A,
                status=Status.TRACKED,
                geometry=1,
                confidence=1.0,
                head_certainty=1.0,
                head=Keypoint(0.0, 0.0, at.real, at.imag, 0.0),
                centroid=Keypoint(0.0, 0.0, at.real / 2, at.imag / 2),
                tail=Keypoint(0.0, 0.0, 0.0, 0.0),
                length_m=0.02,
                width_m=WIDTH,
            )
        )
    analysis.finish()
    return next(item for item in analysis.summary() if item.name == "v_b")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--minutes", type=float, default=10.0, help="length of each trial")
    given = parser.parse_args()
    table = Table("reversals per cycle", "crossings", "jitter", "1/s", "bias", "half width", "held")
    true = 1e3 * SPEED
    for reversal in (0.03, 0.31):
        for crossing, jitter_mm, rate_hz in (
            (0.0, 0.0, 15.0),
            (0.0, 0.0, 30.0),
            (0.0, 0.0, 60.0),
            (0.0, 0.03, 30.0),
            (0.15, 0.0, 30.0),
            (0.15, 0.03, 30.0),
            (0.4, 0.0, 30.0),
            (0.4, 0.03, 30.0),
        ):
            found = [
                measured(seed, 60 * given.minutes, rate_hz, reversal, crossing, 1e-3 * jitter_mm)
                for seed in range(given.seeds)
            ]
            value, low, high = np.array([(q.value, q.low, q.high) for q in found]).T
            table.add_row(
                f"{reversal:g}",
                f"{crossing:g}",
                f"{jitter_mm:.2f} mm",
                f"{rate_hz:.0f}",
                f"{100 * (value.mean() / true - 1):+.2f} %",
                f"{50 * (high - low).mean() / true:.2f} %",
                f"{100 * np.mean((low <= true) & (true <= high)):.0f} %",
            )
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
