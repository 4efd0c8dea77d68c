"""Forecasts: calibrated on simulated worms, better than memoryless ones, and silent when blind."""

from dataclasses import astuple, replace
from math import isnan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_passages import observables, passages

from worm_model.boundary_walk.fast_first_passage import FastFirstPassage
from worm_model.boundary_walk.first_passage import SolvedWalk
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState
from worm_model.inference.comparison import ModelParameters
from worm_model.inference.forecast import QUANTILES, Forecaster, direction_of
from worm_model.inference.scores import Scores
from worm_model.inference.trial_model import TrialModel
from worm_model.simulator.rig import Rig
from worm_msgs_py import Attempt, Episode, EpisodeKind, Observables, Quantity, Visit, Where

PAPER = WalkParameters()
FORECASTER = Forecaster(PAPER, (("d_c", True), ("v_b", False)))
S = 1_000_000_000
GEOMETRY = Rig(exit_width_mm=1.0).geometry()
W_S = Quantity("w_s", PAPER.exit_arc_mm, unit="mm")
NUMBERS = ("median_s", "low_s", "high_s", "within_10_s", "within_30_s", "within_60_s")


def told(forecast):
    return [getattr(forecast, name) for name in NUMBERS]


@pytest.mark.parametrize(
    "walk",
    [
        PAPER,
        replace(PAPER, rule=ReversalRule.RATE, reversal=0.02, exit_width_mm=3.0),
        replace(PAPER, rule=ReversalRule.PER_PHASE, speed_mm_s=1.07, hop_may_land=False),
    ],
    ids=["the paper's", "few reversals", "hops never land"],
)
def test_forecasts_are_calibrated_and_beat_memoryless_ones(walk):
    scores, within_interval, n = Scores(), 0, 0
    mean_s = Forecaster(walk, ()).mean_s
    for forecast, law, times in passages(walk, states=25, walks=5, seed=8):
        for time_s in times:
            scores.push(law.within, time_s, mean_s, law.atoms(time_s)[0].tolist())
        # A quantile may be a time that has a probability of its own.
        inside = (times > forecast.low_s - 1e-3) & (times < forecast.high_s + 1e-3)
        within_interval += np.count_nonzero(inside)
        n += len(times)
    named = dict(scores.named())
    assert named["pit_p"] > 0.01
    assert named["crps_gain_s"] > 0.0
    assert within_interval / n > 0.9 - 3.0 * np.sqrt(0.09 / n)


@settings(max_examples=15)
@given(st.floats(0.2, 2 * pi - 0.2), st.sampled_from([-1.0, 1.0]), st.booleans())
def test_a_mirrored_head_has_the_same_forecast(theta, direction, contact):
    one, _ = FORECASTER(observables(theta, direction, contact))
    other, _ = FORECASTER(observables(-theta, -direction, contact))
    assert told(other) == pytest.approx(told(one), rel=1e-3, abs=1e-3)
    assert other.direction == -one.direction


@settings(max_examples=15)
@given(st.floats(0.2, 2 * pi - 0.2), st.sampled_from([-1.0, 1.0]), st.booleans())
def test_quantiles_and_probabilities_are_in_order(theta, direction, contact):
    forecast, law = FORECASTER(observables(theta, direction, contact))
    assert 0.0 <= forecast.low_s <= forecast.median_s <= forecast.high_s
    assert 0.0 <= forecast.within_10_s <= forecast.within_30_s <= forecast.within_60_s <= 1.0
    assert law.within(forecast.high_s) >= 0.95 - 1e-3


@settings(max_examples=40)
@given(
    st.sampled_from(
        [
            FORECASTER,
            Forecaster(replace(PAPER, rule=ReversalRule.RATE, reversal=0.02, speed_mm_s=1.0), ()),
            Forecaster(replace(PAPER, mean_slide_mm=0.5, mean_hop_mm=0.3, reversal=0.1), ()),
        ]
    ),
    st.floats(0.1, 2 * pi - 0.1),
    st.sampled_from([-1.0, 1.0]),
    st.booleans(),
)
def test_what_is_told_is_the_exact_law_to_two_parts_in_a_thousand(forecaster, theta, way, contact):
    forecast, law = forecaster(observables(theta, way, contact))
    quantiles_s = forecast.low_s, forecast.median_s, forecast.high_s
    for probability, told_s in zip(QUANTILES, quantiles_s, strict=True):
        around = law.within([max(told_s - 0.02, 0.0), told_s + 0.02])
        assert around[0] - 2e-3 <= probability <= around[1] + 2e-3
    exact = law.within([10.0, 30.0, 60.0])
    assert told(forecast)[3:] == pytest.approx(exact.tolist(), abs=2e-3)


