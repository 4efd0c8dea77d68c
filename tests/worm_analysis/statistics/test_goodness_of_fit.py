"""The test of an exponential law against printed tables and samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.statistics.goodness_of_fit import exponential_p, merged_bins, p_of_statistic

NS = 10**9


@pytest.mark.parametrize(
    ("critical", "p"), [(0.736, 0.25), (1.062, 0.10), (1.321, 0.05), (1.591, 0.025), (1.959, 0.01)]
)
def test_p_is_that_of_the_printed_table(critical, p):
    """D'Agostino & Stephens (1986), table 4.14: A² of an exponential law with fitted mean."""
    assert p_of_statistic(critical) == pytest.approx(p, rel=0.03)


@pytest.mark.parametrize("n", [25, 2000])
def test_a_true_exponential_is_refused_as_often_as_the_level_says(n):
    rng = np.random.default_rng(6)
    p = []
    for _ in range(1500):
        x = rng.exponential(1.95, n)
        counts = np.bincount((x / 0.1).astype(int), minlength=2)
        p.append(exponential_p(np.append(counts, 0), 0.1, x.mean()))
    for level in (0.05, 0.2, 0.5):
        spread = 3.5 * np.sqrt(level * (1 - level) / len(p))
        assert np.mean(np.array(p) < level) == pytest.approx(level, abs=spread + 0.01)


def test_another_law_is_refused():
    rng = np.random.default_rng(7)
    for x in (rng.gamma(2.0, 1.0, 300), rng.weibull(0.7, 300), rng.uniform(0, 4, 300)):
        counts = np.append(np.bincount((x / 0.05).astype(int)), 0)
        assert exponential_p(counts, 0.05, x.mean()) < 1e-3


@given(st.lists(st.integers(0, 20), min_size=1, max_size=40), st.integers(1, 9))
def test_grouping_loses_no_item(counts, per_group):
    groups = merged_bins(np.array(counts), per_group)
    assert groups.sum() == sum(counts)
    assert groups[0] == sum(counts[:per_group])
