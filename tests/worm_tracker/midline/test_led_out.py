"""An end is led to the piece of its object in which it has come out."""

import numpy as np
import pytest
from drawn_folds import Drawn
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.led_out import LedOutSettings, led_out
from worm_tracker.midline.path import BodyPath, evenly, nodes_for

WIDTH = 14.0
SETTINGS = LedOutSettings()
BODY = [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (6.0, 0.0)]
"""A body whose last end crosses its own strand and comes out on the far side."""


def followed_short(drawn, cut_widths, last_end):
    s = np.linspace(0.0, drawn.length - cut_widths * WIDTH, 800)
    curve = evenly(drawn.at(s), nodes_for(drawn.length, WIDTH))
    return BodyPath(curve if last_end else curve[::-1])


def piece_beyond(drawn, cut_widths):
    """Return what of the body's picture lies beyond so much of its last end, by its true line."""
    rows, columns = np.nonzero(drawn.mask)
    away = np.abs((columns + 1j * rows)[:, None] - drawn.curve[::4]).argmin(axis=1)
    part = away / (len(drawn.curve[::4]) - 1)
    wanted = np.zeros_like(drawn.mask)
    beyond = part > 1 - cut_widths * WIDTH / drawn.length
    wanted[rows[beyond], columns[beyond]] = 255
    return wanted


@given(
    heading=st.floats(0.0, 6.28),
    cut=st.floats(1.5, 4.5),
    last_end=st.booleans(),
)
def test_an_end_that_came_out_beyond_its_own_strand_is_led_there(heading, cut, last_end):
    drawn = Drawn.of(BODY, WIDTH, heading, darker=False)
    path = followed_short(drawn, cut, last_end)
    ways = led_out(path, piece_beyond(drawn, cut), WIDTH, drawn.length, SETTINGS)
    end = -1 if last_end else 0
    tips = np.array([way.curve[end] for way in ways])
    assert len(ways)
    assert np.abs(tips - drawn.curve[-1]).min() < 0.8 * WIDTH
    true = drawn.at(np.linspace(0.0, drawn.length, 240))
    off = [np.abs(way.curve[:, None] - true).min(axis=1).max() for way in ways]
    assert min(off) < 0.5 * WIDTH, "all along"


def test_nothing_is_led_to_where_nothing_or_a_speck_is_left_over():
    drawn = Drawn.of(BODY, WIDTH)
    path = followed_short(drawn, 2.0, True)
    nothing = np.zeros_like(drawn.mask)
    assert led_out(path, nothing, WIDTH, drawn.length, SETTINGS) == []
    speck = nothing.copy()
    speck[5:8, 5:8] = 255
    assert led_out(path, speck, WIDTH, drawn.length, SETTINGS) == []


@pytest.mark.parametrize("known_over_true", [0.7, 1.4])
def test_no_end_is_led_so_far_that_the_body_were_of_another_length(known_over_true):
    drawn = Drawn.of(BODY, WIDTH, darker=False)
    path, piece = followed_short(drawn, 3.0, True), piece_beyond(drawn, 3.0)
    known = known_over_true * drawn.length
    for way in led_out(path, piece, WIDTH, known, SETTINGS):
        assert abs(np.log(way.length / known)) < SETTINGS.most_log_length + 0.02


def test_what_lies_aside_of_all_that_a_body_can_bend_is_not_reached():
    drawn = Drawn.of([(20.0, 0.0)], WIDTH, darker=False)
    path = followed_short(drawn, 0.0, True)
    aside = np.zeros_like(drawn.mask)
    middle = path.curve[len(path.curve) // 2]
    u, v = int(middle.real), int(middle.imag + 2.5 * WIDTH)
    aside[v : v + 8, u : u + 8] = 255
    tips = [
        way.curve[end]
        for way in led_out(path, aside, WIDTH, drawn.length, SETTINGS)
        for end in (0, -1)
    ]
    assert all(abs(tip - complex(u, v)) > WIDTH for tip in tips)
