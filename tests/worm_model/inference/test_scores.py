"""Scores of forecasts against closed forms, and against forecasters that are known to be right."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import kolmogorov
from scipy.stats import kstest

from worm_model.inference.scores import HORIZONS_S, Scores, crps, crps_exponential, pit, uniformity

means = st.floats(0.5, 200.0)
times = st.floats(0.01, 400.0)


def exponential(mean_s):
    return lambda t: -np.expm1(-np.asarray(t) / mean_s)


@given(means, times)
def test_the_score_of_an_exponential_law_is_its_closed_form(mean_s, outcome_s):
    expected = crps_exponential(mean_s, outcome_s)
    assert crps(exponential(mean_s), outcome_s, mean_s) == pytest.approx(expected, rel=1e-4)


@given(means, times)
def test_the_score_of_one_certain_time_is_its_distance_from_the_outcome(certain_s, outcome_s):
    found = crps(
        lambda t: (np.asarray(t) >= certain_s).astype(float), outcome_s, certain_s, [certain_s]
    )
    assert found == pytest.approx(abs(certain_s - outcome_s))


def test_no_other_mean_scores_better_than_the_true_one_on_average():
    outcomes = np.random.default_rng(0).exponential(40.0, 4000)
    scores = {
        mean: np.mean([crps_exponential(mean, t) for t in outcomes]) for mean in (20.0, 40.0, 80.0)
    }
    assert min(scores, key=scores.get) == 40.0


def test_outcomes_of_the_law_itself_are_uniform_and_of_another_are_not():
    outcomes = np.random.default_rng(1).exponential(40.0, 800)
    for mean_s, calibrated in ((40.0, True), (55.0, False)):
        values = np.array([pit(exponential(mean_s), t, 0.5) for t in outcomes])
        assert (uniformity(values) > 0.01) == calibrated


def test_a_jump_of_the_law_is_shared_out_evenly():
    """Half of the outcomes at exactly 20 s: the transform is uniform all the same."""
    random = np.random.default_rng(2)
    outcomes = np.where(random.random(1000) < 0.5, 20.0, 20.0 + random.exponential(30.0, 1000))

    def within(t):
        t = np.asarray(t)
        return np.where(t >= 20.0, 1.0 - 0.5 * np.exp(-(t - 20.0) / 30.0), 0.0)

    values = np.array(
        [pit(within, t, u) for t, u in zip(outcomes, random.random(1000), strict=True)]
    )
    assert uniformity(values) > 0.01
    assert np.all((values >= 0.0) & (values <= 1.0))


@given(st.lists(st.floats(0.0, 1.0), min_size=5, max_size=60))
def test_the_test_of_uniformity_is_that_of_kolmogorov_and_smirnov(values):
    exact = kstest(values, "uniform")
    assert uniformity(np.array(values)) == pytest.approx(exact.pvalue, abs=0.03)
    assert 0.0 <= uniformity(np.array(values)) <= kolmogorov(0.0)


def test_a_forecast_that_knows_more_beats_the_memoryless_one_and_says_so_with_its_interval():
    """Two kinds of searches, of 10 s and 70 s: one who knows which is better off than Exp(40 s)."""
    random = np.random.default_rng(3)
    scores = Scores()
    for mean_s in random.choice([10.0, 70.0], 300):
        scores.push(exponential(mean_s), random.exponential(mean_s), 40.0)
    named = dict(scores.named())
    assert named["passages"] == 300
    assert named["crps_gain_low_s"] > 0.0
    assert named["crps_gain_s"] == pytest.approx(named["crps_memoryless_s"] - named["crps_s"])
    assert named["pit_p"] > 0.01
    assert abs(named["pit_mean"] - 0.5) < 3 / np.sqrt(12 * 300)
    for horizon in HORIZONS_S[:2]:
        assert named[f"brier_{horizon:.0f}_s"] < named[f"brier_memoryless_{horizon:.0f}_s"]


def test_before_the_first_passage_there_are_no_scores_and_after_one_no_interval():
    scores = Scores(unscored=2)
    assert scores.named() == ()
    scores.push(exponential(30.0), 12.0, 30.0)
    named = dict(scores.named())
    assert (named["passages"], named["passages_unscored"]) == (1.0, 2.0)
    assert np.isnan(named["crps_gain_low_s"])
    assert named["brier_10_s"] == pytest.approx((1 - np.exp(-1 / 3)) ** 2)
    assert named["brier_30_s"] == pytest.approx(np.exp(-1.0) ** 2)
