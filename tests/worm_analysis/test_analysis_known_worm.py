"""Visits and speeds of a worm whose life is known event by event, filmed with noise."""

import numpy as np
import pytest
from benchmarks.contact_noise import Condition, trial
from benchmarks.crossing_worm import SPEED, measured
from benchmarks.known_worm import Camera, KnownWorm

NOISY = Camera(jitter=3e-5)


@pytest.mark.parametrize("camera", [Camera(), NOISY], ids=["still", "noisy"])
def test_the_first_contact_of_a_head_that_comes_out_of_the_exit_is_where_it_meets_the_wall(camera):
    """Not in the mouth at 0°, where the circle has no wall."""
    found = trial(Condition("", worm=KnownWorm(emerges=True), camera=camera), 900.0, 3)
    assert len(found.theta_off_deg) >= 5
    assert np.nanmax(found.theta_off_deg) < 1.0
    assert found.tau_ratio == pytest.approx(1.0, abs=0.01)


def test_where_noise_may_hide_an_earlier_touch_the_angle_of_the_first_one_is_not_told():
    """In these a touch of less than a frame is not seen, and the next is 26°, 5° and 6° away."""
    for seed in (46, 49, 65):
        off = trial(Condition("", worm=KnownWorm(emerges=True), camera=NOISY), 300.0, seed)
        told = np.array(off.theta_off_deg)
        assert np.isnan(told).sum() == 1
        assert np.nanmax(told) < 1.0


@pytest.mark.parametrize("reversal", [0.03, 0.31])
def test_v_b_is_the_speed_of_the_walk_however_often_the_head_turns(reversal):
    worm = KnownWorm(reversal=reversal)
    speeds = [trial(Condition("", worm=worm), 600.0, seed).told["v_b"][0] for seed in range(3)]
    assert np.mean(speeds) == pytest.approx(1e3 * worm.speed, rel=0.01)


@pytest.mark.parametrize("crossing", [0.0, 0.15])
@pytest.mark.parametrize("reversal", [0.03, 0.31])
def test_v_b_is_the_speed_of_a_worm_that_turns_within_contacts_and_crosses_the_middle(
    reversal, crossing
):
    speeds = [measured(seed, 600.0, 30.0, reversal, crossing, 3e-5).value for seed in range(2)]
    assert np.mean(speeds) == pytest.approx(1e3 * SPEED, rel=0.01)


def test_noise_beyond_what_can_be_allowed_for_is_a_reason_and_no_number():
    found = trial(Condition("", camera=Camera(jitter=6e-5)), 300.0, 1)
    for name in ("d_c", "d_nc", "delta_r_h", "reversal_per_cycle", "d_c_at_contact_factor_0.3"):
        assert "the head's radius is too noisy: 0.0" in found.why[name]
    assert found.told["radius_noise"][0] == pytest.approx(0.06, rel=0.1)
    some = trial(Condition("", camera=Camera(jitter=4e-5)), 300.0, 1)
    assert "d_c" in some.told
    assert "more than 0.25 of the 0.12" in some.why["d_c_at_contact_factor_0.3"]
