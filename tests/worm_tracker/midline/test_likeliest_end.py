"""An end is where what was tried costs least, and as sure as what costs as little lies near."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.likeliest_end import (
    KnownEnd,
    LikeliestEndSettings,
    PlacedEnd,
    likeliest_end,
)

WIDTH, LENGTH = 10.0, 200.0
SETTINGS = LikeliestEndSettings(
    likelihood=1.0, likelihood_over_cost=0.2, most_cost=10.0, most_cost_moved=15.0, sd_over_spread=1
)
KNOWN = KnownEnd(0j, WIDTH, WIDTH, LENGTH, LENGTH)


def placed(off_px, cost, length_px=LENGTH):
    return PlacedEnd(off_px + np.linspace(0, length_px, 40) * (1 + 0j), length_px, cost)


@given(off=st.floats(0.3 * WIDTH, 2 * WIDTH), gain=st.floats(5.0, 9.0))
def test_an_end_is_moved_to_what_costs_far_less(off, gain):
    end = likeliest_end([placed(0, 9.5), placed(off, 9.5 - gain)], KNOWN, SETTINGS)
    assert end.curve[0] == off


def test_an_end_stays_where_another_place_costs_little_less():
    end = likeliest_end([placed(0, 2.0), placed(WIDTH, 1.5)], KNOWN, SETTINGS)
    assert end.curve is None


def test_a_place_nearby_moves_no_end_but_makes_it_as_unsure():
    off = 0.2 * WIDTH
    end = likeliest_end([placed(0, 9.0), placed(off, 1.0)], KNOWN, SETTINGS)
    assert end.curve is None
    assert end.sd_px == pytest.approx(off, rel=0.05)


@given(off=st.floats(0.3 * WIDTH, 0.9 * WIDTH))
def test_two_places_that_cost_the_same_are_told_neither_surely(off):
    unsure = likeliest_end([placed(0, 1.0), placed(off, 1.0)], KNOWN, SETTINGS)
    sure = likeliest_end([placed(0, 1.0), placed(off, 9.0)], KNOWN, SETTINGS)
    assert sure.sd_px < 0.05 * WIDTH < unsure.sd_px
    assert unsure.sd_px <= off


def test_many_tries_beside_one_place_count_once():
    beside = [placed(0.01 * k, 1.0) for k in range(50)]
    many = likeliest_end([*beside, placed(WIDTH, 1.0)], KNOWN, SETTINGS)
    one = likeliest_end([placed(0, 1.0), placed(WIDTH, 1.0)], KNOWN, SETTINGS)
    assert many.sd_px == pytest.approx(one.sd_px, rel=0.05)


def test_where_nothing_fits_nothing_is_told():
    end = likeliest_end([placed(0, 50.0), placed(WIDTH, 20.0)], KNOWN, SETTINGS)
    assert end.curve is None
    assert end.sd_px == np.inf


def test_what_fits_too_little_to_be_told_may_fit_well_enough_to_be_followed():
    end = likeliest_end([placed(0, 50.0), placed(WIDTH, 12.0)], KNOWN, SETTINGS)
    assert end.curve is not None
    assert end.sd_px == np.inf


def test_a_body_much_longer_than_known_must_cost_less():
    known = KnownEnd(0j, WIDTH, WIDTH, LENGTH, 0.02 * LENGTH)
    longer = placed(WIDTH, 3.0, 1.1 * LENGTH)
    assert likeliest_end([placed(0, 6.0), longer], known, SETTINGS).curve is None
    assert likeliest_end([placed(0, 6.0), longer], KNOWN, SETTINGS).curve is longer.line


def test_the_worse_all_fits_the_less_a_difference_tells():
    well = likeliest_end([placed(0, 1.0), placed(WIDTH, 3.0)], KNOWN, SETTINGS)
    badly = likeliest_end([placed(0, 9.0), placed(WIDTH, 11.0)], KNOWN, SETTINGS)
    assert well.sd_px < badly.sd_px
