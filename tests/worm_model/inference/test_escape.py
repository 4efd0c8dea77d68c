"""Escapes: finding, entering, withdrawing and searching again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_model.inference.escape import EscapeTimes, escape_time
from worm_msgs_py import Attempt, Visit

S = 1_000_000_000
NAN = float("nan")


def test_sixty_per_cent_of_success_take_two_thirds_of_a_search_more():
    escape = escape_time(50.0, 50.0, (0.6, 0.5, 0.75))
    assert escape.mean_s == pytest.approx((50 + 50 * 2 / 3, 50 + 50 / 3, 100.0))
    assert escape.ratio == pytest.approx((5 / 3, 4 / 3, 2.0))


@given(st.floats(0.05, 1.0), st.floats(1.0, 100.0), st.floats(0.0, 100.0), st.floats(0.0, 9.0))
def test_the_mean_is_that_of_entries_until_one_succeeds(success, finding, again, lost):
    """First-step analysis: an escape from the exit's edge is a renewal."""
    value = escape_time(finding, again, (success, NAN, NAN), lost).mean_s[0]
    after_failure = (lost + again) / success - lost  # solves x = again + (1 − s)(lost + x)
    assert value == pytest.approx(finding + (1 - success) * (lost + after_failure))
    assert value >= finding


def test_the_law_holds_for_simulated_entries():
    random = np.random.default_rng(5)
    failures = random.geometric(0.6, 20000) - 1
    times = random.exponential(50.0, 20000) + np.array(
        [random.exponential(36.0, n).sum() + 1.5 * n for n in failures]
    )
    expected = escape_time(50.0, 36.0, (0.6, NAN, NAN), 1.5).mean_s[0]
    assert times.mean() == pytest.approx(expected, abs=4 * times.std() / np.sqrt(20000))


def test_where_success_may_be_nought_the_upper_end_is_open_and_unknown_success_gives_nothing():
    assert escape_time(50.0, 36.0, (0.1, 0.0, 0.4)).mean_s[2] == float("inf")
    assert np.isnan(escape_time(50.0, 36.0, (NAN, NAN, NAN)).mean_s).all()


def visit(chamber, first, end, tau=None):
    tau_s = NAN if tau is None else tau
    return Visit(chamber, 0, end * S, first * S, 0.0, tau_s)


def attempt(chamber, start, end, success, complete=True):
    return Attempt(chamber, start * S, end * S, 1e-3, success, complete=complete)


def test_an_escape_lasts_from_first_contact_to_the_entry_that_the_body_follows():
    times = EscapeTimes()
    for event in (
        visit("chamber_a", 10, 40, 30.0),
        attempt("chamber_a", 40, 42, False),
        attempt("chamber_a", 60, 64, False),
        attempt("chamber_a", 90, 95, True),
        visit("chamber_b", 110, 130, 20.0),
        attempt("chamber_b", 130, 133, True),
    ):
        times.push(event)
    assert times.escapes == 2
    value, low, high = times.mean_s(140 * S)
    assert value == pytest.approx((80 + 20) / 2)
    assert low < value < high
    assert times.lost_s == pytest.approx(3.0)


def test_what_is_under_way_or_was_cut_short_counts_as_time_and_not_as_an_escape():
    times = EscapeTimes()
    times.push(visit("chamber_a", 0, 50))
    times.push(visit("chamber_b", 60, 70, 10.0))
    times.push(attempt("chamber_b", 70, 71, False))
    times.push(attempt("chamber_b", 75, 76, False, complete=False))
    assert times.escapes == 0
    assert np.isnan(times.mean_s(100 * S)).all()
    times.push(attempt("chamber_b", 90, 91, True))
    assert times.mean_s(100 * S)[0] == pytest.approx(50 + 30)
    times.push(visit("chamber_a", 95, 97, 2.0))
    assert times.mean_s(105 * S)[0] == pytest.approx(50 + 30 + 10)


def test_an_entry_into_the_other_exit_ends_no_escape():
    times = EscapeTimes()
    times.push(visit("chamber_a", 10, 40, 30.0))
    times.push(attempt("chamber_b", 50, 52, True))
    assert times.escapes == 0
    assert np.isnan(times.lost_s)


def test_trials_one_after_the_other_add_up():
    times = EscapeTimes()
    times.push(visit("chamber_a", 0, 30, 30.0))
    times.end_trial(50 * S)
    times.push(attempt("chamber_a", 60, 61, True))
    assert times.escapes == 0, "the search before it was another trial's"
    times.push(visit("chamber_a", 100, 120, 20.0))
    times.push(attempt("chamber_a", 120, 121, True))
    times.end_trial(130 * S)
    assert times.mean_s(0)[0] == pytest.approx(50 + 20)
