"""Model against measurement: exact numbers, with the intervals that the trial's own give them."""

from dataclasses import replace

import numpy as np
import pytest

from worm_model.boundary_walk.mean_passage import mean_again_s, mean_tau_h_s, skips_per_trial
from worm_model.boundary_walk.monte_carlo import simulate_walks
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.state import Direction, WalkState
from worm_model.inference.comparison import (
    ModelParameters,
    can_compare,
    compare_with_walk,
    has_exit,
)
from worm_model.inference.escape import EscapeTimes
from worm_model.inference.fit import fit_walk
from worm_model.simulator.rig import Rig
from worm_msgs_py import Attempt, Quantity, Visit

GEOMETRY = Rig(exit_width_mm=1.0).geometry()
UNITS = {"v_b": "mm/s", "v_w": "mm/s", "reversal_per_cycle": "1", "tau_h": "s", "n_s": "per 30 min"}
S = 1_000_000_000


def summary(interval=0.0, **values):
    measured = {"w_s": 1.8027756377319946} | values
    return [
        Quantity(
            name, value, value and value * (1 - interval), value and value * (1 + interval),
            unit=UNITS.get(name, "mm"), why="" if value is not None else "not enough data",
        )
        for name, value in measured.items()
    ]  # fmt: skip


MEASURED = summary(d_c=3.0, d_nc=1.0, v_b=1.5, reversal_per_cycle=0.1, tau_h=40.0)
WALK = WalkParameters(mean_slide_mm=3.0, mean_hop_mm=1.0, speed_mm_s=1.5, reversal=0.1)


def compared(quantities, parameters=None, **more):
    return compare_with_walk(
        quantities, fit_walk(quantities, GEOMETRY), 7, parameters or ModelParameters(), **more
    )


def by_name(comparison):
    return {quantity.name: quantity for quantity in comparison.quantities}


def test_the_walk_runs_with_the_trials_own_numbers():
    comparison, correlation = compared(MEASURED)
    tau = by_name(comparison)["tau_h"]
    assert tau.measured == 40.0
    carlo = simulate_walks(WALK, 4000, 3).mean_tau_h_s()
    assert tau.modelled == pytest.approx(carlo.value, abs=3 * (carlo.high - carlo.low) / 3.92)
    used = dict(comparison.parameters)
    assert used["mean_slide_m"] == pytest.approx(3e-3)
    assert used["W_m"] == pytest.approx(1e-3)
    assert used["exit_arc_m"] == pytest.approx(1.8027756e-3)
    assert {used[f"{n}_is_measured"] for n in ("d_c", "d_nc", "v_b", "reversal_per_cycle")} == {1.0}
    assert comparison.stamp_ns == 7
    assert correlation.c[0] == pytest.approx(1.0)
    assert np.all(np.diff(correlation.c) < 0)
    assert correlation.lag_s[-1] == pytest.approx(60.0)


def test_the_choice_of_rule_and_speed_is_the_readers():
    trial = summary(v_w=2.4, v_b=1.5, reversal_per_cycle=0.18, reversal_rate=0.07)
    for rule, reversal in (("per_cycle", 0.18), ("per_phase", 0.1), ("rate", 0.07)):
        for speed, v_m_s in (("v_w", 2.4e-3), ("v_b", 1.5e-3)):
            parameters = ModelParameters(rule=rule, speed=speed)
            used = dict(compared(trial, parameters)[0].parameters)
            assert (used["v_m_s"], used["reversal"]) == pytest.approx((v_m_s, reversal))
            assert [n for n in used if n.startswith("rule_") and used[n]] == [f"rule_{rule}"]


def test_skips_are_told_for_thirty_minutes_as_the_measurement_is():
    """SCIENCE: 0.151 skips a passage of 50.88 s at W = 1 mm, 2.02 mm/s and 0.30 per cycle."""
    n_s = by_name(compared(summary(v_b=2.02, reversal_per_cycle=0.30))[0])["n_s"]
    assert n_s.unit == "per 30 min"
    assert n_s.modelled == pytest.approx(1800 * 0.1505 / 50.8754, rel=2e-3)


def test_a_prediction_is_as_sure_as_what_it_rests_on():
    exact = by_name(compared(MEASURED)[0])["tau_h"]
    assert np.isnan(exact.modelled_low) or exact.modelled_low == exact.modelled_high
    widths = []
    for interval in (0.05, 0.1, 0.2):
        trial = summary(interval, d_c=3.0, d_nc=1.0, v_b=1.5, reversal_per_cycle=0.1)
        for quantity in by_name(compared(trial)[0]).values():
            if quantity.name in ("tau_h", "n_s", "t_per"):
                assert quantity.modelled_low < quantity.modelled < quantity.modelled_high
        tau = by_name(compared(trial)[0])["tau_h"]
        widths.append(tau.modelled_high - tau.modelled_low)
    assert widths == sorted(widths)
    assert widths[1] == pytest.approx(2 * widths[0], rel=0.1)


