"""Intervals allow for a worm that changes in the course of a trial."""

import numpy as np

from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_analysis.summary.estimates import length as exponential_length
from worm_analysis.summary.sums import Sums
from worm_msgs_py.intervals import exponential_mean

NS = 10**9


def test_the_interval_of_a_mean_allows_for_a_worm_that_changes():
    """The mean length of a slide swings over ten minutes: the law's own interval is too narrow."""
    rng = np.random.default_rng(9)
    hits = narrow = 0
    for _ in range(100):
        sums, blocks = ExcessSums(1e-5, 6001), ExcessBlocks(1e-5, 101)
        phase = rng.uniform(0, 2 * np.pi)
        for k in range(1000):  # one every 1.8 s
            mean = 2e-3 * (1 + 0.8 * np.sin(2 * np.pi * k / 137 + phase))
            length = rng.exponential(mean)
            sums.push(length, complete=True)
            blocks.push(k * 1_800_000_000, length, complete=True)
        n, excess, _ = sums.above(0.0)
        _, low, high = exponential_length("tau_h")(Sums([{"tau_h": blocks.rows(0.0)}]))
        hits += low < 2e-3 < high
        _, low, high = exponential_mean(n, excess)
        narrow += low < 2e-3 < high
    assert hits >= 90
    assert narrow < hits
