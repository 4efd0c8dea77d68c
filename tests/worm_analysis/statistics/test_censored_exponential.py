"""Sums of lengths above a cut-off are those of the lengths."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.statistics.censored_exponential import ExcessSums
from worm_msgs_py.intervals import exponential_mean

NS = 10**9


def test_exponential_mean_with_cutoff_and_censoring_is_covered_by_its_interval():
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(300):
        length, limit = rng.exponential(1.95e-3, 80), rng.exponential(8e-3, 80)
        sums = ExcessSums(1e-5, 6001)
        for item, end in zip(length, limit, strict=True):
            sums.push(min(item, end), complete=bool(item < end))
        n, excess, cutoff = sums.above(1.23e-4)
        assert cutoff == pytest.approx(1.3e-4)
        _, low, high = exponential_mean(n, excess)
        hits += low < 1.95e-3 < high
    assert 0.92 < hits / 300 < 0.98


@given(st.lists(st.floats(0, 0.1), min_size=1, max_size=50), st.floats(0, 0.02))
def test_sums_above_a_cutoff_are_those_of_the_lengths_themselves(lengths, cutoff):
    sums = ExcessSums(1e-5, 6001)
    for length in lengths:
        sums.push(length, complete=True)
    n, excess, edge = sums.above(cutoff)
    chosen = [length for length in lengths if int(length / 1e-5) >= round(edge / 1e-5)]
    assert n == len(chosen)
    assert excess == pytest.approx(sum(length - edge for length in chosen), abs=1e-12)
    assert cutoff - 1e-12 <= edge <= cutoff + 1e-5