def test_a_quantile_beyond_the_longest_time_is_that_of_the_exact_law():
    """Hops fly over the exit and slides are short: from there it takes far longer than anywhere."""
    walk = replace(PAPER, mean_slide_mm=0.05, mean_hop_mm=5.0, hop_may_land=False, reversal=0.4)
    solved = SolvedWalk(walk)
    quick = FastFirstPassage(solved, 60.0)
    state = WalkState(2.0, Direction.COUNTER_CLOCKWISE, Phase.HOP)
    for probability in (0.95, 0.99, 0.999):
        ((told_s,), _) = quick(state, [probability], [])
        assert solved.forecast(state).within(told_s) == pytest.approx(probability, abs=1e-3)


def test_a_head_that_slides_to_the_exit_finds_it_sooner_than_one_that_slides_away():
    near = 0.5 * PAPER.exit_arc_mm / 10.0 + 0.1  # 1 mm of wall before the exit
    to, away = (FORECASTER(observables(near, direction, True))[0] for direction in (-1.0, 1.0))
    assert to.within_10_s > np.exp(-1.0 / 1.95), "it may slide all the way"
    assert to.median_s < away.median_s
    assert to.low_s == pytest.approx(1.0 / 2.02, rel=1e-3)


def test_a_head_on_the_part_of_the_exits_arc_that_is_wall_is_taken_to_be_at_its_edge():
    """w_s is wider than W."""
    inwards, outwards = (FORECASTER(observables(0.08, d, True))[0] for d in (-1.0, 1.0))
    assert told(inwards)[:3] == pytest.approx([0.0] * 3, abs=1e-3)
    assert inwards.within_10_s == pytest.approx(1.0)
    assert outwards.median_s > 1.0


@pytest.mark.parametrize(
    "blind",
    [
        observables(1.0, 1.0, True, where=Where.PASSAGE),
        observables(1.0, 1.0, True, where=Where.UNKNOWN),
        observables(1.0, 1.0, None),
        observables(float("nan"), 1.0, True),
        observables(1.0, float("nan"), True),
    ],
    ids=["in the passage", "lost", "no contact told", "no angle", "no direction"],
)
def test_where_the_state_is_not_known_there_is_no_forecast(blind):
    forecast, law = FORECASTER(blind)
    assert law is None
    assert all(map(isnan, told(forecast)))
    assert forecast.measured == (("d_c", True), ("v_b", False))


@pytest.mark.parametrize(
    ("theta_dot", "psi_b", "expected"),
    [(0.2, -0.5, 1.0), (-0.2, 0.5, -1.0), (float("nan"), 0.5, 1.0), (0.0, -0.5, -1.0)],
)
def test_the_direction_is_that_of_the_motion_and_before_it_is_known_that_of_the_body(
    theta_dot, psi_b, expected
):
    assert direction_of(Observables(0, 0, theta_dot_rad_s=theta_dot, psi_b_rad=psi_b)) == expected
    assert isnan(direction_of(Observables(0, 0)))


def started(**parameters):
    model = TrialModel(ModelParameters(**parameters))
    model.set_geometry(GEOMETRY)
    model.take_summary([W_S], 0)
    return model


def forecasts(model, frames):
    return [model.take_state(frame) for frame in frames]


def frames(stamps_s, theta=2.0, contact=True, where=Where.CHAMBER_A):
    return [
        observables(theta, 1.0, contact, where, round(stamp * S), number)
        for number, stamp in enumerate(stamps_s)
    ]


