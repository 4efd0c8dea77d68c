"""The walk fitted to a trial: reversals counted under each rule, and where each number is from."""

from math import radians, sin

import numpy as np
import pytest

from worm_model.boundary_walk.parameters import ReversalRule
from worm_model.inference.fit import REVERSAL_NAMES, Speed, fit_walk
from worm_model.inference.reversal_counts import PhaseDirections, Reversals
from worm_model.simulator.rig import Rig
from worm_msgs_py import Episode, EpisodeKind, Quantity
from worm_msgs_py.intervals import fraction

GEOMETRY = Rig(exit_width_mm=1.0).geometry()
W_S = Quantity("w_s", 1.8027756377319946, unit="mm")
R_M = 0.01


def phases(rule, reversal, count, seed):
    """Return signed turns and episodes of a walk under a rule, 0.1 s a millimetre."""
    random = np.random.default_rng(seed)
    direction, found, stamp_ns = 1, [], 0
    for number in range(count):
        contact = number % 2 == 0
        length_mm = random.exponential(1.95 if contact else 1.46) + 0.01
        end_ns = stamp_ns + round(length_mm * 1e8)
        kind = EpisodeKind.CONTACT if contact else EpisodeKind.FREE
        episode = Episode("chamber_a", kind, stamp_ns, end_ns, length_mm * 1e-3)
        found.append((episode, direction * length_mm * 1e-3 / R_M))
        turns = rule is ReversalRule.PER_PHASE or not contact
        direction *= -1 if turns and random.random() < reversal else 1
        stamp_ns = end_ns
    return found


def counted(episodes):
    reversals = Reversals()
    for episode, turn_rad in episodes:
        reversals.push(episode, turn_rad)
    return reversals


def test_the_counts_tell_a_walk_that_turns_after_hops_from_one_that_turns_after_both():
    per_cycle = counted(phases(ReversalRule.PER_CYCLE, 0.3, 2001, 0))
    assert per_cycle.after_slide == (0, 1000)
    assert fraction(*per_cycle.after_hop)[0] == pytest.approx(0.3, abs=0.06)
    per_phase = counted(phases(ReversalRule.PER_PHASE, 0.3, 2001, 1))
    for turned, changes in (per_phase.after_slide, per_phase.after_hop):
        assert turned / changes == pytest.approx(0.3, abs=0.06)


def test_intervals_of_counted_reversals_cover_the_truth():
    covered = sum(
        low <= 0.2 <= high
        for _, low, high in (
            counted(phases(ReversalRule.PER_PHASE, 0.2, 120, seed)).per_phase()
            for seed in range(200)
        )
    )
    assert covered >= 184  # 95 % of 200, less two and a half standard deviations


def test_a_break_in_the_track_and_an_episode_below_the_resolution_say_nothing():
    episodes = phases(ReversalRule.PER_PHASE, 1.0, 6, 3)
    whole = counted(episodes)
    assert whole.per_phase()[0] == 1.0
    assert whole.changes == 5
    assert counted(episodes[:3] + episodes[4:]).changes == 3, "a gap between two of them"
    cut = [(e if i != 2 else Episode(*_but_cut(e)), t) for i, (e, t) in enumerate(episodes)]
    assert counted(cut).changes == 3
    blind = Reversals(resolution_m=1.0)
    for episode, turn_rad in episodes:
        blind.push(episode, turn_rad)
    assert blind.changes == 0
    assert np.isnan(blind.per_phase()).all()


def _but_cut(e):
    return (
        e.chamber,
        e.kind,
        e.start_ns,
        e.end_ns,
        e.distance_m,
        e.delta_r_m,
        e.incidence_rad,
        False,
    )


def test_the_sign_of_an_episode_comes_from_the_frames_at_its_ends():
    directions = PhaseDirections()
    for stamp_ns, theta in ((0, 0.0), (10, 0.1), (20, 0.3), (30, 0.2)):
        directions.see(stamp_ns, theta)
    first = Episode("chamber_a", EpisodeKind.CONTACT, 0, 20, 0.003)
    second = Episode("chamber_a", EpisodeKind.FREE, 20, 30, 0.001)
    assert directions.turn_rad(first) == pytest.approx(0.3)
    assert directions.turn_rad(second) == pytest.approx(-0.1)
    assert np.isnan(directions.turn_rad(first)), "its frames are forgotten"
    directions.forget()
    assert np.isnan(directions.turn_rad(second))


def summary(**values):
    return [W_S, *(Quantity(n, v, v and 0.8 * v, v and 1.2 * v, 50) for n, v in values.items())]


def test_every_rule_and_speed_has_its_own_number_with_its_interval():
    fit = fit_walk(
        summary(d_c=3.0, d_nc=1.0, v_b=1.5, v_w=2.4, reversal_per_cycle=0.18, reversal_rate=0.05),
        GEOMETRY,
    )
    assert fit.exit_width_mm == pytest.approx(1.0)
    for rule, reversal in zip(ReversalRule, (0.18, 0.1, 0.05), strict=True):
        for speed, v in ((Speed.TANGENTIAL, 1.5), (Speed.SWIMMING, 2.4)):
            walk = fit.walk(rule, speed)
            assert (walk.speed_mm_s, walk.rule) == (v, rule)
            assert walk.reversal == pytest.approx(reversal)  # 2 · 0.1 · 0.9 = 0.18
            assert all(is_own for _, is_own in fit.origins(rule, speed))
    low, high = fit.numbers["d_c"].low, fit.numbers["d_c"].high
    assert (low, high) == pytest.approx((2.4, 3.6))
    assert fit.numbers["reversal_per_phase"].low < 0.1 < fit.numbers["reversal_per_phase"].high


def test_reversals_counted_phase_by_phase_are_used_where_there_are_enough():
    few = counted(phases(ReversalRule.PER_PHASE, 0.5, 5, 0))
    many = counted(phases(ReversalRule.PER_PHASE, 0.5, 500, 0))
    trial = summary(reversal_per_cycle=0.18)
    assert fit_walk(trial, GEOMETRY, few).numbers["reversal_per_phase"].value == pytest.approx(0.1)
    numbers = fit_walk(trial, GEOMETRY, many).numbers
    assert numbers["reversal_per_phase"].value == pytest.approx(0.5, abs=0.08)
    assert numbers["reversal_per_cycle"].value == 0.18


def test_what_a_trial_does_not_give_or_cannot_be_is_the_papers_and_said_to_be():
    fit = fit_walk(summary(d_c=None, d_nc=1.0, v_b=0.0, reversal_per_cycle=0.0), GEOMETRY)
    assert fit.walk(ReversalRule.PER_CYCLE, Speed.SWIMMING).speed_mm_s == 2.02
    assert fit.numbers["v_b"].value == pytest.approx(2.02 * sin(radians(32)))
    own = dict(fit.origins(ReversalRule.PER_CYCLE, Speed.TANGENTIAL))
    assert own == {"d_c": False, "d_nc": True, "v_b": False, "reversal_per_cycle": True}
    rate = fit.numbers[REVERSAL_NAMES[ReversalRule.RATE]]
    assert not rate.is_measured
    assert rate.value == pytest.approx(0.30 / ((1.95 + 1.46) / 2.02))
