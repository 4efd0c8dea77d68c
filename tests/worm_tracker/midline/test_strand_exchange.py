"""Where two strands meet, a body goes on the straighter way: it crosses itself, or turns back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import minimum_filter

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import (
    doubtful_loops,
    exchanged_strands,
    part_of,
    turned_at_end,
)
from worm_tracker.midline.strand_meetings import StrandExchangeSettings, meetings

WIDTH = 15.0
SETTINGS = StrandExchangeSettings()
HEADINGS = st.floats(0.0, 6.28)


def path_through(points, nodes=240):
    return BodyPath(evenly(np.asarray(points, complex), nodes))


def loop(heading, radius_widths=2.5, tail_widths=6.0):
    """Return a body that crosses itself at right angles, and the same turned back there."""
    r, tail = radius_widths * WIDTH, tail_widths * WIDTH
    angle = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 80)
    round_ = np.sqrt(2) * r + r * np.exp(1j * angle)
    far = round_[0] * 0 - tail * np.exp(1j * np.pi / 4 * np.array([-1, 1]))
    straight = np.linspace(0.95, 0.05, 20)
    into, out = far[1] * straight, far[0] * straight[::-1]
    crossing = np.r_[into, round_, out]
    touching = np.r_[into, round_[::-1], out]
    turn = np.exp(1j * heading)
    return crossing * turn, touching * turn


def worst(a, b):
    """Return how far apart two curves are at most, along both alike, in widths."""
    return np.abs(evenly(a, 200) - evenly(b, 200)).max() / WIDTH


@given(
    waves=st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(0.3, 4.0)), min_size=1, max_size=4),
    nodes=st.integers(30, 260),
    most_apart_widths=st.sampled_from([0.6, 1.0]),
)
def test_strands_meet_where_their_distance_is_least_about(waves, nodes, most_apart_widths):
    """By SciPy's filter over the distances of all nodes."""
    settings = StrandExchangeSettings(most_apart_widths=most_apart_widths)
    s = np.linspace(0.0, 1.0, nodes)
    heading = 2 * np.pi * sum(size * np.sin(2 * np.pi * turns * s) for size, turns in waves)
    curve = np.cumsum(np.exp(1j * heading)) * 30 * WIDTH / nodes
    curve += 1e-3 * np.random.default_rng(0).normal(size=(nodes, 2)) @ [1, 1j]  # no two are alike
    step = 30 * WIDTH / nodes
    node = np.arange(len(curve[::2]))
    apart = np.abs(curve[::2, None] - curve[::2])
    apart[2 * np.abs(node[:, None] - node) * step < 2.5 * WIDTH] = np.inf
    near = (apart == minimum_filter(apart, 5)) & (apart < most_apart_widths * WIDTH)
    meet = [(2 * i, 2 * j) for i, j in np.argwhere(np.triu(near)).tolist()]
    assert meetings(curve, WIDTH, step, settings) == meet


@given(heading=HEADINGS)
def test_a_body_that_crosses_itself_straight_on_stays(heading):
    crossing, touching = loop(heading)
    straight = crossing if bends(crossing) < bends(touching) else touching
    assert exchanged_strands(path_through(straight), WIDTH, SETTINGS) == (None, 0.0)


@given(heading=HEADINGS)
def test_a_body_with_two_kinks_where_its_strands_meet_is_passed_the_other_way_round(heading):
    crossing, touching = loop(heading)
    straight, kinked = sorted((crossing, touching), key=bends)
    found, gain = exchanged_strands(path_through(kinked), WIDTH, SETTINGS)
    assert found is not None
    assert gain > 1.0
    assert worst(found.curve, straight) < 0.6
    assert exchanged_strands(found, WIDTH, SETTINGS) == (None, 0.0)


@given(heading=HEADINGS, radius_widths=st.floats(1.0, 4.0))
def test_a_loop_is_in_doubt_by_its_breadth_where_the_other_way_round_is_straighter(
    heading, radius_widths
):
    straight, kinked = sorted(loop(heading, radius_widths), key=bends)
    assert doubtful_loops(path_through(straight), WIDTH, SETTINGS) == []
    loops = doubtful_loops(path_through(kinked), WIDTH, SETTINGS)
    breadth_px = max(loop.breadth_px for loop in loops)
    assert breadth_px == pytest.approx(2 * radius_widths * WIDTH, rel=0.2)


@given(heading=HEADINGS, radius_widths=st.floats(1.0, 4.0))
def test_outside_a_loop_in_doubt_the_body_lies_alike_either_way_round(heading, radius_widths):
    one, other = (evenly(way, 400) for way in loop(heading, radius_widths))
    kinked = max((one, other), key=bends)
    first, last = part_of(doubtful_loops(path_through(kinked), WIDTH, SETTINGS))
    part = np.linspace(0, 1, 400)
    apart = np.abs(one - other) / WIDTH
    assert apart[(part < first) | (part > last)].max() < 0.3
    assert apart[(part > first) & (part < last)].max() > 1.0


def test_a_loop_no_broader_than_the_body_leaves_none_of_it_a_width_off():
    kinked = max(loop(0.0, radius_widths=2.0), key=bends)
    narrow = 0.2 * kinked.imag + 1j * kinked.real
    assert doubtful_loops(path_through(kinked), WIDTH, SETTINGS)
    assert doubtful_loops(path_through(narrow), WIDTH, SETTINGS) == []