def test_there_is_a_forecast_every_tenth_of_a_second_of_the_stamps_whatever_the_frame_rate():
    for rate in (10.0, 24.0, 60.0):
        made = [f for f in forecasts(started(), frames(np.arange(0.0, 5.0, 1 / rate))) if f]
        assert len(made) == 50
    slow = [f for f in forecasts(started(), frames(np.arange(0.0, 5.0, 0.5))) if f]
    assert [f.stamp_ns for f in slow] == [round(t * S) for t in np.arange(0.0, 5.0, 0.5)]


def test_before_the_exit_is_known_there_is_none():
    model = TrialModel(ModelParameters())
    model.set_geometry(GEOMETRY)
    assert forecasts(model, frames([0.0, 1.0])) == [None, None]
    assert model.take_summary([Quantity("w_s", None, why="no exit in view")], 0) is None
    assert forecasts(model, frames([2.0])) == [None]


def visit(first_s, end_s, chamber="chamber_a", found=True):
    tau_s = end_s - first_s if found else float("nan")
    return Visit(chamber, 0, round(end_s * S), round(first_s * S), 0.0, tau_s)


def scores(model):
    results = model.take_summary([W_S, Quantity("d_c", 1.95, 1.8, 2.1, 60, "mm")], 100 * S)
    return dict(results[0].scores)


def test_a_passage_is_scored_by_the_first_forecast_after_its_first_contact():
    model = started()
    forecasts(model, frames([0.0], contact=False))
    (before,) = forecasts(model, frames([5.0], theta=2.0))
    forecasts(model, frames([6.0, 20.0], theta=4.0))
    model.take_event(visit(5.0, 25.0))
    expected = Scores()
    slower = Forecaster(replace(PAPER, speed_mm_s=PAPER.speed_mm_s * np.sin(np.radians(32))), ())
    law = slower(observables(2.0, 1.0, True))[1]
    expected.push(law.within, 20.0, slower.mean_s, law.atoms(60.0)[0].tolist())
    assert before.stamp_ns == 5 * S
    assert scores(model) == pytest.approx(dict(expected.named()), nan_ok=True)


@pytest.mark.parametrize(
    "ended",
    [
        visit(5.0, 25.0, found=False),
        visit(5.0, 25.0, chamber="chamber_b"),
        visit(7.0, 25.0),
    ],
    ids=["cut short", "in the other chamber", "first touched after the forecast"],
)
def test_a_passage_without_a_forecast_of_its_own_is_not_scored(ended):
    model = started()
    forecasts(model, frames([5.0, 6.0]))
    model.take_event(ended)
    assert scores(model) == {}
    forecasts(model, frames([30.0, 31.0]))
    model.take_event(visit(30.0, 40.0))
    assert (scores(model)["passages"], scores(model)["passages_unscored"]) == (1.0, 1.0)


def test_a_withdrawal_ends_the_promise_that_the_next_visit_is_scored_by():
    model = started()
    forecasts(model, frames([5.0]))
    model.take_event(visit(5.0, 25.0))
    forecasts(model, frames([26.0, 27.0]))
    model.take_event(Attempt("chamber_a", 25 * S, 28 * S, 1e-3, True))
    forecasts(model, frames([40.0], where=Where.CHAMBER_B))
    model.take_event(visit(40.0, 50.0, "chamber_b"))
    assert scores(model)["passages"] == 2.0


def test_reversals_from_phase_to_phase_reach_the_fit():
    model = started(rule="per_phase")
    theta, stamp = 1.0, 0
    for number in range(40):
        kind = EpisodeKind.CONTACT if number % 2 == 0 else EpisodeKind.FREE
        turn = 0.2 if number % 4 < 2 else -0.2
        model.take_state(observables(theta, 1.0, True, stamp_ns=stamp))
        theta += turn
        model.take_state(observables(theta, 1.0, True, stamp_ns=stamp + S))
        model.take_event(Episode("chamber_a", kind, stamp, stamp + S, 2e-3))
        stamp += S
    comparison, _ = model.take_summary([W_S, Quantity("d_c", 1.95, 1.8, 2.1, 60)], stamp)
    used = dict(comparison.parameters)
    assert used["reversal_per_phase_is_measured"] == 1.0
    assert used["reversal"] == pytest.approx(0.5, abs=0.02)
    assert "d_c" in {q.name for q in comparison.quantities}
    assert astuple(comparison.quantities[0])[0] == "tau_h"