def test_the_interval_of_a_prediction_covers_what_walks_with_unsure_numbers_would_give():
    """Each number drawn within its interval: 95 % of the predictions lie in theirs."""
    trial = summary(0.15, d_c=3.0, d_nc=1.0, v_b=1.5, reversal_per_cycle=0.2)
    tau = by_name(compared(trial)[0])["tau_h"]
    random = np.random.default_rng(0)
    drawn = 1.0 + 0.15 / 1.96 * random.standard_normal((120, 4))
    times = [
        mean_tau_h_s(replace(WALK, mean_slide_mm=3 * a, mean_hop_mm=b, speed_mm_s=1.5 * c,
                             reversal=0.2 * d))
        for a, b, c, d in drawn
    ]  # fmt: skip
    inside = np.mean([(tau.modelled_low <= t <= tau.modelled_high) for t in times])
    assert inside > 0.95 - 3 * np.sqrt(0.05 * 0.95 / 120)


def test_what_a_walk_was_given_stands_beside_its_interval():
    trial = summary(0.1, d_c=3.0, v_b=1.5, reversal_per_cycle=0.1)
    found = by_name(compared(trial)[0])
    assert found["d_c"].unit == "m"
    assert found["d_c"].measured == found["d_c"].modelled == pytest.approx(3e-3)
    assert found["d_c"].measured_low == pytest.approx(2.7e-3)
    assert found["v_b"].modelled == pytest.approx(1.5e-3)
    assert found["reversal_per_cycle"].measured_high == pytest.approx(0.11)
    assert np.isnan(found["d_nc"].measured)
    assert found["d_nc"].modelled == pytest.approx(1.46e-3), "the paper's"


def test_a_withdrawn_head_searches_from_the_exits_edge():
    edge = 0.5 * WALK.exit_arc_mm / 10 * (1 + 1e-6)
    start = WalkState(edge, Direction.COUNTER_CLOCKWISE)
    carlo = simulate_walks(WALK, 4000, 5, start=start).mean_tau_h_s()
    assert mean_again_s(WALK) == pytest.approx(carlo.value, abs=3 * (carlo.high - carlo.low) / 3.92)


def test_escapes_take_the_searches_after_failed_entries_too():
    trial = [*MEASURED, Quantity("success", 0.5, 0.25, 0.75, 12)]
    times = EscapeTimes()
    times.push(Visit("chamber_a", 0, 40 * S, 0, 0.0, 40.0))
    times.push(Attempt("chamber_a", 40 * S, 42 * S, 1e-3, False))
    times.push(Attempt("chamber_a", 80 * S, 82 * S, 1e-3, True))
    found = by_name(compared(trial, escapes=times)[0])
    tau, again = mean_tau_h_s(WALK), mean_again_s(WALK)
    assert found["tau_escape"].modelled == pytest.approx(tau + again + 2.0)
    assert found["tau_escape"].modelled_low == pytest.approx(tau + (again + 2.0) / 3)
    assert found["tau_escape"].modelled_high == pytest.approx(tau + (again + 2.0) * 3)
    assert found["tau_escape"].measured == pytest.approx(80.0)
    assert found["escape_ratio"].modelled == pytest.approx(1 + (again + 2.0) / tau)
    assert found["escape_ratio"].measured == pytest.approx(2.0)
    assert dict(compared(trial)[0].parameters)["success_is_measured"] == 1.0


def test_without_a_success_rate_the_papers_is_used_and_said_to_be():
    used = dict(compared(MEASURED)[0].parameters)
    assert (used["success"], used["success_is_measured"]) == (0.6, 0.0)
    ratio = by_name(compared(MEASURED)[0])["escape_ratio"]
    assert ratio.modelled > 1.0
    assert np.isnan(ratio.modelled_low)


def test_the_joint_question_is_answered_where_it_is_asked():
    trial = summary(0.1, d_c=3.0, d_nc=1.0, v_b=1.5, reversal_per_cycle=0.1, tau_h=40.0)
    assert compared(trial)[0].needs == ()
    needs = compared(trial, with_needs=True)[0].needs
    assert {n.rule for n in needs} == {rule.value for rule in ReversalRule}
    assert {n.observation for n in needs} == {"reversal", "tau_h"}
    assert all(n.is_measured for n in needs)


def test_without_an_exit_or_anything_measured_there_is_nothing_to_compare():
    assert not can_compare([q for q in MEASURED if q.name != "w_s"])
    assert not can_compare(summary(d_c=None))
    assert has_exit(summary(d_c=None))
    assert not has_exit([])
    assert skips_per_trial(WALK) > 0


@pytest.mark.parametrize(
    "wrong",
    [{"rule": "per_worm"}, {"speed": "c"}, {"lag_step_s": 0.0}, {"forecast_interval_s": 0.0}],
)
def test_parameters_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        ModelParameters(**wrong)
