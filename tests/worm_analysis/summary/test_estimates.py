"""Numbers of sums: what is hidden is counted by laws, and intervals allow for a change."""

from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_analysis.summary.estimates import length as exponential_length
from worm_analysis.summary.estimates import penetration_part, reversal_chance
from worm_analysis.summary.resolution import excursions_per_detected
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


@given(st.floats(0.0, 3e-4), st.floats(0.6, 1.4))
def test_shallow_excursions_are_counted_by_the_deep_ones(beyond_m, told_for_one):
    """However many of them noise hides or makes: the law of depths says how many there are."""
    mean_m, n = 1.1e-3, 5000.0
    deep = n * np.exp(-beyond_m / mean_m)
    told = told_for_one * n
    sums = {
        "delta_r_h": np.array([[deep, deep * mean_m, told, 0.0]]),
        "depth_limit": np.array([[1.0, beyond_m]]),
        "d_nc": np.array([[told, 0.0, told, 0.0]]),
    }
    more = excursions_per_detected(Sums([sums]))
    assert more * told == pytest.approx(n, rel=1e-6)


def test_a_few_deep_excursions_say_nothing_of_the_others():
    sums = {
        "delta_r_h": np.array([[9.0, 0.01, 15.0, 0.0]]),
        "depth_limit": np.array([[1.0, 1e-4]]),
        "d_nc": np.array([[15.0, 0.0, 15.0, 0.0]]),
    }
    assert excursions_per_detected(Sums([sums])) == 1.0


def test_what_one_trial_in_five_decides_has_no_bounds():
    """Only one turns back at once: without it there is no decay, and nothing bounds its height."""
    depths = np.zeros((5, 200))
    depths[0, 0], depths[1:, 3:70:9] = 9.0, 1.0
    value, low, high = penetration_part("alpha")(Sums([{"x_p": row[None]} for row in depths]))
    assert value > 0
    assert isnan(low)
    assert isnan(high)


def cycles_seen(step_m, *, turned=0.15):
    """Return the sums of 400 slides and hops of 2 mm, by a head that goes so far in a frame."""
    lengths = np.array([[400.0, 0.8, 400.0, 0.8]])
    return Sums(
        [
            {
                "d_c": lengths,
                "d_nc": lengths,
                "advance": np.array([[1000.0, 1000 * step_m]]),
                "reversal_per_cycle": np.array([[400.0, 400 * turned]]),
            }
        ]
    )


@given(st.floats(1e-5, 4e-4))
def test_intervals_allow_for_hidden_episodes_to_be_none_or_twice_as_many(step_m):
    """The longer way between frames, the more of them: without a correction, nothing is wider."""
    sums = cycles_seen(step_m)
    plain = exponential_length("d_c")(sums)
    value, low, high = exponential_length("d_c", 0)(sums)
    scale = value / plain[0]
    assert scale < 1
    assert (low, high) == pytest.approx((plain[1] * scale**2, plain[2]))


@given(st.floats(1e-5, 4e-4), st.floats(0.02, 0.3))
def test_hidden_cycles_may_be_those_in_which_the_worm_turns(step_m, turned):
    value, _, high = reversal_chance(cycles_seen(step_m, turned=turned))
    hidden = 1 - exponential_length("d_c", 0)(cycles_seen(step_m))[0] / 2e-3
    assert value < turned
    assert high >= turned * (1 - hidden) + hidden / 2
    assert high < 0.5
