"""Places in which an end of a body may lie: each is the body from a place of it on."""

import numpy as np
import pytest
from drawn_folds import HEADINGS, LEVEL, Drawn
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.end_places import (
    EndPlacesSettings,
    lengthened,
    places_along,
    places_beyond_flanks,
)
from worm_tracker.midline.object_outline import Outline
from worm_tracker.midline.path import evenly, nodes_for

WIDTH = 14.0
SETTINGS = EndPlacesSettings()
BENDS = st.floats(-0.3, 0.3)


def length_px(line):
    return float(np.abs(np.diff(line)).sum())


def bent_line(bend_per_width, widths=16.0, heading=0.0):
    """Return a line of one curvature whose first node is its end."""
    s = np.linspace(0, widths, nodes_for(widths * WIDTH, WIDTH))
    return 300 + 300j + np.cumsum(np.exp(1j * (heading + bend_per_width * s))) * s[1] * WIDTH


@given(bend=BENDS, heading=HEADINGS)
def test_a_body_is_tried_as_much_shorter_and_longer_as_is_asked(bend, heading):
    line = bent_line(bend, heading=heading)
    more = [
        (length_px(other) - length_px(line)) / WIDTH
        for other in places_along(line, WIDTH, SETTINGS)
    ]
    step = length_px(line[:2]) / WIDTH
    for longer in SETTINGS.longer_widths:
        assert min(abs(each - longer) for each in more) < step
    assert max(abs(each) for each in more) < max(SETTINGS.longer_widths) + 2 * step


@given(bend=BENDS, longer=st.floats(-3.0, 3.0))
def test_a_body_is_longer_by_as_much_as_is_asked(bend, longer):
    line = bent_line(bend)
    other = lengthened(line, longer, WIDTH, SETTINGS)
    step = length_px(line[:2])
    assert length_px(other) - length_px(line) == pytest.approx(longer * WIDTH, abs=1.5 * step)
    assert other[-1] == line[-1]


def test_a_body_of_which_little_would_be_left_is_not_shortened():
    line = bent_line(0.0, widths=6.0)
    assert lengthened(line, -5.5, WIDTH, SETTINGS) is None


def crossing(beyond_widths):
    """Return a body whose last end crosses its own strand and goes on so far beyond its middle."""
    return [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (2.5 + beyond_widths, 0.0)]


@given(heading=HEADINGS, beyond=st.floats(1.2, 3.0), turned=st.sampled_from([-1.2, 1.2]))
def test_an_end_that_was_led_astray_is_tried_where_it_shows(heading, beyond, turned):
    """However it was turned aside from three widths before its tip on."""
    drawn = Drawn.of(crossing(beyond), WIDTH, heading, darker=False)
    s = np.linspace(drawn.length, 0.0, 800)
    true = evenly(drawn.at(s), nodes_for(drawn.length, WIDTH))
    cut = round(3.0 * WIDTH / length_px(true[:2]))
    part = np.clip(1 - np.arange(len(true)) / cut, 0, 1)
    steps = np.diff(true[::-1]) * np.exp(1j * turned * part[-2::-1])
    astray = np.concatenate([true[-1:], true[-1] + np.cumsum(steps)])[::-1]
    outline = Outline.of(np.ascontiguousarray(drawn.signal), LEVEL / 2)
    half = np.full(len(astray), WIDTH / 2)
    places = list(places_beyond_flanks(astray, half, outline.pixels, WIDTH, SETTINGS))
    assert abs(astray[0] - true[0]) > WIDTH
    assert min(abs(place[0] - true[0]) for place in places) < 0.5 * WIDTH
    for place in places:
        assert place[-1] == astray[-1]
        assert np.abs(np.diff(place)).max() < 1.5 * length_px(true[:2]), "a body has no gap"


def test_where_the_rest_explains_all_of_the_outline_an_end_is_tried_straight_on_alone():
    drawn = Drawn.of([(20.0, 0.0)], WIDTH, darker=False)
    line = evenly(drawn.at(np.linspace(0.0, drawn.length, 800)), nodes_for(drawn.length, WIDTH))
    half = np.full(len(line), WIDTH)  # as broad as nothing lies beyond it
    outline = np.array([line[20] + 3.0, line[21] - 2.0])
    places = list(places_beyond_flanks(line, half, outline, WIDTH, SETTINGS))
    assert len(places) == len(SETTINGS.bent_widths)
    for place in places:
        assert np.abs(place[0] - line[0]) < 0.5 * WIDTH
