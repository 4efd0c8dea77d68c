"""Which end is which goes over from one midline to the next, however near to itself a body lies."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_tracker.head_tail.chain_order import KnownAgain
from worm_tracker.head_tail.identity import HeadTail, HeadTailSettings
from worm_tracker.head_tail.link import Chain, LinkSettings
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.waiting.brief_gaps import BriefGapSettings
from worm_tracker.waiting.frame_queue import FrameQueue
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.worm_track import WormTrack

LENGTH, WIDTH, POINTS = 200.0, 10.0, 65


def hairpin(arm, apart=5.0):
    """Return a body on its way through a U-turn, whose first end is as far beyond the bend."""
    beyond = arm - np.linspace(0.0, LENGTH, POINTS)
    return np.stack([-np.abs(beyond), np.where(beyond > 0, 0.0, apart)], axis=1)


def folded(points, *, path_number=0, order_known=False, over_limits=0.0):
    return Observation(
        Status.FOLDED,
        points=points,
        widths=np.full(POINTS, WIDTH),
        confidence=1.0,
        width=WIDTH,
        end_sd_px=(0.1, 0.1),
        over_limits=over_limits,
        path_number=path_number,
        order_known=order_known,
    )


EVEN = 0.5 * LENGTH
"""A hairpin whose arms are as long as this is nearly the same from either end."""


def test_the_place_of_a_hairpin_with_even_arms_does_not_tell_its_ends():
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN)))
    assert chain.push(folded(hairpin(EVEN + 4.0))).reliability < 0.9


@given(
    arms=st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=30),
    path_number=st.sampled_from([1, -1]),
)
def test_a_body_that_is_slid_along_itself_keeps_its_ends_there_and_back(arms, path_number):
    chain = Chain(WormTrack(), LinkSettings())
    for off in arms:
        points = hairpin(EVEN + off)
        link = chain.push(folded(points, path_number=path_number))
        assert np.array_equal(link.observation.points, points)
        assert link.reliability > 0.999


@pytest.mark.parametrize(
    ("arm", "sd_px", "is_sure"),
    [
        pytest.param(EVEN, 8.0, False, id="on each other, and one is not seen"),
        pytest.param(EVEN, 0.5, True, id="on each other, and both are seen"),
        pytest.param(EVEN + 20.0, 8.0, True, id="far from each other"),
    ],
)
def test_ends_that_lie_on_each_other_unseen_may_change_places(arm, sd_px, is_sure):
    """The one that comes out next may be either, however smoothly a body is slid on with it."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(arm), path_number=1))
    later = folded(hairpin(arm + 1.0), path_number=1)
    hidden = (sd_px > 0.4 * WIDTH) * 3
    link = chain.push(replace(later, end_sd_px=(sd_px, 0.5), occluded=(hidden, 0)))
    assert (link.reliability > 0.99) == is_sure
    assert is_sure or link.reliability < 0.7


@pytest.mark.parametrize(
    ("path_number", "gone"),
    [pytest.param(2, 0, id="another path"), pytest.param(1, 1, id="a frame without a midline")],
)
def test_a_path_that_was_left_tells_nothing_of_the_ends(path_number, gone):
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), path_number=1))
    for _ in range(gone):
        chain.miss()
    later = folded(hairpin(EVEN + 4.0), path_number=path_number)
    assert chain.push(later).reliability < 0.9


@pytest.mark.parametrize(("frames_unexplained", "is_sure"), [(5, True), (6, False)])
def test_a_body_that_was_lost_meanwhile_may_have_changed_its_ends(frames_unexplained, is_sure):
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), path_number=-1))
    for _ in range(frames_unexplained):
        chain.push(folded(hairpin(EVEN), path_number=-1, over_limits=2.0))
    link = chain.push(folded(hairpin(EVEN + 4.0), path_number=-1))
    assert (link.reliability > 0.99) == is_sure


