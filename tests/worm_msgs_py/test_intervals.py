"""Intervals of counts, rates and exponential means against SciPy and samples of known laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from worm_msgs_py.intervals import exponential_mean, fraction, poisson_rate


@pytest.mark.parametrize(("successes", "n"), [(0, 12), (7, 12), (12, 12), (60, 100)])
def test_fraction_is_clopper_pearson(successes, n):
    interval = stats.binomtest(successes, n).proportion_ci()
    assert fraction(successes, n) == pytest.approx((successes / n, interval.low, interval.high))


@given(st.integers(1, 400), st.data())
def test_a_fraction_lies_in_its_interval(n, data):
    count = data.draw(st.integers(0, n))
    value, low, high = fraction(count, n)
    assert 0.0 <= low <= value <= high <= 1.0
    assert (low == 0.0) == (count == 0)
    assert (high == 1.0) == (count == n)


@pytest.mark.parametrize("of_nothing", [fraction, exponential_mean])
def test_nothing_has_no_value_and_no_interval(of_nothing):
    assert np.isnan(of_nothing(0, 0)).all()


@pytest.mark.parametrize("count", [0, 1, 13])
def test_poisson_rate_has_the_exact_interval(count):
    rate, low, high = poisson_rate(count, 2.0)
    assert rate == count / 2
    assert stats.poisson.cdf(count, 2 * high) == pytest.approx(0.025)
    if count:
        assert stats.poisson.sf(count - 1, 2 * low) == pytest.approx(0.025)


def test_intervals_of_an_exponential_mean_cover_the_truth_also_where_some_are_cut_short():
    random, covered = np.random.default_rng(4), 0
    for _ in range(300):
        times, limit = random.exponential(40.0, 20), 60.0
        ended = times < limit
        _, low, high = exponential_mean(int(ended.sum()), float(np.minimum(times, limit).sum()))
        covered += low <= 40.0 <= high
    assert covered >= 275
