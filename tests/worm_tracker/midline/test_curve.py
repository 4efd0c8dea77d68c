"""What is done in few steps, because it is done often, is what the libraries do in many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from worm_tracker.midline.curve import complex_arc_length, cubic_through, median_of

TURNS = st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=80)
BEYOND = 0.1
"""How far beyond the ends, over the length, points are asked for."""


def curve_of(turns):
    steps = 3.0 + np.sin(np.arange(len(turns)))
    return 300.0 + np.cumsum(steps * np.exp(1j * np.cumsum(turns)))


@given(turns=TURNS)
def test_a_cubic_through_points_is_that_of_scipy(turns):
    curve = curve_of(turns)
    s = complex_arc_length(curve)
    at = s[-1] * np.linspace(-BEYOND, 1 + BEYOND, 57)
    assert np.array_equal(cubic_through(s, curve, at), CubicSpline(s, curve)(at))


def test_no_cubic_goes_through_one_point_twice():
    curve = curve_of([0.1] * 9)
    curve[4] = curve[3]
    with pytest.raises(ValueError, match="two points"):
        cubic_through(complex_arc_length(curve), curve, np.array([1.0]))


@given(values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=70))
def test_the_median_of_few_values_is_that_of_numpy(values):
    assert median_of(np.array(values)) == np.median(values)