@pytest.mark.parametrize(("frames_unexplained", "most"), [(5, 1.0), (6, 0.6)])
def test_a_body_found_again_may_have_lain_the_other_way_round(frames_unexplained, most):
    """However far from each other its ends are: what was followed meanwhile was not the body."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(0.0)))
    for _ in range(frames_unexplained):
        chain.push(folded(hairpin(0.0), over_limits=2.0))
    assert chain.push(folded(hairpin(1.0))).reliability == pytest.approx(most, abs=0.01)


HIDDEN_FIRST_END = {"occluded": (5, 0), "end_sd_px": (9.0, 0.5)}


def test_widths_tell_the_order_whatever_a_way_past_a_hidden_end_says():
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), order_known=True))
    chain.push(replace(folded(hairpin(EVEN + 1.0)), **HIDDEN_FIRST_END))
    chain.push(replace(folded(hairpin(EVEN + 2.0)), **HIDDEN_FIRST_END))
    other = hairpin(EVEN + 20.0)[::-1]
    link = chain.push(folded(other, order_known=True))
    assert np.array_equal(link.observation.points, other)
    assert link.known_again == KnownAgain(2, True, LinkSettings().widths.turned_reliability)
    assert link.motion is None


def after_ends_seen(contradictions, status=Status.FOLDED):
    """Return what is made of midlines whose widths tell another order than ends seen all along."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(60.0), order_known=True))
    chain.push(folded(hairpin(61.0)))
    seen = [folded(hairpin(62.0 + k)[::-1], order_known=True) for k in range(contradictions)]
    return [chain.push(replace(each, status=status)) for each in seen]


def test_widths_do_not_exchange_ends_that_are_seen_where_they_were():
    """A real worm's tail, too pale for a picture, shifted its widths: its ends changed places."""
    (link,) = after_ends_seen(1)
    assert np.array_equal(link.observation.points, hairpin(62.0))
    assert link.known_again is None
    assert link.reliability > 0.999, "which end is which is kept"
    assert link.own_reliability < 0.9, "but not sure here: what is told of the body may be wrong"


@pytest.mark.parametrize("status", [Status.TRACKED, Status.FOLDED])
def test_where_widths_of_open_bodies_contradict_ends_seen_for_long_neither_is_believed(status):
    """Those of a folded one never do: what is told of how it lies may be what is wrong."""
    most = LinkSettings().widths.most_contradicted
    links = after_ends_seen(most + 5, status)
    kept = [link.reliability > 0.99 for link in links]
    assert all(kept[: most - 1] + kept[most:])
    assert kept[most - 1] is (status is not Status.TRACKED), "there the head has to be told anew"
    assert all(link.known_again is None for link in links[:most])
    assert all(link.own_reliability < 0.9 for link in links[:most])
    sure = [link.own_reliability == 1.0 for link in links[most:]]
    assert all(sure) if status is Status.TRACKED else not any(sure)
    for k, link in enumerate(links):
        assert np.array_equal(link.observation.points, hairpin(62.0 + k))


@given(steps=st.lists(st.floats(-14.0, 14.0), min_size=1, max_size=30))
def test_a_body_whose_widths_tell_its_order_keeps_its_ends_wherever_it_crawls(steps):
    """No doubt adds up: each picture tells it anew. No worm gets far in a frame."""
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(hairpin(EVEN), order_known=True))
    for arm in np.clip(EVEN + np.cumsum(steps), EVEN - 60.0, EVEN + 60.0):
        link = chain.push(folded(hairpin(arm), order_known=True))
        assert np.array_equal(link.observation.points, hairpin(arm))
        assert link.known_again is not None
        assert link.known_again.reliability > 0.95


def queue_of(head_tail):
    return FrameQueue(
        head_tail,
        256,
        np.nan,
        most_frames_for_body=0,
        agreement=AgreementSettings(),
        brief_gaps=BriefGapSettings(),
    )


def heads_given(seen):
    """Return where the head is told in each frame that has a midline, and how surely."""
    queue = queue_of(HeadTail(WormTrack(), HeadTailSettings()))
    for frame, observation in enumerate(seen):
        queue.push(PendingFrame(frame, 40_000_000 * frame, observation, None))
    states = [each.state for each in queue.finish()]
    return [(each.head.v_px, each.head_certainty) for each in states if each.status.has_pose]


INTO_THE_TURN = [
    replace(folded(hairpin(arm), path_number=1, order_known=True), end_sd_px=(0.0, 0.0))
    for arm in np.arange(-60.0, EVEN, 4.0)
]


@pytest.mark.parametrize(("order_known", "is_certain"), [(True, True), (False, False)])
def test_the_head_stays_certain_over_a_body_that_was_followed_the_wrong_way_round(
    order_known, is_certain
):
    lost = folded(hairpin(EVEN, apart=0.5)[::-1], over_limits=2.0)  # the same from either end
    seen = [*INTO_THE_TURN, *[Observation(Status.COILED, followed=lost)] * 2]
    seen += [folded(hairpin(EVEN), order_known=order_known)]
    certain = [certainty > 0.9 for _, certainty in heads_given(seen)]
    known = len(seen) - 3 + (1 if order_known else 0)
    assert all(certain[:known]), "what was known before stays so"
    assert certain[-1] is is_certain


