"""Trials are pooled from their episodes, attempts and frames, and intervals allow for trials."""

from dataclasses import replace

import numpy as np
import pytest
from escaped_trials import escaped_trial
from escaping_worm import LEAN, Worm
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.pooling import Pool, group_widths_mm, pooled_trial
from worm_analysis.pooling.pool import BY_TRIALS, NO_INTERVAL, WITHIN_TRIALS
from worm_analysis.report.report_data import of_pool, of_trial
from worm_analysis.results import read_results
from worm_analysis.statistics.block_jackknife import JackknifeSettings
from worm_analysis.summary.settings import EstimateSettings
from worm_msgs_py.errors import ReportError

pytestmark = pytest.mark.xdist_group("pool")  # what they share is made once

WIDTHS = (1.0, 1.0, 1.0, 3.0, 3.0, 3.0)
DURATIONS_S = (500.0, 200.0, 300.0, 500.0, 300.0, 200.0)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Six trials of unequal length, of two widths."""
    folder = tmp_path_factory.mktemp("trials")
    return [
        read_results(escaped_trial(folder / f"{k}", Worm(exit_width_mm=w, seed=20 + k), seconds))
        for k, (w, seconds) in enumerate(zip(WIDTHS, DURATIONS_S, strict=True))
    ]


@pytest.fixture(scope="module")
def trials(results):
    return [pooled_trial(item, f"worm {k}", f"{k}") for k, item in enumerate(results)]


@pytest.fixture(scope="module")
def pooled(trials):
    return numbers(Pool.of(trials))


def numbers(pool):
    return pool.numbers


def test_a_pool_of_one_trial_has_the_trials_own_numbers_and_intervals(results, trials):
    for trial, own in zip(trials[:3], results[:3], strict=True):
        pool = Pool.of([trial])
        assert list(pool.numbers) == [quantity.name for quantity in own.quantities]
        for quantity in own.quantities:
            assert pool.numbers[quantity.name].quantity == quantity, quantity.name


def test_no_interval_is_narrower_than_its_trials_alone_allow(trials):
    """Trials left out in turn widen what blocks of time and counts give, and never narrow it."""
    pool = Pool.of(trials)
    by_trials = numbers(pool)
    blocks_only = EstimateSettings(jackknife=JackknifeSettings(fewest_trials=100))
    told = 0
    for name, within in numbers(replace(pool, settings=blocks_only)).items():
        item, alike = by_trials[name], within.quantity
        if item.by == BY_TRIALS and None not in (item.quantity.low, alike.low, alike.high):
            assert item.quantity.low <= alike.low
            assert item.quantity.high >= alike.high
            told += 1
    assert told > 20


def test_pooled_fractions_and_means_are_of_all_events_not_of_the_trials_means(results, pooled):
    found = pooled
    attempts = [item.passages["complete"] == 1.0 for item in results]
    attempts = [
        rows & (item.passages["record"] == "attempt")
        for rows, item in zip(attempts, results, strict=True)
    ]
    wins = [item.passages["success"][rows] for rows, item in zip(attempts, results, strict=True)]
    assert found["success"].quantity.value == pytest.approx(np.concatenate(wins).mean())
    assert found["success"].quantity.n == sum(map(len, wins))
    assert found["success"].quantity.value != pytest.approx(np.mean([w.mean() for w in wins]))
    finds = [item.passages["tau_h_s"] for item in results]
    assert found["tau_h"].quantity.n == int(np.isfinite(np.concatenate(finds)).sum())


def test_the_worms_laws_are_found_in_the_pool(pooled):
    found = {name: number.quantity for name, number in pooled.items()}
    assert found["success"].low < 0.6 < found["success"].high
    assert found["psi_b_positive_peak"].value == pytest.approx(np.degrees(LEAN), abs=2)
    assert found["psi_b_negative_peak"].value == pytest.approx(-np.degrees(LEAN), abs=2)
    assert found["reversal_per_cycle"].value == pytest.approx(0.05, abs=0.03)
    assert found["d_c"].value == pytest.approx(1.95, rel=0.15)


def test_c_theta_is_pooled_over_pairs(results, trials):
    correlation = of_pool(Pool.of(trials[:2])).correlation
    pairs = np.array([item.correlation.pairs for item in results[:2]])
    products = np.array([np.nan_to_num(item.correlation.c) for item in results[:2]]) * pairs
    known = pairs.sum(axis=0) > 0
    np.testing.assert_array_equal(correlation.pairs, pairs.sum(axis=0))
    np.testing.assert_allclose(
        correlation.c[known], products.sum(axis=0)[known] / pairs.sum(axis=0)[known]
    )


def test_the_order_of_the_trials_does_not_matter(trials):
    first, second = numbers(Pool.of(trials[:4])), numbers(Pool.of(trials[3::-1]))
    for name, number in first.items():
        assert second[name].quantity.n == number.quantity.n
        if number.quantity.value is not None:
            assert second[name].quantity.value == pytest.approx(number.quantity.value, rel=1e-6)


def test_mirrored_trials_turn_the_other_way_and_have_the_same_law(tmp_path, trials):
    worm = Worm(exit_width_mm=WIDTHS[1], seed=21)
    mirrored = read_results(escaped_trial(tmp_path / "mirror", worm, DURATIONS_S[1], mirrored=True))
    here, there = numbers(Pool.of([trials[1]])), numbers(Pool.of([pooled_trial(mirrored)]))
    for name in ("d_c", "v_w", "v_b", "success", "theta_dot_psi_b_correlation"):
        if here[name].quantity.value is not None:
            assert there[name].quantity.value == pytest.approx(here[name].quantity.value, rel=0.02)
    np.testing.assert_allclose(
        np.sort(pooled_trial(mirrored).points["theta_h0"]),
        np.sort(-trials[1].points["theta_h0"]),
        atol=1e-6,
    )


def test_five_trials_are_left_out_in_turn_and_fewer_rest_on_their_blocks(trials):
    assert Pool.of(trials[:5]).numbers["d_c"].by == BY_TRIALS
    assert Pool.of(trials[:4]).numbers["d_c"].by == WITHIN_TRIALS
    assert Pool.of(trials[:4]).numbers["frames_untracked"].by == NO_INTERVAL


def test_trials_that_are_all_alike_are_as_one_long_trial(trials):
    """Their numbers are as sure as one trial of six times the length, and no surer."""
    one = Pool.of([trials[0]]).numbers
    alike = Pool.of([replace(trials[0], provenance={}) for _ in range(6)]).numbers
    for name in ("v_b", "v_w", "d_c", "tau_h", "contact_fraction"):
        same, own = alike[name].quantity, one[name].quantity
        assert same.value == pytest.approx(own.value)
        ratio = (same.high - same.low) / (own.high - own.low)
        assert 0.2 < ratio < 0.6, name  # 1/√6 with some play of Student's law


def test_trials_that_differ_have_a_wider_interval_than_their_blocks(trials):
    """The same trials, but every other one twice as fast."""

    def faster(trial):
        sums = dict(trial.sums)
        sums["v_b"] = sums["v_b"] * [1.0, 2.0, 1.0]
        return replace(trial, sums=sums, provenance={})

    plain = Pool.of([replace(trial, provenance={}) for trial in trials])
    mixed = Pool.of([faster(t) if k % 2 else t for k, t in enumerate(plain.trials)])
    widths = [q.high - q.low for q in (p.numbers["v_b"].quantity for p in (plain, mixed))]
    assert widths[1] > 3 * widths[0]


def test_each_width_is_a_pool_of_its_own(trials, pooled):
    pool = Pool.of(trials)
    assert [(part.width_mm, len(part.trials)) for part in pool.by_width] == [(1.0, 3), (3.0, 3)]
    whole, parts = pooled, [numbers(part) for part in pool.by_width]
    assert whole["success"].quantity.n == sum(part["success"].quantity.n for part in parts)
    assert [part["beta"].quantity.paper for part in parts] == [0.50, 0.42]
    assert whole["beta"].quantity.paper is None


@given(st.lists(st.floats(0.2, 6.0), min_size=1, max_size=12), st.randoms())
def test_trials_of_one_exit_are_a_group_whatever_the_paper_has(widths, shuffle):
    """A W is never replaced by one that is further away than a calibration errs."""
    groups = group_widths_mm(widths)
    for width, group in zip(widths, groups, strict=True):
        assert abs(group - width) <= max(0.09 * width, 0.031)
    order = list(range(len(widths)))
    shuffle.shuffle(order)
    assert group_widths_mm([widths[k] for k in order]) == [groups[k] for k in order]
    assert group_widths_mm([1.8, 2.0, 1.81]) == [1.805, 2.0, 1.805]


def test_a_width_that_is_not_known_is_in_no_group(trials):
    unknown = replace(trials[0], exit_width_mm=float("nan"))
    assert np.isnan(group_widths_mm([float("nan")])[0])
    pool = Pool.of([unknown, trials[3]])
    assert [part.width_mm for part in pool.by_width] == [3.0]
    assert len(pool.trials) == 2


def test_a_trial_that_is_there_twice_is_refused(trials):
    twin = replace(trials[0], directory="again")
    with pytest.raises(ReportError, match="again: is the same trial as 0"):
        Pool.of([*trials, twin])


@pytest.mark.parametrize("name", ["v_b", "c_theta", "d_c"])
def test_sums_of_another_version_are_refused_in_a_line(trials, name):
    old = replace(trials[1], sums={**trials[1].sums, name: trials[1].sums[name][:, :1]})
    for pool in (Pool.of([old]), Pool.of([trials[0], old])):
        with pytest.raises(ReportError, match=r"1: sums of another version \(\w+: .*run `worm"):
            _ = pool.numbers


def test_chambers_of_different_size_are_refused(trials):
    small = replace(trials[1], radius_mm=5.0, directory="small")
    with pytest.raises(ReportError, match=r"small: its chamber has R = 5 mm"):
        Pool.of([trials[0], small])


def test_c_theta_at_different_lags_is_not_pooled(trials):
    coarse = replace(trials[1], lag_s=trials[1].lag_s * 2)
    evidence = of_pool(Pool.of([trials[0], coarse]))
    assert evidence.correlation is None
    assert evidence.quantity("t_per").value is None


def test_the_answer_to_the_joint_question_comes_back_from_the_summary(results):
    """Each observation for each rule and speed, with an interval that has no end where it has none.

    JSON knows no infinity.
    """
    needs = results[0].comparison.needs
    assert {need.observation for need in needs} >= {"t_per", "tau_h", "n_s"}
    assert {need.rule for need in needs} == {"per_cycle", "per_phase", "rate"}
    assert all(need.low <= need.high for need in needs if np.isfinite(need.low))


def test_one_trials_report_keeps_the_numbers_of_its_summary(results):
    evidence = of_trial(results[0])
    assert evidence.quantity("d_c") == results[0].quantity("d_c")
    assert evidence.counted(3, "visits") == "n\u00a0=\u00a03 visits"
