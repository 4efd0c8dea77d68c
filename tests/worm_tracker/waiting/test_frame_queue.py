"""Head and tail are never exchanged in silence, and an operator's word holds for good."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from crawling_worm import FRAME_NS, SMALL_RIG, crawl, film, wavy_path
from hypothesis import example, given
from hypothesis import strategies as st
from waiting_frames import LINE, SEEN, WIDTH, coil, midline, queue_of

from worm_msgs_py import Status
from worm_tracker.head_tail.identity import ExchangeKind, HeadTailSettings
from worm_tracker.observation import Observation
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import TRACKER, Tracker
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.worm_track import WormTrack

LENGTH = 110.0
AHEAD = 60
"""Frames in which the worm goes ahead before it goes back for longer."""


@pytest.fixture(scope="module")
def there_and_back():
    ahead = np.arange(AHEAD)
    heads = LENGTH + 4.0 * np.concatenate([5 + ahead, np.arange(AHEAD + 5)[::-1]])
    return film(SMALL_RIG, crawl(wavy_path(SMALL_RIG), LENGTH, WIDTH, heads))


def push_all(tracker, pictures):
    given = []
    for frame, picture in enumerate(pictures):
        given += tracker.push(picture, frame * FRAME_NS)
    return given


def turned_round(given):
    """Return the frames whose head is nearer to the tail of the frame before than to its head."""

    def away(p, q):
        return np.hypot(p.u_px - q.u_px, p.v_px - q.v_px)

    pairs = [(a.state, b.state) for a, b in pairwise(given)]
    return [b.frame for a, b in pairs if away(b.head, a.tail) < away(b.head, a.head)]


def test_every_exchange_in_what_was_given_is_told_with_its_frame(there_and_back):
    tracker = Tracker(TrackerParameters(hold_back_frames=0))
    given = push_all(tracker, there_and_back) + tracker.finish()
    told = [exchange.frame for exchange in tracker.exchanges]
    assert len(told) == 1
    assert turned_round(given) == told
    assert tracker.swaps == 1
    (exchange,) = tracker.exchanges
    assert exchange.kind is ExchangeKind.SWAP
    assert exchange.stamp_ns == exchange.frame * FRAME_NS
    assert exchange.head_certainty == given[exchange.frame].state.head_certainty


def test_a_worm_that_keeps_its_head_has_no_exchange(there_and_back):
    tracker = Tracker(TrackerParameters())
    given = push_all(tracker, there_and_back[:AHEAD]) + tracker.finish()
    assert tracker.exchanges == []
    assert turned_round(given) == []


def test_an_operators_word_outlasts_any_motion(there_and_back):
    """Motion speaks against it for as long as it spoke for the other end before."""
    plain = Tracker(TrackerParameters())
    ahead = push_all(plain, there_and_back[:AHEAD]) + plain.finish()
    heads = [tracked.state.head for tracked in ahead]
    tracker = Tracker(TrackerParameters(hold_back_frames=5))
    first = push_all(tracker, there_and_back[:20])
    exchange = tracker.swap_head()
    assert exchange.kind is ExchangeKind.CORRECTION
    assert exchange.frame == len(first)
    given = list(first)
    for frame in range(20, AHEAD):
        given += tracker.push(there_and_back[frame], frame * FRAME_NS)
    given += tracker.finish()
    assert turned_round(given) == [exchange.frame]
    assert [tracked.state.head for tracked in first] == heads[: len(first)]
    assert [tracked.state.tail.u_px for tracked in given[20:]] == [
        head.u_px for head in heads[20:AHEAD]
    ]
    assert tracker.exchanges == [exchange]
    assert tracker.swaps == 0


def test_an_operators_word_reaches_the_frames_that_are_held_back(there_and_back):
    still = [there_and_back[0]] * 8
    told = Tracker(TrackerParameters())
    assert push_all(told, still) == []
    assert told.swap_head().frame == 0
    given = told.push(still[0], 8 * FRAME_NS)
    assert [tracked.state.frame for tracked in given] == list(range(9))
    other = Tracker(TrackerParameters())
    assert push_all(other, [*still, still[0]]) == []
    for one, tracked in zip(other.finish(), given, strict=True):
        assert tracked.state.head.u_px == one.state.tail.u_px
    assert (
        given[0].state.head_certainty > 1 / (1 + np.exp(-HeadTailSettings().most_log_odds)) - 0.01
    )


def test_an_operators_word_holds_against_what_motion_said_of_the_frames_that_wait():
    queue = queue_of(*ahead_gone_and_back())
    queue.link_all()
    queue.swap_head(0, 0)
    states, crawled = [one.state for one in queue.finish()], len(crawling())
    assert min(state.head_certainty for state in states[-crawled:]) > 0.95
    assert max(state.head_certainty for state in states[:crawled]) < 0.6  # the link is in doubt


def test_there_is_nothing_to_exchange_before_a_worm_was_seen():
    assert Tracker(TrackerParameters()).swap_head() is None


def test_no_frame_is_told_for_good_before_the_body_is_known(there_and_back):
    """Its first midlines may be of a body laid double: all wait, however sure the head is."""
    tracker = Tracker(TrackerParameters())
    assert push_all(tracker, there_and_back[:AHEAD]) == []
    given = tracker.finish()
    assert given[-1].state.head_certainty > 0.95


def test_coils_are_due_once_a_body_that_is_known_well_has_opened():
    assert not queue_of(coil(), coil()).is_due(body_is_learned=True)
    assert not queue_of(coil(), midline(kept=SEEN)).is_due(body_is_learned=True)
    assert queue_of(coil(), midline()).is_due(body_is_learned=False)


def test_where_no_frame_can_wait_a_body_known_from_some_frames_has_to_do():
    waiting = [coil(), midline(kept=SEEN), midline(kept=SEEN)]
    queue = queue_of(*waiting, hold_back_frames=2)
    assert queue.is_due(body_is_learned=True)
    assert not queue.is_due(body_is_learned=False)


def test_a_fold_waits_for_its_body_no_longer_than_so_though_its_head_may():
    waiting = [coil()] * (TRACKER.most_frames_for_body - 1)
    queue = queue_of(*waiting, midline(kept=SEEN), hold_back_frames=1000)
    assert not queue.is_due(body_is_learned=True)
    queue = queue_of(*waiting, coil(), midline(kept=SEEN), hold_back_frames=1000)
    assert queue.is_due(body_is_learned=True)


def test_each_run_of_coils_is_told_by_the_frame_after_it():
    gone = Observation(Status.NO_WORM)
    young = midline(kept=SEEN)
    queue = queue_of(young, coil(), coil(), young, coil(), gone, coil(), young, coil())
    runs = queue.coils()
    assert [[pending.frame for pending in run.frames] for run in runs] == [[1, 2], [6]]
    assert all(run.opened.observation is young for run in runs)
    assert [past.detection for past in runs[0].detections] == [SEEN, SEEN]


def test_a_coil_is_as_long_before_the_next_one_as_the_frames_missing_between_them():
    young = midline(kept=SEEN)
    queue = queue_of(young, coil(), coil(), coil(), young, steps=[1, 9, 2, 1, 4])
    (run,) = queue.coils()
    assert [past.frames for past in run.detections] == [4, 1, 2]


def test_a_coil_that_is_only_followed_backwards_carries_the_order_on_but_tells_nothing():
    queue = queue_of(coil(), coil(), midline())
    (run,) = queue.coils()
    coil_before_opening = run.frames[-1]
    followed = midline(over_limits=2.0)
    back = [Observation(Status.COILED, followed=followed), midline()]
    queue.go_back(lambda opened, detections: iter(back))
    told = queue.finish()
    assert [one.state.status for one in told] == [Status.TRACKED, Status.COILED, Status.TRACKED]
    assert coil_before_opening.observation.followed is followed


@pytest.mark.parametrize(
    ("away_widths", "explains", "way_back", "told_frames"),
    [
        pytest.param(1.5, True, "end hidden", [0, 1, 2, 3], id="both may be right to a width"),
        pytest.param(2.5, False, "end hidden", [0, 1, 2, 3], id="what was followed is no body"),
        pytest.param(2.5, True, "end hidden", [0, 2, 3], id="one of them is wrong"),
        pytest.param(2.5, True, "told", [0, 1, 2, 3], id="only the way back sees all of it"),
    ],
)
def test_a_way_back_with_a_hidden_end_tells_nothing_where_the_body_was_followed_elsewhere(
    away_widths, explains, way_back, told_frames
):
    elsewhere = midline(over_limits=0.0 if explains else 2.0)
    elsewhere = replace(elsewhere, points=LINE + np.array([0.0, away_widths * WIDTH]))
    queue = queue_of(coil(), coil(followed=elsewhere), coil(), midline())
    status = Status.TRACKED if way_back == "told" else Status.END_HIDDEN
    queue.go_back(Back(status))
    told = [one.state.frame for one in queue.finish() if one.state.status is not Status.COILED]
    assert told == told_frames


def crawling(**more):
    """Return midlines of a worm that crawls on as far as tells its head."""
    way = np.arange(0.0, 3 * LENGTH, 4.0)
    return [replace(midline(**more), points=LINE + np.array([along, 0.0])) for along in way]


@pytest.mark.parametrize("why", ["kept", "unresolved"])
def test_no_head_is_told_for_certain_of_a_body_that_may_be_laid_double(why):
    waiting = [*crawling(**{why: SEEN})[:-1], crawling()[-1]]
    sure = [one.state for one in queue_of(*waiting).finish()]
    doubted = [one.state for one in queue_of(*waiting).finish(body_in_doubt=True)]
    assert min(state.head_certainty for state in sure) > 0.95
    assert {state.head_certainty for state in doubted[:-1]} == {0.5}
    assert doubted[-1].head_certainty == sure[-1].head_certainty  # found once the body was known
    assert [state.status for state in doubted] == [state.status for state in sure]


@pytest.mark.parametrize("hold_back_frames", [256, 15])
def test_what_widths_told_of_the_head_holds_until_a_link_is_in_doubt(hold_back_frames):
    """However long ago they told it, and whether that frame waits still or was given."""
    ahead = crawling(order_known=True, kept=SEEN)
    rests = [replace(ahead[-1], order_known=False, status=Status.FOLDED)] * 10
    centre = rests[0].points.mean(axis=0)
    across = replace(rests[0], points=(rests[0].points - centre)[:, ::-1] + centre)
    queue = queue_of(hold_back_frames=hold_back_frames)
    told = []
    for frame, observation in enumerate([*ahead, *rests, *[across] * 10]):
        queue.push(PendingFrame(frame, frame * FRAME_NS, observation, None))
        told += queue.release()
    states = [one.state for one in [*told, *queue.finish()]][len(ahead) :]
    assert min(state.head_certainty for state in states[: len(rests)]) > 0.95
    assert max(state.head_certainty for state in states[len(rests) :]) < 0.6


def ahead_gone_and_back():
    """Return frames of a worm that is gone for a while, lies across its way, and goes backwards."""
    ahead = crawling(kept=SEEN)
    gone = [Observation(Status.NO_WORM)] * 20
    back = [replace(each, points=each.points[:, ::-1]) for each in reversed(ahead)]
    return [*ahead, *gone, *back]


def test_what_comes_after_a_link_in_doubt_does_not_undo_what_was_known_before_it():
    states = [one.state for one in queue_of(*ahead_gone_and_back()).finish()]
    crawled = len(crawling())
    before, after = states[:crawled], states[-crawled:]
    assert min(state.head_certainty for state in [*before, *after]) > 0.95
    assert {state.head.u_px - state.tail.u_px for state in before} == {LINE[-1, 0] - LINE[0, 0]}
    assert {state.head.v_px - state.tail.v_px for state in after} == {LINE[0, 0] - LINE[-1, 0]}


def test_of_a_body_that_was_no_worm_nothing_is_known_any_more():
    track, some = WormTrack(), crawling()[:14]
    queue = queue_of(*some, track=track)
    track.begin_anew()
    queue.push(PendingFrame(len(some), len(some) * FRAME_NS, some[-1], None))
    assert {one.state.head_certainty for one in queue.finish()} == {0.5}
    assert queue_of(*some).finish()[0].state.head_certainty > 0.7


def test_turned_round_a_frame_tells_the_same_end_as_the_head():
    pending = PendingFrame(0, 0, midline(), None, first_is_head=0.8)
    head = pending.observation.points[0]
    pending.turn_round()
    np.testing.assert_array_equal(pending.observation.points[-1], head)
    assert pending.first_is_head == pytest.approx(0.2)


def test_what_a_young_body_told_of_a_fold_is_taken_back_with_it():
    queue = queue_of(coil(), coil(), midline(kept=SEEN))
    queue.go_back(Back())
    assert len(queue.coils()) == 0
    queue.reopen()
    queue.push(PendingFrame(3, 3 * FRAME_NS, midline(kept=SEEN), None))
    (run,) = queue.coils()
    assert [pending.frame for pending in run.frames] == [0, 1, 2]


@pytest.mark.parametrize(("in_doubt", "yaw_known"), [((20, 90), True), ((9, 100), False)])
def test_head_and_tail_of_a_body_with_a_loop_in_doubt_are_told_and_the_loop_is_not(
    in_doubt, yaw_known
):
    doubted = replace(midline(in_doubt=in_doubt, unresolved=SEEN), status=Status.LOOP_IN_DOUBT)
    whole, told = queue_of(midline(), doubted).finish()
    assert told.state.status.has_pose
    for end in ("head", "tail"):
        place, known = getattr(told.state, end), getattr(whole.state, end)
        assert (place.u_px, place.v_px) == (known.u_px, known.v_px)
    assert np.isfinite(told.state.head.yaw_rad) == yaw_known
    assert told.state.length_px == pytest.approx(whole.state.length_px)  # alike either way
    in_loop = np.zeros(len(LINE), bool)
    in_loop[slice(*in_doubt)] = True
    for values in (told.midline.u_px, told.midline.v_px, told.midline.width_px):
        np.testing.assert_array_equal(np.isnan(values), in_loop)


class Back:
    """A way back that tells every coil, and counts its steps."""

    def __init__(self, status=Status.TRACKED):
        self.steps, self.status = 0, status

    def __call__(self, opened, detections):
        for _ in detections:
            self.steps += 1
            yield replace(midline(), status=self.status)


KINDS = {"coil": coil, "open": midline, "gone": lambda: Observation(Status.NO_WORM)}


def told_in_steps(kinds, most, hold_back_frames):
    """Return what is told of frames in all, and the steps back with each of them."""
    queue, back = queue_of(hold_back_frames=hold_back_frames), Back()
    told, steps = [], []
    for frame, kind in enumerate(kinds):
        before = back.steps
        queue.push(PendingFrame(frame, frame * FRAME_NS, KINDS[kind](), None))
        if queue.is_due(body_is_learned=True):
            queue.go_back(back, most)
        told += queue.release()
        steps.append(back.steps - before)
    queue.go_back(back)
    return [(one.state.frame, one.state.status) for one in told + queue.finish()], steps


@given(kinds=st.lists(st.sampled_from(sorted(KINDS)), max_size=40), most=st.integers(1, 5))
@example(kinds=["coil"] * 5 + ["open", "coil", "open"], most=1)
@example(kinds=["coil"] * 5 + ["open", "coil", "open", "gone"], most=1)
def test_a_way_back_that_is_spread_over_frames_tells_the_same(kinds, most):
    at_once, _ = told_in_steps(kinds, None, 100)
    spread, steps = told_in_steps(kinds, most, 100)
    assert spread == at_once
    assert [frame for frame, _ in spread] == list(range(len(kinds)))
    until_lost = kinds.index("gone") if "gone" in kinds else len(kinds)
    assert all(taken <= most for taken in steps[:until_lost])


def test_a_long_fold_is_gone_back_through_by_a_frame_with_each_new_one():
    told, steps = told_in_steps(["coil"] * 20 + ["open"] * 30, 1, 100)
    assert steps == [0] * 20 + [1] * 20 + [0] * 10
    assert {status for _, status in told} == {Status.TRACKED}


def test_a_long_way_back_is_spread_over_the_frames_that_come_before_one_cannot_wait():
    kinds = ["coil"] * 20 + ["open"] * 30
    told, steps = told_in_steps(kinds, 1, 25)
    assert steps == [0] * 20 + [8, 8, 4] + [0] * 27  # and there again, for all it knows
    assert {status for _, status in told} == {Status.TRACKED}
    assert told == told_in_steps(kinds, None, 25)[0]


def test_where_no_frame_can_wait_all_of_the_way_is_gone_at_once():
    _, steps = told_in_steps(["coil"] * 20 + ["open"] * 3, 1, 20)
    assert steps == [0] * 20 + [20] + [0] * 2


def test_what_was_told_by_another_body_is_taken_back():
    queue = queue_of(midline(kept=SEEN), midline(kept=SEEN), coil())
    queue.link_open()
    queue.reopen()
    queue.push(PendingFrame(3, 3 * FRAME_NS, midline(kept=SEEN), None))
    (run,) = queue.coils()
    assert [pending.frame for pending in run.frames] == [0, 1, 2]
    assert not any(pending.observation.has_midline for pending in run.frames)
