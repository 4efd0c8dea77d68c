"""The walk against closed forms, against itself, and against the values that are known."""

from dataclasses import replace
from math import exp, hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest

from worm_model.boundary_walk.direction_correlation import direction_correlation, persistence_time_s
from worm_model.boundary_walk.monte_carlo import simulate_walks
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters

PAPER = WalkParameters()
STANDARD_ERRORS = 4.0


def assert_agrees(estimate, value, standard_errors=STANDARD_ERRORS):
    sd = (estimate.high - estimate.low) / (2 * 1.96)
    assert abs(estimate.value - value) < standard_errors * sd


@pytest.mark.parametrize(
    ("reversal", "rule", "tau_s", "skips"),
    [(0.30, ReversalRule.PER_CYCLE, 50.88, 0.151), (0.45, ReversalRule.PER_PHASE, 98.84, 0.129)],
)
def test_known_values_at_one_millimetre(reversal, rule, tau_s, skips):
    result = simulate_walks(replace(PAPER, reversal=reversal, rule=rule), 30_000, seed=1)
    assert result.found.all()
    assert_agrees(result.mean_tau_h_s(), tau_s)
    assert_agrees(result.mean_skips(), skips)


def test_a_head_that_never_turns_nor_leaves_the_wall_finds_the_exit_uniformly_in_one_round():
    walk = replace(PAPER, reversal=0.0, mean_hop_mm=1e-9, mean_slide_mm=5.0)
    result = simulate_walks(walk, 5_000, seed=2)
    longest_s = (2 * pi * 10.0 - hypot(1.0, 1.5)) / 2.02
    assert kstest(result.tau_h_s, "uniform", args=(0.0, longest_s)).pvalue > 0.01
    assert result.skips.sum() == 0


def test_skips_of_a_head_that_never_turns_follow_their_closed_form():
    """At each meeting it flies with the share of hops, and over with exp(−w_s/⟨d_nc⟩)."""
    walk = replace(PAPER, reversal=0.0)
    slide, hop, arc = walk.mean_slide_mm, walk.mean_hop_mm, walk.exit_arc_mm
    over = exp(-arc / hop)
    later = hop / (slide + hop) * over
    reach = (1 / slide + 1 / hop) * (walk.circumference_mm - arc)
    first = later * (1 - (1 - exp(-reach)) / reach)  # it starts sliding, anywhere on the wall
    assert_agrees(simulate_walks(walk, 50_000, seed=3).mean_skips(), first / (1 - later))


@pytest.mark.parametrize("rate_s", [0.02, 0.2, 1.0])
def test_a_sliding_head_that_turns_at_random_takes_the_telegraph_time(rate_s):
    """⟨τ⟩ = L/2v + λL²/6v²: ballistic, then diffusive with D = v²/2λ (L²/12D)."""
    walk = replace(
        PAPER, rule=ReversalRule.RATE, reversal=rate_s, mean_slide_mm=50.0, mean_hop_mm=1e-9
    )
    length, v = walk.circumference_mm - walk.exit_arc_mm, walk.speed_mm_s
    mean = length / (2 * v) + rate_s * length**2 / (6 * v**2)
    assert_agrees(simulate_walks(walk, 20_000, seed=4).mean_tau_h_s(), mean)


def test_a_hop_that_may_not_land_skips_more_and_searches_longer():
    lands = simulate_walks(PAPER, 20_000, seed=5)
    flies = simulate_walks(replace(PAPER, hop_may_land=False), 20_000, seed=5)
    assert flies.mean_tau_h_s().low > lands.mean_tau_h_s().high
    assert flies.mean_skips().low > lands.mean_skips().high


