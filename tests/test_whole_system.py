"""What a worm's film gives after tracking and analysis is what its true tracks give."""

import pytest
from benchmarks.whole_system import holds, trial

pytestmark = pytest.mark.xdist_group("whole system")  # what they share is made once

WITH_DATA = ("contact_fraction", "d_c", "d_nc", "delta_r_h", "reversal_per_cycle", "v_b")
"""What a minute tells; `python -m benchmarks.whole_system` has many trials of ten."""


@pytest.fixture(scope="module")
def pair():
    """In a closed chamber, where the worm finds walls all the time."""
    both = trial(0, minutes=1.0, frames_per_s=10.0, px_per_mm=16.0, exit_width_mm=0.0)
    return tuple(measured.numbers for measured in both)


@pytest.mark.parametrize("name", WITH_DATA)
def test_the_interval_of_a_number_holds_the_true_one(pair, name):
    filmed, true = pair
    assert holds(filmed[name], true[name]) == 1.0


@pytest.mark.parametrize("name", ["d_c", "d_nc", "delta_r_h", "v_b"])
def test_tracking_adds_no_error_that_matters(pair, name):
    filmed, true = pair
    assert filmed[name].value == pytest.approx(true[name].value, rel=0.08)
    assert filmed[name].n == true[name].n


def test_contacts_are_told_as_they_are(pair):
    filmed, true = pair
    name = "contact_fraction"
    assert filmed[name].value == pytest.approx(true[name].value, abs=0.01)
