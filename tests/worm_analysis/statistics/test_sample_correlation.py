"""Pearson's correlation from sums, with an honest interval."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from worm_analysis.statistics.block_jackknife import BlockSums, Units
from worm_analysis.statistics.sample_correlation import pearson

NS = 10**9


@given(st.integers(0, 2**32 - 1))
def test_pearson_from_sums_is_numpys(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(3, 2, 300)
    y = rng.normal(0, 1, 300) + rng.normal() * x
    blocks = BlockSums(6)
    rows = np.stack([np.ones(300), x, y, x * x, y * y, x * y], axis=1)
    for step, row in enumerate(rows):
        blocks.row(step * NS)[:] += row
    r, low, high = pearson(Units([blocks.rows()]))
    assert r == pytest.approx(np.corrcoef(x, y)[0, 1], abs=1e-9)
    assert low < r < high


def test_the_interval_of_a_correlation_of_slow_series_is_honest():
    """Two series without anything in common, each with a memory of 20 steps."""
    rng = np.random.default_rng(10)
    hits = 0
    for _ in range(100):
        x, y = lfilter([1.0], [1.0, -0.95], rng.normal(size=(2, 2000)))
        blocks = BlockSums(6)
        rows = np.stack([np.ones(2000), x, y, x * x, y * y, x * y], axis=1)
        columns = np.tile(np.arange(6), (2000, 1))
        blocks.add(np.arange(2000) * NS, columns, rows)
        _, low, high = pearson(Units([blocks.rows()]))
        hits += low < 0 < high
    assert hits >= 90


def test_a_series_that_does_not_vary_has_no_correlation():
    blocks = BlockSums(6)
    for step in range(100):
        blocks.row(step * NS)[:] += (1.0, 0.3, step, 0.09, step**2, 0.3 * step)
    assert np.isnan(pearson(Units([blocks.rows()]))[0])
