"""A head on the body, whose place is not known to a few pixels, tells contact only where it can."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from analysed_states import analyse, by_name
from folded_tracks import folded
from unbiased import assert_unbiased
from walked_tracks import BODY_WIDTH, START_NS, R, track_from_polar

from worm_msgs_py import Episode

REVERSAL = 0.05
TRUTH = {"d_c": 1.95, "d_nc": 1.46, "reversal_per_cycle": REVERSAL}
UNSURE_M = 0.5 * BODY_WIDTH
RATE_HZ = 20.0
SEEDS = range(8)


def placed(state, outward_m, sd_m):
    """A state with its head farther from the centre, which its tracker says with a deviation."""
    x, y = state.head.x_m, state.head.y_m
    part = 1.0 + outward_m / np.hypot(x, y)
    return replace(state, head=replace(state.head, x_m=part * x, y_m=part * y), head_sd_m=sd_m)


@cache
def trials(is_said):
    """A fifth of the time in folds of one to four seconds, in which the head is drawn too short."""
    found = []
    for seed in SEEDS:
        track, _, _ = folded(seed, 600.0, RATE_HZ, reversal=REVERSAL, lost=0.0)
        rng = np.random.default_rng([seed, 11])
        states, start = track.states(), 0
        while (start := start + round(RATE_HZ * rng.exponential(10.0))) < len(states):
            frames = range(start, min(start + round(RATE_HZ * rng.uniform(1, 4)), len(states)))
            for k in frames:
                off_m = -abs(rng.normal(0.0, UNSURE_M))
                states[k] = placed(states[k], off_m, UNSURE_M if is_said else 0.0)
            start = frames.stop
        found.append(by_name(analyse(states)[0]))
    return found


@pytest.mark.parametrize("name", TRUTH)
def test_heads_that_are_said_to_be_unsure_bias_neither_contacts_nor_hops(name):
    answers = [numbers[name] for numbers in trials(True)]
    assert_unbiased(answers, TRUTH[name], most_error=0.15)


@pytest.mark.parametrize("name", ["d_c", "d_nc"])
def test_the_same_heads_do_bias_where_nothing_is_said_of_them(name):
    values = np.array([numbers[name].value for numbers in trials(False)])
    assert np.all(values < 0.75 * TRUTH[name])


def unsure_for(seconds, depth_m):
    """Twenty seconds with the head at one depth, from the eighth on unsure for so long."""
    t = np.arange(0.0, 20.0, 1 / RATE_HZ)
    track = track_from_polar(t, np.full(len(t), R - depth_m), 0.5 + 0.1 * t, np.full(len(t), 0.5))
    states = [
        placed(state, 0.0, UNSURE_M if 8.0 <= at < 8.0 + seconds else 0.0)
        for at, state in zip(t, track.states(), strict=True)
    ]
    return analyse(states)


@pytest.mark.parametrize("depth_m", [1e-5, 5e-3])
def test_contact_is_null_while_the_head_is_unsure_be_it_near_the_wall_or_far(depth_m):
    analysis, observables, _ = unsure_for(3.0, depth_m)
    contact = [each.contact for each in observables]
    unsure = [160 <= k < 220 for k in range(400)]
    assert [each is None for each in contact] == unsure
    assert {each for each in contact if each is not None} == {depth_m < 1e-4}
    searched_s, untold_s = analysis.sums()["search_contact_untold"][0]
    assert untold_s == pytest.approx(3.0, abs=0.06)
    assert searched_s == pytest.approx(20.0, abs=0.06)
    speeds = [each.theta_dot_rad_s for each in observables[40:]]
    assert speeds == pytest.approx([0.1] * len(speeds)), "it is followed along the wall meanwhile"


@pytest.mark.parametrize(
    ("seconds", "parts_s"), [(0.3, [(0.0, 19.95)]), (3.0, [(0.0, 7.95), (11.0, 19.95)])]
)
def test_a_contact_goes_on_over_a_moment_and_is_cut_by_longer(seconds, parts_s):
    _, _, events = unsure_for(seconds, 1e-5)
    episodes = [event for event in events if isinstance(event, Episode)]
    spans = [
        ((each.start_ns - START_NS) / 1e9, (each.end_ns - START_NS) / 1e9) for each in episodes
    ]
    assert np.array(spans) == pytest.approx(np.array(parts_s))
    assert not any(each.complete for each in episodes)


def test_a_deviation_that_is_not_known_counts_as_none():
    track, _, _ = folded(1, 60.0, RATE_HZ, reversal=REVERSAL, lost=0.0)
    plain = analyse(track.states())[0].sums()
    unknown = analyse([replace(state, head_sd_m=np.nan) for state in track.states()])[0].sums()
    for name, sums in plain.items():
        np.testing.assert_array_equal(sums, unknown[name])
