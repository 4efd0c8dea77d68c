"""Cochran's test: estimates of one number seldom differ more than their intervals allow."""

import numpy as np
import pytest

from worm_analysis.statistics.heterogeneity import same_number_p


def estimates(rng, truth, deviations):
    return [
        (x, x - 1.96 * sd, x + 1.96 * sd)
        for x, sd in zip(
            truth + deviations * rng.normal(size=len(deviations)), deviations, strict=True
        )
    ]


@pytest.mark.parametrize("level", [0.01, 0.05, 0.5])
def test_one_number_is_taken_for_several_as_often_as_the_level_says(level):
    rng = np.random.default_rng(1)
    deviations = np.array([0.1, 0.2, 0.3, 0.4])
    p = [same_number_p(estimates(rng, 100.0, deviations)) for _ in range(2000)]
    assert np.mean(np.array(p) < level) == pytest.approx(level, abs=4 * (level / 2000) ** 0.5)


def test_different_numbers_are_told():
    assert same_number_p([(1.0, 0.9, 1.1), (2.0, 1.8, 2.2)]) < 1e-6
    assert same_number_p([(-1.0, -1.1, -0.9), (1.0, 0.9, 1.1)]) < 1e-6


def test_scale_and_order_do_not_matter():
    found = [(1.0, 0.8, 1.25), (1.5, 1.2, 1.9), (1.1, 0.7, 1.7)]
    p = same_number_p(found)
    assert same_number_p([tuple(10 * np.array(item)) for item in found]) == pytest.approx(p)
    assert same_number_p(found[::-1]) == pytest.approx(p)


def test_a_single_estimate_tells_nothing():
    assert np.isnan(same_number_p([(1.0, 0.9, 1.1)]))
    assert np.isnan(same_number_p([(1.0, 0.9, 1.1), (2.0, 2.0, 2.0)]))
