"""Of two strands that lead to the same places a body takes first the one that keeps it straight."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import (
    doubtful_loops,
    exchanged_strands,
    exchanges,
    part_of,
)
from worm_tracker.midline.strand_meetings import StrandExchangeSettings
from worm_tracker.midline.strand_order import other_orders

WIDTH = 12.0
SETTINGS = StrandExchangeSettings()
BODIES = {"heading": st.floats(0.0, 6.28), "half_widths": st.floats(1.2, 1.8)}


def passes_twice(heading, half_widths):
    """Return a body that comes twice from one place to another, the same in the other order.

    Up to the first place, over a cap to the other one, down round a ring, and by the first place
    straight on to the other one.
    """
    a, r = half_widths, 4.0
    up = -a + 1j * np.linspace(-9.0, r, 60)
    cap = 1j * (r + 1) + a * np.exp(1j * np.linspace(np.pi, 0.0, 40))
    cap = np.r_[-a + 1j * r, cap, a + 1j * r]
    down = a + 1j * np.linspace(r, 0.0, 20)[1:]
    ring = a - r + r * np.exp(-1j * np.linspace(0.0, 1.5 * np.pi, 80)[1:])
    chord = np.linspace(-a, a, 20) + 1j * r
    out = np.linspace(a, a + 9.0, 40) + 1j * r
    orders = (up, cap, down, ring, chord, out), (up, chord, down, ring, cap, out)
    return tuple(laid(np.concatenate(parts) * np.exp(1j * heading)) for parts in orders)


def laid(line):
    """Return a path along a line in widths, no two points of which are one."""
    apart = np.r_[True, np.abs(np.diff(line)) > 1e-9]
    return BodyPath(evenly(line[apart] * WIDTH, 300))


def apart_widths(path, other):
    """Return how far two paths are apart at most, along both alike."""
    return np.abs(path.curve - other.curve).max() / WIDTH


@given(**BODIES)
def test_a_body_that_passes_two_strands_in_the_straighter_order_stays(heading, half_widths):
    straight, _ = passes_twice(heading, half_widths)
    assert exchanged_strands(straight, WIDTH, SETTINGS) == (None, 0.0)
    assert doubtful_loops(straight, WIDTH, SETTINGS, -0.15) == []


@given(**BODIES)
def test_two_strands_passed_in_the_kinked_order_change_places(heading, half_widths):
    straight, kinked = passes_twice(heading, half_widths)
    found, gain = exchanged_strands(kinked, WIDTH, SETTINGS)
    assert gain > SETTINGS.least_gain_in_all_rad2
    assert apart_widths(found, straight) < 0.5 < apart_widths(kinked, straight)


@given(**BODIES)
def test_what_lies_between_two_strands_is_in_doubt_where_the_other_order_is_straighter(
    heading, half_widths
):
    straight, kinked = passes_twice(heading, half_widths)
    first, last = part_of(
        doubtful_loops(kinked, WIDTH, SETTINGS, 4.0)
    )  # no one loop gains half as much
    part = np.linspace(0, 1, len(kinked.curve))
    told = np.abs(straight.curve - kinked.curve)[(part < first) | (part > last)]
    assert told.max() < 0.5 * WIDTH


@given(**BODIES)
def test_one_order_leads_to_the_other_and_back(heading, half_widths):
    straight, kinked = passes_twice(heading, half_widths)
    for path, other in ((straight, kinked), (kinked, straight)):
        ways = exchanges(path, WIDTH, SETTINGS)
        assert min(apart_widths(way, other) for way in ways) < 0.8


def test_strands_that_run_beside_each_other_have_no_other_order():
    """In either the body lies where it is, to less than a width."""
    turns = np.linspace(0.0, 4.0 * np.pi, 300)
    path = laid((4.0 + turns / 40.0) * np.exp(1j * turns))
    a_turn = round(2.0 * np.pi * 4.0 * WIDTH / path.step)
    met = [(i, i + a_turn) for i in (20, 60, 100)]
    assert list(other_orders(path.curve, met, WIDTH, path.step, SETTINGS)) == []
