"""C_θ(t) and t_per in closed form, and where there is no t_per."""

from dataclasses import replace
from math import exp, isnan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from worm_model.boundary_walk.direction_correlation import direction_correlation, persistence_time_s
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters

PAPER = WalkParameters()

WALKS = st.builds(
    WalkParameters,
    speed_mm_s=st.floats(0.1, 10.0),
    mean_slide_mm=st.floats(0.01, 100.0),
    mean_hop_mm=st.floats(0.01, 100.0),
    reversal=st.floats(0.0, 1.0),
    rule=st.sampled_from(ReversalRule),
)


def four_states(walk):
    """Rates of slide +, slide −, hop +, hop −; probabilities when going + at a random time."""
    v, slide, hop = walk.speed_mm_s, walk.mean_slide_mm, walk.mean_hop_mm
    q_s, q_h = walk.flip_after_slide, walk.flip_after_hop
    rates = np.zeros((4, 4))
    for here, there in ((0, 1), (1, 0)):
        rates[here, 2 + here], rates[here, 2 + there] = v / slide * (1 - q_s), v / slide * q_s
        rates[2 + here, here], rates[2 + here, there] = v / hop * (1 - q_h), v / hop * q_h
        rates[here, there] = rates[2 + here, 2 + there] = 0.0
    for here, there in ((0, 1), (1, 0), (2, 3), (3, 2)):
        rates[here, there] += walk.flip_rate_s
    rates -= np.diag(rates.sum(axis=1))
    return rates, np.array([slide, 0.0, hop, 0.0]) / (slide + hop)


@given(walk=WALKS, part=st.floats(0.0, 5.0))
@settings(max_examples=60)
def test_c_theta_is_that_of_the_four_states(walk, part):
    lag_s = part * (walk.mean_slide_mm + walk.mean_hop_mm) / walk.speed_mm_s
    rates, start = four_states(walk)
    expected = start @ expm(rates * lag_s) @ np.array([1.0, -1.0, 1.0, -1.0])
    found = direction_correlation(walk, np.array([lag_s]))[0]
    assert found == pytest.approx(expected, abs=1e-9)


@given(walk=WALKS)
@settings(max_examples=60)
def test_t_per_is_the_first_time_at_which_c_theta_is_1_over_e(walk):
    t_per_s = persistence_time_s(walk)
    if isnan(t_per_s):
        until_s = 1e4 * (walk.mean_slide_mm + walk.mean_hop_mm) / walk.speed_mm_s
        lag_s = np.linspace(0.0, until_s, 1000)
        assert (direction_correlation(walk, lag_s) > exp(-1.0) - 1e-9).all()
        return
    assert direction_correlation(walk, np.array([t_per_s]))[0] == pytest.approx(exp(-1.0))
    before_s = np.linspace(0.0, t_per_s * 0.999, 2000)
    assert (direction_correlation(walk, before_s) > exp(-1.0)).all()


def test_a_head_that_turns_at_each_end_mostly_goes_the_way_of_its_long_phase():
    """C_θ stays at ((⟨d_c⟩ − ⟨d_nc⟩)/(⟨d_c⟩ + ⟨d_nc⟩))²."""
    walk = replace(
        PAPER, rule=ReversalRule.PER_PHASE, reversal=1.0, mean_slide_mm=9.0, mean_hop_mm=1.0
    )
    assert direction_correlation(walk, np.array([1e3]))[0] == pytest.approx(0.64)
    assert isnan(persistence_time_s(walk))
    alike = replace(walk, mean_hop_mm=9.0)
    assert persistence_time_s(alike) == pytest.approx(9.0 / walk.speed_mm_s / 2)


def test_the_smaller_the_reversal_the_longer_the_direction_is_kept():
    """t_per is 1/2r where reversals of rate r are rare, down to the rarest."""
    cycle_s = (PAPER.mean_slide_mm + PAPER.mean_hop_mm) / PAPER.speed_mm_s
    for reversal in (1e-3, 1e-6, 1e-12):
        expected = cycle_s / (2 * reversal)
        assert persistence_time_s(replace(PAPER, reversal=reversal)) == pytest.approx(
            expected, rel=3 * reversal + 1e-9
        )
