"""Numbers are written with the digits that their interval supports, and no more."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.report.numbers import interval, plain, value, with_deviation, with_interval
from worm_msgs_py import Quantity


@pytest.mark.parametrize(
    ("quantity", "text"),
    [
        (Quantity("d_c", 1.9537, 1.4752, 2.7107), "1.95 [1.48 … 2.71]"),
        (Quantity("t_per", 9.632, 2.199, 42.19), "9.6 [2.2 … 42.2]"),
        (Quantity("psi", -34.21, -36.9, -31.5), "−34.2 [−36.9 … −31.5]"),
        (Quantity("tau_h", 1234.6, 1000.2, 1600.9), "1235 [1000 … 1601]"),
        (Quantity("w_s", 2.5), "2.50"),
        (Quantity("n_s", 0.0, 0.0, 83.1), "0 [0 … 83]"),
        (Quantity("beta", 0.237, None, 0.951), "0.24 [≤ 0.95]"),
        (Quantity("beta", 0.237, 0.101), "0.24 [≥ 0.10]"),
        (Quantity("none", None, why="why not"), "–"),
    ],
)
def test_value_and_interval_are_written_to_the_same_digit(quantity, text):
    assert with_interval(quantity) == text


@given(st.floats(-1e5, 1e5), st.floats(1e-6, 1e3), st.floats(1e-6, 1e3))
def test_what_is_written_is_the_number_within_the_interval_s_precision(middle, below, above):
    quantity = Quantity("x", middle, middle - below, middle + above)
    tolerance = 0.051 * min(middle - quantity.low, quantity.high - middle) + 1e-9
    tolerance = max(tolerance, 0.5) if min(below, above) > 9 else tolerance
    written = [value(quantity), *interval(quantity).split(" … ")]
    for text, number in zip(written, (middle, quantity.low, quantity.high), strict=True):
        assert float(text.replace("−", "-")) == pytest.approx(number, abs=tolerance)


@pytest.mark.parametrize(
    ("number", "text"),
    [(10.0, "10"), (0.6, "0.6"), (1.95, "1.95"), (-34.0, "−34"), (0.0, "0"), (1e-9, "1e−09"),
     (123456.0, "123456"), (0.000123, "0.000123"), (float("nan"), "–"), (None, "–")],
)  # fmt: skip
def test_plain_numbers_have_no_idle_zeros(number, text):
    assert plain(number) == text


@pytest.mark.parametrize(
    ("number", "deviation", "text"),
    [
        (146.99999, 0.00121, "147.0000 ± 0.0012"),
        (399.9961, 0.0216, "399.996 ± 0.022"),
        (507.37, 0.01, "507.370 ± 0.010"),
        (507.25, float("nan"), "507.25"),
        (147.0 + 1e-12, float("nan"), "147"),
        (float("nan"), float("nan"), "–"),
    ],
)
def test_fitted_numbers_have_the_digits_of_their_deviation(number, deviation, text):
    assert with_deviation(number, deviation) == text
