"""Which end is the head follows from motion alone, whichever way round the midlines come."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_tracker.head_tail.certainty import (
    LEAST_CERTAINTY,
    certainty,
    certainty_before_link,
    smoothed_before_link,
)
from worm_tracker.head_tail.identity import (
    HeadTail,
    HeadTailSettings,
)
from worm_tracker.observation import Observation
from worm_tracker.worm_track import WormTrack

LENGTH, WIDTH = 100.0, 10.0


def crawling(frames, step, heading=0.3):
    """Midlines of a worm that goes along a gentle wave, head first."""
    s = np.linspace(0, -LENGTH, 65)
    x = s[None] + step * np.arange(frames)[:, None]
    wave = np.stack([x, 8 * np.sin(x / 15)], axis=-1)
    c, s = np.cos(heading), np.sin(heading)
    return wave @ np.array([[c, s], [-s, c]])


def seen(points, appearance=None, confidence=1.0):
    """Return what a picture says of a body."""
    return Observation(
        Status.TRACKED,
        points=points,
        widths=np.full(len(points), WIDTH),
        confidence=confidence,
        width=WIDTH,
        appearance=appearance,
    )


def follow(midlines, turned):
    """Push midlines, some the other way round; return identity and whether the head is first."""
    identity = HeadTail(WormTrack(), HeadTailSettings())
    for midline, flip in zip(midlines, turned, strict=True):
        identity.push(seen(midline[::-1] if flip else midline))
    return identity, (identity.log_odds > 0) != bool(turned[0])


@given(turned=st.lists(st.booleans(), min_size=40, max_size=40))
def test_the_leading_end_is_the_head_whichever_way_round_midlines_come(turned):
    identity, head_first = follow(crawling(40, 3.0), turned)
    assert head_first
    assert identity.certain


@given(
    step=st.floats(-4, 4).filter(lambda x: abs(x) > 1), turned=st.lists(st.booleans(), min_size=60)
)
def test_time_reversed_motion_exchanges_the_ends(step, turned):
    turned = turned[:60]
    _, one = follow(crawling(60, step), turned)
    _, other = follow(crawling(60, -step), turned)
    assert one != other


@pytest.mark.parametrize(("lengths", "is_certain"), [(0.4, False), (0.65, True)])
def test_the_head_is_decided_by_half_a_length(lengths, is_certain):
    frames = round(lengths * LENGTH / 3.0)
    identity, head_first = follow(crawling(1 + frames, 3.0), np.zeros(1 + frames, bool))
    assert head_first
    assert identity.certain is is_certain


def test_a_worm_at_rest_decides_nothing():
    rng = np.random.default_rng(0)
    still = crawling(1, 0.0)[0]
    identity = HeadTail(WormTrack(), HeadTailSettings())
    for _ in range(500):
        identity.push(seen(still + 0.1 * rng.standard_normal((65, 1))))
    assert not identity.certain
    assert identity.swaps == 0


def test_going_back_a_little_does_not_turn_the_worm():
    there = crawling(80, 3.0)
    identity, head_first = follow(np.concatenate([there, there[:50:-1]]), np.zeros(109, bool))
    assert head_first
    assert identity.swaps == 0


def test_going_back_for_long_is_a_swap_and_counted():
    there = crawling(120, 3.0)
    identity, head_first = follow(np.concatenate([there, there[::-1]]), np.zeros(240, bool))
    assert not head_first
    assert identity.swaps == 1


def test_a_link_that_cannot_be_told_costs_the_certainty():
    identity, _ = follow(crawling(60, 3.0), np.zeros(60, bool))
    assert identity.certain
    fold = np.abs(np.linspace(-LENGTH / 2, LENGTH / 2, 65))
    hairpin = np.stack([fold, np.zeros(65)], axis=1)  # the same from either end
    linked = identity.push(seen(hairpin))
    assert linked.reliability < 0.9
    assert not identity.certain


def test_certainty_is_a_probability():
    assert certainty(0.0) == 0.5
    assert certainty(-3.0) == certainty(3.0) == pytest.approx(0.9526, abs=1e-4)
    assert certainty_before_link(0.9, 1.0) == pytest.approx(0.9)
    assert certainty_before_link(0.9, 0.5) == pytest.approx(0.5)


PROBABILITIES = st.floats(0.01, 0.99)


@given(st.lists(st.tuples(st.floats(0.5, 1.0), PROBABILITIES), min_size=1, max_size=6))
def test_what_is_known_before_a_link_by_all_is_that_of_all_ways_it_may_have_been(steps):
    """Against the sum over all orders of all frames, of which there are two to the frames."""
    reliability, evidence = np.array(steps).T
    orders = np.array(list(product((0, 1), repeat=len(steps))))
    seen = np.where(orders, evidence, 1 - evidence).prod(axis=1)
    same = orders[:, 1:] == orders[:, :-1]
    weight = seen * np.where(same, reliability[1:], 1 - reliability[1:]).prod(axis=1)
    by_all = (weight @ orders) / weight.sum()
    until_then, known = [], LEAST_CERTAINTY
    for linked, says in steps:
        known = certainty_before_link(known, linked)
        known = known * says / (known * says + (1 - known) * (1 - says))
        until_then.append(known)
    told = [known]
    for k in reversed(range(len(steps) - 1)):
        told.append(smoothed_before_link(told[-1], until_then[k], reliability[k + 1]))
    assert told[::-1] == pytest.approx(by_all.tolist())


def test_where_nothing_was_known_before_a_link_it_is_what_comes_after():
    for after, reliability in product((0.0, 0.3, 1.0), (0.5, 0.8, 1.0)):
        before = certainty_before_link(after, reliability)
        assert smoothed_before_link(after, LEAST_CERTAINTY, reliability) == pytest.approx(before)


DIFFERENCE = np.linspace(0.3, -0.1, 16)
"""How the ends differ: the first half is wider, and darker in part."""


def crawled_then_missed(frames_missed, appearance, seed=0):
    """Return an identity that saw a worm go ahead, and then did not see it for a while."""
    rng = np.random.default_rng(seed)
    identity = HeadTail(WormTrack(), HeadTailSettings())
    for points in crawling(60, 3.0):
        noise = 0.05 * rng.standard_normal(16)
        identity.push(seen(points, None if appearance is None else appearance + noise))
    assert identity.certain
    assert identity.log_odds > 0
    for _ in range(frames_missed):
        identity.miss()
    return identity


def test_a_worm_not_seen_for_long_may_be_either_way_round():
    there = crawling(61, 3.0)[-1]
    soon, late = crawled_then_missed(1, None), crawled_then_missed(40, None)
    soon.push(seen(there))
    late.push(seen(there))
    assert soon.certain
    assert not late.certain
    assert certainty(late.log_odds) < 0.9


def test_a_body_that_was_poorly_fitted_for_long_does_not_tell_where_its_ends_are():
    identity = crawled_then_missed(0, None)
    for points in crawling(90, 3.0)[60:]:
        identity.push(seen(points, confidence=0.7))
    identity.push(seen(crawling(91, 3.0)[-1]))
    assert not identity.certain


@given(round_=st.booleans(), turned=st.booleans(), seed=st.integers(0, 99))
def test_the_appearance_of_the_ends_tells_the_head_after_a_time_without_it(round_, turned, seed):
    """Also where the worm has turned round unseen, so that each end lies where the other was."""
    identity = crawled_then_missed(40, DIFFERENCE, seed)
    rng = np.random.default_rng(seed)
    there = crawling(61, 3.0)[-1]
    head_first = there[::-1] if round_ else there
    decisions = []
    for _ in range(20):
        observation = seen(head_first, DIFFERENCE + 0.05 * rng.standard_normal(16))
        linked = identity.push(observation.reversed() if turned else observation)
        if linked.decision is not None:
            decisions.append(linked.decision)
    (decision,) = decisions
    assert decision.was_reversed == round_
    assert decision.reliability > 0.9
    assert identity.certain
    points = linked.observation.points
    head = points[0] if identity.log_odds > 0 else points[-1]
    assert tuple(head) == tuple(head_first[0])
