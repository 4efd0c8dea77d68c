"""What is done in few steps, because it is done often, is what the libraries do in many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from worm_tracker.midline.curve import (
    complex_arc_length,
    cubic_through,
    median_of,
    turn_about,
)

TURNS = st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=80)
BEYOND = 0.1
"""How far beyond the ends, over the length, points are asked for."""


def curve_of(turns):
    steps = 3.0 + np.sin(np.arange(len(turns)))
    return 300.0 + np.cumsum(steps * np.exp(1j * np.cumsum(turns)))


@given(turns=TURNS, longest=st.floats(2.0, 1e3), seed=st.integers(0, 99))
def test_a_cubic_through_points_is_that_of_scipy(turns, longest, seed):
    steps = np.exp(np.random.default_rng(seed).uniform(0.0, np.log(longest), len(turns)))
    curve = 300.0 + np.cumsum(steps * np.exp(1j * np.cumsum(turns)))
    s = complex_arc_length(curve)
    at = s[-1] * np.linspace(-BEYOND, 1 + BEYOND, 57)
    expected = CubicSpline(s, curve)(at)
    assert_allclose(cubic_through(s, curve, at), expected, rtol=1e-9, atol=1e-9 * s[-1])


@given(turns=TURNS, over=st.integers(0, 9))
def test_a_curve_turns_about_a_point_by_all_its_turns_near_it(turns, over):
    d = np.diff(curve_of(turns))
    each = np.concatenate([[0.0], np.angle(d[1:] / d[:-1]), [0.0]])
    sums = [each[max(k - over, 0) : k + over + 1].sum() for k in range(len(each))]
    assert_allclose(turn_about(curve_of(turns), over), sums, atol=1e-9)


def test_no_cubic_goes_through_one_point_twice():
    curve = curve_of([0.1] * 9)
    curve[4] = curve[3]
    with pytest.raises(ValueError, match="two points"):
        cubic_through(complex_arc_length(curve), curve, np.array([1.0]))


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_no_cubic_goes_through_fewer_than_four_points(count):
    with pytest.raises(ValueError, match="four points"):
        cubic_through(np.arange(float(count)), np.arange(count) + 0j, np.array([1.0]))


@given(values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=70))
def test_the_median_of_few_values_is_that_of_numpy(values):
    assert median_of(np.array(values)) == np.median(values)