@given(
    seed=st.integers(0, 100),
    rule=st.sampled_from(ReversalRule),
    reversal=st.floats(0.01, 0.6),
    width=st.floats(0.25, 20.0),
    hop_may_land=st.booleans(),
)
@settings(max_examples=25)
def test_every_walk_is_found_and_no_walk_is_faster_than_its_speed(
    seed, rule, reversal, width, hop_may_land
):
    walk = replace(
        PAPER, exit_width_mm=width, rule=rule, reversal=reversal, hop_may_land=hop_may_land
    )
    result = simulate_walks(walk, 50, seed)
    assert result.found.all()
    assert (result.tau_h_s > 0).all()
    assert (result.skips >= 0).all()
    # A round trip needs a round: so many skips cannot be made in less time.
    hops_needed = np.maximum(result.skips - 1, 0) * walk.exit_arc_mm / walk.speed_mm_s
    assert (result.tau_h_s >= hops_needed).all()


def test_the_same_seed_gives_the_same_walks():
    first, again, other = (simulate_walks(PAPER, 500, seed) for seed in (6, 6, 7))
    np.testing.assert_array_equal(first.tau_h_s, again.tau_h_s)
    np.testing.assert_array_equal(first.skips, again.skips)
    assert np.any(first.tau_h_s != other.tau_h_s)


def test_a_walk_that_takes_too_long_is_said_to_have_found_nothing():
    result = simulate_walks(PAPER, 1000, seed=8, horizon_s=20.0)
    assert 0.1 < result.found.mean() < 0.9
    assert (result.tau_h_s[~result.found] == 20.0).all()
    assert (result.tau_h_s[result.found] <= 20.0).all()


@pytest.mark.parametrize("rule", list(ReversalRule))
def test_c_theta_is_that_of_simulated_directions(rule):
    walk = replace(PAPER, rule=rule, reversal=0.2)
    lag_s = np.array([0.0, 0.5, 1.5, 4.0])
    products = simulated_direction_products(walk, lag_s, tracks=20_000, seed=9)
    error = np.maximum(products.std(axis=0) / np.sqrt(len(products)), 1e-12)
    z = (products.mean(axis=0) - direction_correlation(walk, lag_s)) / error
    assert np.abs(z[1:]).max() < STANDARD_ERRORS
    assert direction_correlation(walk, lag_s)[0] == pytest.approx(1.0)


def simulated_direction_products(walk, lag_s, tracks, seed):
    """Direction now times direction later, by a Gillespie simulation, one track at a time."""
    random = np.random.default_rng(seed)
    mean = {False: walk.mean_slide_mm / walk.speed_mm_s, True: walk.mean_hop_mm / walk.speed_mm_s}
    share = walk.mean_hop_mm / (walk.mean_slide_mm + walk.mean_hop_mm)
    products = np.empty((tracks, len(lag_s)))
    for row in products:
        time, sign, hopping = 0.0, 1.0, random.random() < share
        seen = 0
        while seen < len(lag_s):
            end = random.exponential(mean[hopping])
            turn = random.exponential(1 / walk.flip_rate_s) if walk.flip_rate_s else np.inf
            until = time + min(end, turn)
            while seen < len(lag_s) and lag_s[seen] < until:
                row[seen] = sign
                seen += 1
            time = until
            if turn < end:
                sign = -sign
                continue
            if random.random() < (walk.flip_after_hop if hopping else walk.flip_after_slide):
                sign = -sign
            hopping = not hopping
    return products


def test_turning_at_a_rate_gives_an_exponential_c_theta():
    walk = replace(PAPER, rule=ReversalRule.RATE, reversal=0.1)
    lag_s = np.linspace(0.0, 30.0, 7)
    np.testing.assert_allclose(direction_correlation(walk, lag_s), np.exp(-0.2 * lag_s), rtol=1e-12)
    assert persistence_time_s(walk) == pytest.approx(5.0, rel=1e-5)


def test_a_persistence_of_27_seconds_needs_three_reversals_in_a_hundred_cycles():
    assert persistence_time_s(replace(PAPER, reversal=0.03)) == pytest.approx(27.7, abs=0.1)
    assert np.isnan(persistence_time_s(replace(PAPER, reversal=0.0)))


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_mm_s": 0.0},
        {"mean_slide_mm": -1.0},
        {"reversal": 1.1},
        {"reversal": float("nan")},
        {"exit_width_mm": 70.0},
        {"exit_width_mm": 0.0, "effective_width": False},
    ],
)
def test_parameters_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=r"must|allows"):
        replace(PAPER, **wrong)
