"""Sums by blocks of time, and intervals for series that are correlated."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from worm_analysis.statistics.block_jackknife import BlockSums, Units, jackknife_half_width

NS = 10**9


@given(
    st.lists(st.floats(0.01, 300), min_size=1, max_size=200),
    st.integers(1, 50),
    st.integers(0, 2**32 - 1),
)
def test_sums_do_not_depend_on_how_frames_are_bunched(intervals_s, at_once, seed):
    rng = np.random.default_rng(seed)
    stamps = np.cumsum(np.array(intervals_s) * NS).astype(np.int64)
    columns = rng.integers(-1, 3, (len(stamps), 2))
    values = rng.normal(size=(len(stamps), 2))
    one, many = BlockSums(3), BlockSums(3)
    for stamp, column, value in zip(stamps.tolist(), columns, values, strict=True):
        row = one.row(stamp)
        for at, item in zip(column, value, strict=True):
            if at >= 0:
                row[at] += item
    for start in range(0, len(stamps), at_once):
        part = slice(start, start + at_once)
        many.add(stamps[part], columns[part], values[part])
    assert one.rows().tobytes() == many.rows().tobytes()


@given(st.lists(st.floats(0.001, 400), min_size=1, max_size=300))
def test_block_sums_add_up_however_long_the_trial(intervals_s):
    blocks = BlockSums(2)
    stamps = np.cumsum(np.array(intervals_s) * NS).astype(np.int64)
    for stamp in stamps.tolist():
        blocks.row(stamp)[:] += (1.0, 3.0)
    units = Units([blocks.rows()])
    np.testing.assert_array_equal(units.total(), [len(stamps), 3 * len(stamps)])
    for rows in units.levels():
        assert len(rows) <= 64
        assert rows.sum() == 4 * len(stamps)


def test_the_interval_of_a_mean_of_a_correlated_series_is_honest():
    """An AR(1) series with a memory of a block: the shortest blocks alone hold 75 of 100."""
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(100):
        series = lfilter([1.0], [1.0, -0.95], rng.normal(size=2500))
        blocks = BlockSums(2)
        for step, value in enumerate(series.tolist()):
            blocks.row(step * NS)[:] += (value, 1.0)
        half = jackknife_half_width(Units([blocks.rows()]), lambda sums: sums[:, 0] / sums[:, 1])
        hits += abs(series.mean()) < half
    assert hits >= 90
