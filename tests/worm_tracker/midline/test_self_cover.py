"""Where a body covers itself by its path is where the renderer lays one strand over another."""

import numpy as np
import pytest
from drawn_folds import BENDS, HEADINGS, NODES_PER_WIDTH, WIDTHS, Drawn, laid, loops
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.midline.self_cover import (
    SelfCoverSettings,
    ends_kept,
    ends_on_body,
    lies_near_itself,
    parts_over,
    strands_at_ends,
)

SETTINGS = SelfCoverSettings()
ALL = slice(None)
MARGIN_PX = 2.0
"""Discs, subpixels and nodes: by this much an edge may be elsewhere."""


def covered(curve, width, body=ALL, margin_px=0.0, at=None):
    at = curve[:, None] if at is None else at
    half, step = np.full(len(curve), width / 2), width / NODES_PER_WIDTH
    return parts_over(at, curve, half, body, step, margin_px, SETTINGS) > 0


@given(arcs=BENDS | loops(), width=WIDTHS, heading=HEADINGS)
@settings(max_examples=25)
def test_the_middle_is_covered_where_the_renderer_has_two_strands(arcs, width, heading):
    drawn = Drawn.of(arcs, width, heading)
    inner = slice(NODES_PER_WIDTH // 2, -NODES_PER_WIDTH // 2)  # the renderer's ends are round
    surely = covered(drawn.curve, width, inner, -MARGIN_PX)[inner, 0]
    perhaps = covered(drawn.curve, width, inner, MARGIN_PX)[inner, 0]
    u, v = (np.rint(x).astype(int) for x in (drawn.curve.real[inner], drawn.curve.imag[inner]))
    assert (drawn.layers[v, u][surely] > 1.5).all()
    assert (drawn.layers[v, u][~perhaps] < 1.5).all()


@given(arcs=BENDS | loops(), width=WIDTHS, margin=st.floats(-3.0, 3.0), more=st.floats(0.0, 3.0))
@settings(max_examples=25)
def test_a_wider_margin_covers_no_less(arcs, width, margin, more):
    curve = laid(arcs, width)
    assert not (
        covered(curve, width, ALL, margin) & ~covered(curve, width, ALL, margin + more)
    ).any()


@given(turn=st.floats(-0.7, 0.7), width=WIDTHS, aside=st.floats(-1.5, 1.5))
@settings(max_examples=25)
def test_no_single_bend_covers_anything(turn, width, aside):
    """Neither the middle nor what is beside it: it lies under its own part of the body alone."""
    curve = laid([(2.0, 0.0), (3.0, turn), (2.0, 0.0)], width)
    tangent = np.gradient(curve)
    beside = curve + 1j * tangent / np.abs(tangent) * aside * width / 2
    assert not covered(curve, width).any()
    if abs(aside) <= 1.0:
        assert not covered(curve, width, at=beside[:, None]).any()


@given(angle=st.floats(0.6, np.pi - 0.6), width=WIDTHS)
@settings(max_examples=25)
def test_a_crossing_is_as_long_as_its_angle_makes_it(angle, width):
    """A strip of width w lies over a line that it meets at an angle a for w / sin a."""
    turn = np.pi + angle
    radius = 2.0
    lead = radius / np.tan(angle / 2)  # from the loop's ends to where they cross
    curve = laid([(lead + 3.0, 0.0), (turn * radius, 1 / radius), (lead + 3.0, 0.0)], width)
    long = covered(curve, width)[:, 0].sum() / 2 / NODES_PER_WIDTH
    assert long == pytest.approx(1 / np.sin(angle), rel=0.08, abs=0.1)


def test_only_where_the_body_is_thought_to_be_does_it_cover():
    """A path that is continued beyond its body across it: what is not there covers nothing."""
    curve = laid([(4.0, 0.0), (7.5, 0.6), (5.0, 0.0)], 10.0)
    over = np.flatnonzero(covered(curve, 10.0)[:, 0])
    under = over[over < len(curve) // 2]
    body = slice(0, 11 * NODES_PER_WIDTH)  # up to the loop's end
    assert len(under) > NODES_PER_WIDTH // 2
    assert not covered(curve, 10.0, body)[under].any()
    assert covered(curve, 10.0, body)[over[over > len(curve) // 2]].any()
    assert not covered(curve, 10.0, slice(5, 5)).any()


@given(gap=st.floats(1.0, 4.0), width=WIDTHS, heading=HEADINGS)
@settings(max_examples=40)
def test_two_strands_are_near_each_other_up_to_so_many_widths(gap, width, heading):
    curve = laid([(6.0, 0.0), (np.pi * gap / 2, 2 / gap), (6.0, 0.0)], width, heading)
    near = lies_near_itself(curve, width, width / NODES_PER_WIDTH)
    if gap < 2.1:
        assert near
    if gap > 2.4:
        assert not near


@given(arcs=BENDS | loops(), width=WIDTHS)
@settings(max_examples=25)
def test_a_body_that_lies_on_itself_lies_near_itself(arcs, width):
    """Sooner than anything of it is covered, or it would not be looked for."""
    curve = laid(arcs, width)
    if covered(curve, width, ALL, MARGIN_PX).any():
        assert lies_near_itself(curve, width, width / NODES_PER_WIDTH)


@given(gap=st.floats(0.2, 3.0), long=st.floats(4.0, 9.0), width=WIDTHS, heading=HEADINGS)
@settings(max_examples=40)
def test_the_end_that_comes_back_to_the_body_is_the_one_on_it(gap, long, width, heading):
    """A hairpin whose first leg goes on by four widths: its first end is far from all else."""
    round_ = round(np.pi * gap / 2 * NODES_PER_WIDTH) / NODES_PER_WIDTH  # a whole half turn
    curve = laid([(long + 4.0, 0.0), (round_, np.pi / round_), (long, 0.0)], width, heading)
    step = width / NODES_PER_WIDTH
    if abs(gap - 1.1) > 0.2:  # bends are drawn in steps
        assert ends_on_body(curve, 1.1 * width, step) == (False, gap < 1.1)
        assert ends_on_body(curve[::-1], 1.1 * width, step) == (gap < 1.1, False)


@given(turn=st.floats(-3.0, 3.0), width=WIDTHS)
def test_no_end_of_an_open_body_lies_on_it(turn, width):
    curve = laid([(20.0, turn / 20.0)], width)
    assert ends_on_body(curve, 1.1 * width, width / NODES_PER_WIDTH) == (False, False)


SDS_PX = st.tuples(st.floats(0.01, 50.0), st.floats(0.01, 50.0))


@given(apart=st.floats(0.0, 100.0), more=st.floats(0.0, 100.0), sds=SDS_PX, unsurer=st.floats(1, 5))
def test_ends_are_kept_the_surer_the_farther_apart_and_the_better_seen_they_are(
    apart, more, sds, unsurer
):
    line = np.array([[0.0, 0.0], [40.0, 30.0], [apart, 0.0]])
    farther = np.array([[0.0, 0.0], [40.0, 30.0], [apart + more, 0.0]])
    kept = ends_kept(line, sds)
    assert 0.5 <= kept <= ends_kept(farther, sds) <= 1.0
    assert ends_kept(line, (unsurer * sds[0], sds[1])) <= kept
    assert kept == ends_kept(line[::-1], sds[::-1])


def test_ends_in_one_place_may_be_either_and_those_that_are_seen_are_kept():
    ring = np.array([[7.0, 7.0], [0.0, 0.0], [7.0, 7.0]])
    assert ends_kept(ring, (0.0, 3.0)) == 0.5
    assert ends_kept(ring, (0.0, 0.0)) == 1.0


@given(width=WIDTHS, heading=HEADINGS, beside=st.floats(-0.4, 0.4))
@settings(max_examples=25)
def test_strands_that_pass_an_end_are_counted(width, heading, beside):
    """From its first end a body goes away and comes back over it, once, twice or not at all."""
    turn, aside = width * np.exp(1j * heading), 1j * beside
    away, once = [0.0, 6.0], [6 + 4j + aside, -6 - 4j + aside]
    again = [-6 + 4j + aside, 6 - 4j + aside]
    for corners, strands in ((away, 0), (away + once, 1), (away + once + again, 2)):
        legs = 200 + 200j + turn * np.array(corners)
        s = np.r_[0.0, np.cumsum(np.abs(np.diff(legs)))]
        path, step = np.interp(np.linspace(0, s[-1], 400), s, legs), s[-1] / 399
        assert strands_at_ends(path, 0.6 * width, width, step) == (strands, 0)
        assert strands_at_ends(path[::-1], 0.6 * width, width, step) == (0, strands)
