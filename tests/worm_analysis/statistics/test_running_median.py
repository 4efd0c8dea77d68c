"""The running median is the median."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.statistics.running_median import RunningMedian

NS = 10**9


@given(st.lists(st.floats(0, 1.99e-3), min_size=1, max_size=200))
def test_the_running_median_is_that_of_numpy_to_a_bin(values):
    median = RunningMedian(2e-6, 1000)
    for count, value in enumerate(values, 1):
        median.push(value)
        ordered = sorted(values[:count])
        low, high = ordered[(count - 1) // 2], ordered[count // 2]
        assert low - 2.1e-6 <= median.value() <= high + 2.1e-6
    backwards = RunningMedian(2e-6, 1000)
    for value in reversed(values):
        backwards.push(value)
    assert backwards.value() == median.value()
    assert median.n == median.counts.sum() == len(values)


def test_the_running_median_leaves_out_what_is_no_width():
    median = RunningMedian(2e-6, 1000)
    assert np.isnan(median.value())
    for value in (np.nan, -1.0, np.inf):
        median.push(value)
    assert median.n == 0