def bends(line):
    d = np.diff(line)
    return np.abs(np.angle(d[1:] / d[:-1])).max()


@pytest.mark.parametrize("gap_widths", [0.1, 0.3, 0.9])
def test_two_strands_side_by_side_stay(gap_widths):
    gap = gap_widths * WIDTH / 2
    strand = WIDTH * np.linspace(-8, 0, 60)
    turn = gap * np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 9))
    hairpin = np.r_[strand + 1j * gap, turn[1:-1], strand[::-1] - 1j * gap]
    assert exchanged_strands(path_through(hairpin), WIDTH, SETTINGS) == (None, 0.0)


def test_an_open_body_stays():
    line = 200 * np.exp(1j * np.linspace(0, 2.0, 100))
    assert exchanged_strands(path_through(line), WIDTH, SETTINGS) == (None, 0.0)


def ends_on_itself(over_widths):
    """Return a body that comes back to its own strand, and ends so far beyond its axis."""
    r = 3.0 * WIDTH
    strand = np.linspace(-10 * WIDTH, 8 * WIDTH, 200)
    angle = np.linspace(-0.5 * np.pi, np.pi, 120)
    bend = 8 * WIDTH + 1j * r + r * np.exp(1j * angle)
    end = bend[-1] - 1j * np.linspace(0.0, r + over_widths * WIDTH, 40)
    return np.r_[strand, bend[1:], end[1:]]


@given(heading=HEADINGS, over_widths=st.floats(-0.5, 0.5), last_end=st.booleans())
def test_a_loop_that_an_end_closes_lies_alike_passed_the_other_way(heading, over_widths, last_end):
    line = ends_on_itself(over_widths) * np.exp(1j * heading)
    path = path_through(line if last_end else line[::-1])
    turned = turned_at_end(path, WIDTH, last_end, SETTINGS)
    ends, kept = turned.curve[[0, -1]], path.curve[[0, -1]]
    still, moved = (0, -1) if last_end else (-1, 0)
    assert abs(ends[still] - kept[still]) < 0.1 * WIDTH
    assert abs(ends[moved] - kept[moved]) < 2.0 * WIDTH
    for one, other in ((turned, path), (path, turned)):
        away = np.abs(one.curve[:, None] - other.curve).min(axis=1)
        assert away.max() < 0.8 * WIDTH
    inside = slice(100, 180) if last_end else slice(60, 140)
    assert np.abs(turned.curve[inside] - path.curve[inside]).max() > 2 * WIDTH


@given(heading=HEADINGS)
def test_an_end_that_lies_on_no_strand_turns_none(heading):
    path = path_through(ends_on_itself(-1.5) * np.exp(1j * heading))
    assert turned_at_end(path, WIDTH, True, SETTINGS) is None
    assert turned_at_end(path, WIDTH, False, SETTINGS) is None


def lies_beside_itself(is_kinked):
    """Return a body that turns back and ends beside itself; or is kinked there to do so."""
    there, back = np.linspace(2.0, -12.0, 150), np.linspace(-12.0, -0.2, 120)
    turn = -12.0 + 0.5j + 0.5 * np.exp(1j * np.linspace(1.5 * np.pi, 0.5 * np.pi, 20))
    if not is_kinked:
        return WIDTH * np.r_[there, turn[1:-1], back + 1j]
    return WIDTH * np.r_[there[there > 0.4], there[there < -0.6] + 1j, turn[::-1][1:-1], back]


@given(heading=HEADINGS, last_end=st.booleans())
def test_a_loop_that_an_end_closes_is_in_doubt_where_the_body_is_kinked_beside_it(
    heading, last_end
):
    turn = np.exp(1j * heading)
    smooth, kinked = (
        path_through((line if last_end else line[::-1]) * turn, 400)
        for line in (lies_beside_itself(False), lies_beside_itself(True))
    )
    assert doubtful_loops(smooth, WIDTH, SETTINGS, -0.15, 0.85) == []
    first, last = part_of(doubtful_loops(kinked, WIDTH, SETTINGS, -0.15, 0.85))
    part = np.linspace(0, 1, 400)
    told = np.abs(smooth.curve - kinked.curve)[(part < first) | (part > last)]
    assert told.max() < 0.3 * WIDTH
    assert (last == 1.0 and 0 < first < 0.2) if last_end else (first == 0.0 and 0.8 < last < 1)


@given(heading=HEADINGS, over_widths=st.floats(-0.5, 0.5), last_end=st.booleans())
def test_however_it_bends_a_loop_that_an_end_closes_is_one_that_may_have_been_turned(
    heading, over_widths, last_end
):
    line = ends_on_itself(over_widths) * np.exp(1j * heading)
    path = path_through(line if last_end else line[::-1])
    turned = turned_at_end(path, WIDTH, last_end, SETTINGS)
    assert doubtful_loops(path, WIDTH, SETTINGS) == []
    first, last = part_of(doubtful_loops(path, WIDTH, SETTINGS, -25.0))
    part = np.linspace(0, 1, len(path.curve))
    alike = np.abs(path.curve - turned.curve)[(part < first) | (part > last)]
    assert alike.max() < 0.5 * WIDTH
    assert (last == 1.0) if last_end else (first == 0.0)