@pytest.mark.parametrize("changed_at", [0, 2, 4])
def test_what_lies_behind_the_place_where_ends_changed_is_turned_round_once_widths_tell(changed_at):
    """Five midlines of one path, whose ends are exchanged at one of them."""
    between = [folded(hairpin(EVEN + k), path_number=2) for k in range(5)]
    hidden = {"occluded": (0, 5), "end_sd_px": (0.5, 9.0)}
    between[changed_at] = replace(between[changed_at], **hidden)
    between = [each.reversed() if k >= changed_at else each for k, each in enumerate(between)]
    last = folded(hairpin(EVEN + 5), order_known=True, path_number=3)
    given = heads_given([*INTO_THE_TURN, *between, last])
    assert given[-1][1] > 0.9
    for v_px, certainty in given[-6:]:
        assert abs(v_px) < 0.1, "the head is on the arm that it was on"
        assert certainty > 0.9


def crossed_near_its_ends(between_reversed, ends_apart=1.0):
    """Return a loop whose ends cross beside each other, its middle passed one way or the other.

    Its ends lie 60 pixels apart, or a part of that.
    """
    angle = np.linspace(0.05, 2 * np.pi - 0.05, POINTS - 8)
    loop = np.stack([30.0 * np.cos(angle), 30.0 * np.sin(angle)], axis=1)
    ends = np.array([[36.0, -30.0], [36.0, -22.0], [34.0, -14.0], [32.0, -6.0]]) * [1.0, ends_apart]
    middle = loop[::-1] if between_reversed else loop
    return np.concatenate([ends, middle, ends[::-1] * [1.0, -1.0]])


@pytest.mark.parametrize("step_px", [0.0, 9.0])
@pytest.mark.parametrize("status", [Status.FOLDED, Status.LOOP_IN_DOUBT])
def test_ends_stay_where_they_are_seen_though_a_loop_between_them_is_passed_the_other_way(
    status, step_px
):
    chain = Chain(WormTrack(), LinkSettings())
    first = folded(crossed_near_its_ends(between_reversed=False))
    chain.push(first)
    turned = folded(crossed_near_its_ends(between_reversed=True) + np.array([step_px, 0.0]))
    doubt = (4, POINTS - 4) if status is Status.LOOP_IN_DOUBT else (0, 0)
    link = chain.push(replace(turned, status=status, in_doubt=doubt))
    if status is Status.LOOP_IN_DOUBT or not step_px:
        moved = first.points[0] + [step_px, 0.0]
        assert np.allclose(link.observation.points[0], moved)
    if step_px:
        return
    assert link.reliability > 0.999


def test_what_lies_in_a_loop_in_doubt_does_not_tell_which_end_is_which():
    """At 12 pictures a second a worm's ends came near each other, its loop passed the other way.

    Most of the body lay in its loop: it was linked the wrong way round for certain.
    """
    chain = Chain(WormTrack(), LinkSettings())
    chain.push(folded(crossed_near_its_ends(between_reversed=False, ends_apart=0.4)))
    later = folded(crossed_near_its_ends(between_reversed=True, ends_apart=0.1))
    doubt = {"status": Status.LOOP_IN_DOUBT, "in_doubt": (4, POINTS - 4)}
    assert chain.push(replace(later, **doubt)).reliability < 0.9


@pytest.mark.parametrize(
    ("status", "counts"),
    [
        pytest.param(Status.TRACKED, True, id="open, as a way back through a fold found it"),
        pytest.param(Status.FOLDED, False, id="on itself: it hides how its parts move"),
        pytest.param(Status.LOOP_IN_DOUBT, False, id="a loop of it may be passed otherwise"),
    ],
)
def test_a_body_that_was_slid_tells_its_motion_where_it_is_open(status, counts):
    chain = Chain(WormTrack(), LinkSettings())
    line = np.stack([np.linspace(0.0, -LENGTH, POINTS), np.zeros(POINTS)], axis=1)
    chain.push(replace(folded(line), status=status))
    motion = chain.push(replace(folded(line + np.array([4.0, 0.0])), status=status)).motion
    assert (motion is not None) is counts
    if counts:
        assert motion.forward_lengths == pytest.approx(4.0 / LENGTH, rel=1e-6)
