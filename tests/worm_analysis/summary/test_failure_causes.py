"""The causes of failures, where contact or stroke of some cannot be told."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.summary.direction_persistence import NotEnoughData
from worm_analysis.summary.failure_causes import share_of_determined, touching_share
from worm_analysis.summary.sums import Sums
from worm_msgs_py.intervals import fraction


def failures(*, touching, without, known, elongating, undetermined=0):
    """Return the sums of a trial's failed attempts."""
    n = touching + without + undetermined
    return {
        "failures_of_unknown_phase": np.array([[n, n - known]], dtype=float),
        "failures_without_contact": np.array([[touching + without, without]], dtype=float),
        "touching": np.array([[without + known, elongating]], dtype=float),
    }


@given(st.integers(10, 400), st.integers(0, 300), st.integers(1, 20))
def test_causes_are_the_same_whatever_part_of_the_strokes_is_known(known, without, unknown_for_one):
    """An unknown phase does not make those that touch fewer beside those that do not."""
    elongating = known // 3
    touching = known * unknown_for_one
    trial = failures(touching=touching, without=without, known=known, elongating=elongating)
    value, low, high = touching_share("touching")(Sums([trial]))
    assert value == pytest.approx(elongating / known * touching / (touching + without))
    assert low <= value <= high
    if unknown_for_one == 1:
        n = touching + without
        assert (value, low, high) == pytest.approx(fraction(elongating, n))


@pytest.mark.parametrize("known", [0, 9])
def test_causes_are_refused_where_few_strokes_are_known(known):
    trial = failures(touching=24, without=11, known=known, elongating=0)
    with pytest.raises(NotEnoughData, match=f"{known} failed attempts in contact with a known"):
        touching_share("touching")(Sums([trial]))


def test_without_a_touch_no_phase_is_needed():
    trial = failures(touching=0, without=30, known=0, elongating=0)
    assert touching_share("touching")(Sums([trial])) == pytest.approx(fraction(0, 30))


@given(st.integers(1, 60), st.integers(1, 60), st.integers(0, 60))
def test_the_interval_holds_whatever_the_untold_failures_are(touching, without, undetermined):
    trial = failures(
        touching=touching, without=without, known=0, elongating=0, undetermined=undetermined
    )
    value, low, high = share_of_determined("failures_without_contact")(Sums([trial]))
    n = touching + without + undetermined
    assert value == pytest.approx(without / (touching + without))
    assert low <= fraction(without, n)[1]
    assert high >= fraction(without + undetermined, n)[2]
    if not undetermined:
        assert (value, low, high) == pytest.approx(fraction(without, n))


@given(st.integers(10, 60), st.integers(1, 60))
def test_the_touching_of_a_phase_may_be_all_of_the_untold_or_none(known, undetermined):
    given_all = {"touching": known, "without": 9, "known": known, "elongating": known // 2}
    value, low, high = touching_share("touching")(Sums([failures(**given_all)]))
    part = undetermined / (known + 9 + undetermined)
    wide = touching_share("touching")(Sums([failures(**given_all, undetermined=undetermined)]))
    assert wide == pytest.approx((value, low * (1 - part), min(high * (1 - part) + part, 1.0)))
    assert wide[1] <= known // 2 / (known + 9 + undetermined)
    assert wide[2] >= (known // 2 + undetermined) / (known + 9 + undetermined)
