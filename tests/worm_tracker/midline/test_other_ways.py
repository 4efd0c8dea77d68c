"""Ways in which a body may lie that are one step from the one that it was followed along."""

import numpy as np
import pytest
from drawn_folds import Drawn, laid
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.other_ways import OtherWaysSettings, add_if_new, other_ways
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_meetings import StrandExchangeSettings

WIDTH = 12.0
EXCHANGE, SETTINGS = StrandExchangeSettings(most_apart_widths=1.0), OtherWaysSettings()
CROSSING = [(9.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (9.0, 0.0)]


def ways_of(path, mask):
    return other_ways(path, mask, WIDTH, EXCHANGE, SETTINGS)


def true_path(drawn):
    return BodyPath(evenly(drawn.curve, 240))


def apart_widths(way, other):
    return float(np.abs(way.points - other.points).max()) / WIDTH


@given(bend=st.floats(-0.15, 0.15), heading=st.floats(0.0, 6.28))
def test_an_open_body_in_its_picture_lies_no_other_way(bend, heading):
    drawn = Drawn.of([(14.0, bend)], WIDTH, heading)
    assert ways_of(true_path(drawn), drawn.mask) == []


@given(heading=st.floats(0.0, 6.28))
def test_a_body_that_crosses_itself_may_turn_back_there_and_none_of_its_ways_are_alike(heading):
    drawn = Drawn.of(CROSSING, WIDTH, heading)
    path = true_path(drawn)
    ways = [path, *ways_of(path, drawn.mask)]
    assert len(ways) > 1
    for k, way in enumerate(ways):
        for other in ways[:k]:
            assert np.abs(way.points - other.points).max() >= SETTINGS.alike_widths * WIDTH
    # One of them passes the loop the other way round, and another from there leads back.
    back = [apart_widths(two, path) for one in ways[1:] for two in ways_of(one, drawn.mask)]
    assert min(back) < 0.3


@pytest.mark.parametrize("last_end", [False, True])
@pytest.mark.parametrize(("beyond_widths", "is_cut"), [(0.5, False), (3.0, True), (9.0, True)])
def test_a_path_that_leaves_the_body_may_end_there(last_end, beyond_widths, is_cut):
    """But not for its last stretch, which is laid anew otherwise."""
    drawn = Drawn.of([(20.0, 0.02)], WIDTH)
    onwards = laid([(20.0 + beyond_widths, 0.02)], WIDTH)
    curve = evenly(onwards + (drawn.curve[0] - onwards[0]), 240)
    path = BodyPath(curve if last_end else curve[::-1])
    ways = ways_of(path, drawn.mask)
    assert bool(ways) is is_cut
    if is_cut:
        (way,) = ways
        end = way.curve[-1 if last_end else 0]
        assert abs(end - drawn.curve[-1]) < 1.0 * WIDTH
        assert way.length < path.length


def test_a_way_is_new_where_it_is_unlike_all_others():
    path = BodyPath(evenly(laid(CROSSING, WIDTH), 240))
    ways = [path]
    assert not add_if_new(ways, path.shifted(0.3 * WIDTH), WIDTH, SETTINGS)
    assert add_if_new(ways, path.shifted(0.8 * WIDTH), WIDTH, SETTINGS)
    assert len(ways) == 2
