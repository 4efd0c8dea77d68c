"""Contacts and hops of a worm that was made apart: hops of other shapes, under much noise."""

import pytest
from benchmarks.ring_worm import NAMES, WORMS, Noise, RingWorm, trial

MUCH = Noise(4e-5)


@pytest.mark.parametrize(("hops", "close"), [("half sine", 0.05), ("long = deep", 0.03)])
def test_hops_that_hide_in_the_noise_are_allowed_for(hops, close):
    """Where long hops are deep, the short ones hide: d_c would be 4 % too long in these trials."""
    trials = [trial(WORMS[hops], MUCH, 600.0, seed) for seed in range(4)]
    for name in ("d_c", "d_nc", "delta_r_h"):
        told = sum(one.told[name][0] for one in trials)
        assert told == pytest.approx(sum(one.counted[name] for one in trials), rel=close), name
        for one in trials:
            assert one.told[name][1] < one.counted[name] < one.told[name][2]


def test_hops_of_which_too_many_hide_are_a_reason_and_no_number():
    """0.2 mm on average: noise of 0.04 mm leaves a fifth of them unseen, the others are told."""
    shallow = RingWorm(depth=2e-4)
    assert set(trial(shallow, Noise(), 240.0, 1).told) == set(NAMES)
    found = trial(shallow, MUCH, 240.0, 1)
    assert not found.told
    for name in NAMES:
        assert found.why[name].startswith("noise and pixels hide about")
