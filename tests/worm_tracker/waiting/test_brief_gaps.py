"""An end that is hidden for a moment is told from where it was before and after."""

from dataclasses import replace

import numpy as np
import pytest
from hairpin_frames import (
    FRAMES,
    HIDDEN,
    MIDDLE,
    NODES,
    film,
    folded,
    gap_of,
    hairpin,
    with_end_hidden,
    with_end_off,
)
from hypothesis import given
from hypothesis import strategies as st
from waiting_frames import SEEN, WIDTH

from worm_msgs_py import Status
from worm_tracker.observation import Observation
from worm_tracker.waiting.brief_gaps import BriefGaps, BriefGapSettings, told_over_gap
from worm_tracker.waiting.frame_state import PendingFrame


def followed_only(frame, off_widths=0.0, *, turned=False):
    body = folded(frame, points=hairpin(frame) + np.array([0.0, off_widths * WIDTH]))
    body = body.reversed() if turned else body
    return Observation(Status.COILED, 200.0, 100.0, unresolved=SEEN, followed=body)


def told_in_the_middle(frames):
    return told_over_gap(frames, MIDDLE, BriefGapSettings())


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("off_widths", [0.0, 0.6, 3.0])
def test_an_end_hidden_for_a_moment_is_told_where_it_moved_wherever_it_was_supposed(
    count, off_widths
):
    told = told_in_the_middle(film(gap_of(count), lambda k: with_end_hidden(k, off_widths)))
    assert told.status is Status.FOLDED
    assert told.shows_pose
    away = np.hypot(*(told.points - hairpin(MIDDLE)).T)
    assert away.max() < 0.05 * WIDTH
    assert away[:-HIDDEN].max() == 0
    assert 0.05 * WIDTH < told.end_sd_px[1] < 0.35 * WIDTH


@pytest.mark.parametrize("count", [9, 25])
@pytest.mark.parametrize("off_widths", [0.0, 0.6])
def test_an_end_hidden_for_longer_is_told_midway_to_where_it_was_supposed(count, off_widths):
    told = told_in_the_middle(film(gap_of(count), lambda k: with_end_hidden(k, off_widths)))
    assert told.shows_pose
    away = np.hypot(*(told.points - hairpin(MIDDLE)).T)
    assert away[-HIDDEN:].max() == pytest.approx(0.5 * off_widths * WIDTH, abs=0.05 * WIDTH)
    assert away[:-HIDDEN].max() == 0


@pytest.mark.parametrize("count", [9, 25])
def test_an_end_hidden_for_longer_is_not_told_where_it_was_supposed_elsewhere(count):
    frames = film(gap_of(count), lambda k: with_end_hidden(k, 0.9))
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


def test_the_longer_an_end_is_hidden_the_less_sure_it_is():
    sds = [told_in_the_middle(film(gap_of(count))).end_sd_px[1] for count in (1, 3, 5)]
    assert np.all(np.diff(sds) > 0)


def beside_its_way_before_it_hid(off_widths):
    """The last frame that shows it has it most of a width aside, as if it went that way."""
    hidden = gap_of(5)
    frames = film(hidden, lambda k: with_end_hidden(k, off_widths))
    last = frames[hidden[0] - 1].observation
    last.points[-HIDDEN:, 1] += np.linspace(0, 0.8 * WIDTH, HIDDEN)
    return frames


def test_an_end_that_was_told_beside_its_way_before_it_hid_is_not_told_by_how_it_moved():
    frames = beside_its_way_before_it_hid(1.5)
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


def test_it_is_told_midway_to_a_straight_way_where_it_was_supposed_near_there():
    told = told_in_the_middle(beside_its_way_before_it_hid(0.0))
    assert told.shows_pose
    away = np.hypot(*(told.points - hairpin(MIDDLE)).T)
    assert away.max() == pytest.approx(0.2 * WIDTH, abs=0.02 * WIDTH)


def either_way(frames, *, turned):
    for frame in frames if turned else []:
        frame.observation = frame.observation.reversed()
    return frames


@pytest.mark.parametrize("turned", [False, True])
def test_an_end_that_does_not_join_the_rest_of_its_body_is_not_told(turned):
    """What is shown of it lies elsewhere than in the frames about it."""

    def aside(k):
        seen = with_end_hidden(k)
        away = np.array([0.0, WIDTH]) if k == MIDDLE else 0.0
        return replace(seen, points=seen.points + away)

    frames = either_way(film(gap_of(5), aside), turned=turned)
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


def laid_short(frame, short_widths=1.0, **more):
    """Its tail is under the body, and it was followed as if that ended sooner."""
    seen = with_end_hidden(frame, **more)
    s = np.arange(NODES) * 260.0 / (NODES - 1)
    shorter = np.linspace(0, 260.0 - short_widths * WIDTH, NODES)
    return replace(
        seen, points=np.stack([np.interp(shorter, s, each) for each in seen.points.T], 1)
    )


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("short", [gap_of(5), [MIDDLE]])
def test_an_end_of_a_body_that_was_followed_short_is_told_where_it_moved(short, turned):
    """What is shown of it lies where the frames about it have it, but for the places along it."""
    frames = film(gap_of(5), lambda k: laid_short(k) if k in short else with_end_hidden(k))
    told = told_in_the_middle(either_way(frames, turned=turned))
    assert told.status is Status.FOLDED
    line = hairpin(MIDDLE)[:: -1 if turned else 1]
    assert np.hypot(*(told.points - line).T).max() < 0.1 * WIDTH
    steps = np.hypot(*np.diff(told.points, axis=0).T)
    assert steps.max() < 1.1 * np.median(steps)


def test_a_loop_in_doubt_stays_where_it_is_in_a_body_that_was_followed_short():
    loop = (50, 80)
    frames = film(gap_of(5), lambda k: laid_short(k, in_doubt=loop))
    told, body = told_in_the_middle(frames), frames[MIDDLE].observation
    assert told.status is Status.LOOP_IN_DOUBT
    for one, other in ((told.in_doubt[0], loop[0]), (told.in_doubt[1] - 1, loop[1] - 1)):
        away = np.hypot(*(told.points[one] - body.points[other]).T)
        assert away < 260.0 / (NODES - 1)


def test_what_too_few_frames_tell_next_to_an_end_is_moved_along_with_it():
    """Frames beside the gap hide more of the tail or less, so that few tell the same points."""
    hidden = gap_of(5)
    frames = film(hidden, lambda k: with_end_hidden(k, 1.0))
    for k in (*range(34, 38), *range(43, 47)):
        doubt = (NODES - 8, NODES - 4)
        frames[k].observation = replace(folded(k), status=Status.LOOP_IN_DOUBT, in_doubt=doubt)
    told = told_in_the_middle(frames)
    assert told.shows_pose
    assert np.hypot(*(told.points - hairpin(MIDDLE)).T).max() < 0.05 * WIDTH


@pytest.mark.parametrize(
    "frames",
    [
        pytest.param(film(gap_of(27)), id="hidden for longer than a second"),
        pytest.param(film(gap_of(11), frames_per_s=10.0), id="the same at ten frames a second"),
        pytest.param(film([*range(31, 37), *range(38, 42)]), id="one frame tells it before"),
        pytest.param(film([*range(39, 42), *range(43, 50)]), id="one frame tells it after"),
        pytest.param(film([36, 37, 38, 40, *range(42, 50)]), id="too few about a moment"),
        pytest.param(film(range(39, 42), leaps_from=43), id="it leaps soon after"),
        pytest.param(film(range(MIDDLE, FRAMES)), id="never told after"),
        pytest.param(film(range(MIDDLE + 1)), id="never told before"),
    ],
)
def test_an_end_is_not_told_where_its_way_is_not_known(frames):
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


@pytest.mark.parametrize("hidden", [[40, *range(42, 50)], [*range(31, 39), 40], [40, 42, 43]])
def test_an_end_hidden_in_one_picture_is_told_by_three_about_it_wherever_they_are(hidden):
    told = told_in_the_middle(film(hidden))
    assert told.status is Status.FOLDED
    away = np.hypot(*(told.points - hairpin(MIDDLE)).T)
    assert away.max() < 0.05 * WIDTH


@pytest.mark.parametrize("seen_so", [with_end_hidden, followed_only])
def test_an_end_that_may_be_bent_back_stays_hidden(seen_so):
    """It was supposed at its bend, and the bend is on the way."""

    def bent_back(k):
        seen = seen_so(k)
        if seen.followed is None:
            return replace(seen, broad_ends=(False, True))
        return replace(seen, followed=replace(seen.followed, broad_ends=(False, True)))

    frames = film(gap_of(3), bent_back)
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


def test_an_end_that_anything_but_the_body_hides_stays_hidden():
    """A hand, or glare: nothing was seen of it by which it could be supposed."""

    def stretched(k):
        line = np.stack([np.linspace(0, 260, NODES) + k, np.full(NODES, 100.0)], axis=1)
        return replace(with_end_hidden(k), points=line, unresolved=None)

    frames = film(gap_of(3), stretched)
    assert told_in_the_middle(frames) is frames[MIDDLE].observation


@pytest.mark.parametrize("turned", [False, True])
def test_a_body_that_was_followed_only_is_told_in_the_order_of_those_beside_it(turned):
    frames = film(gap_of(5), lambda k: followed_only(k, 0.4, turned=turned))
    told = told_in_the_middle(frames)
    assert told.status is Status.FOLDED
    assert np.hypot(*(told.points - hairpin(MIDDLE)).T).max() < 0.25 * WIDTH


def test_a_body_that_was_followed_elsewhere_for_a_moment_is_not_told():
    told = told_in_the_middle(film(gap_of(5), lambda k: followed_only(k, 1.0)))
    assert told.status is Status.COILED


def test_a_loop_in_doubt_stays_so_where_an_end_is_told():
    frames = film(gap_of(5), lambda k: with_end_hidden(k, in_doubt=(40, 80)))
    told = told_in_the_middle(frames)
    assert told.status is Status.LOOP_IN_DOUBT
    assert told.in_doubt == (40, 80)
    assert told.occluded == (0, 0)


@given(
    st.lists(
        st.sampled_from(["told", "off", "hidden", "aside", "followed", "nothing"]), max_size=60
    ),
    st.lists(st.integers(0, 20), max_size=8),
)
def test_what_is_told_does_not_hang_on_how_many_frames_leave_at_once(kinds, counts):
    how = {
        "told": folded,
        "off": with_end_off,
        "hidden": with_end_hidden,
        "aside": lambda k: with_end_hidden(k, 0.9),
        "followed": followed_only,
        "nothing": lambda k: Observation(Status.NO_WORM),
    }
    frames = [PendingFrame(k, 40_000_000 * k, how[kind](k), None) for k, kind in enumerate(kinds)]
    at_once = BriefGaps(BriefGapSettings()).tell(frames, len(frames))
    gaps, told = BriefGaps(BriefGapSettings()), []
    for count in [*counts, len(frames)]:
        some = min(count, len(frames) - len(told))
        told += gaps.tell(frames[len(told) :], some)
    assert [one.status for one in told] == [one.status for one in at_once]
    for one, other in zip(told, at_once, strict=True):
        assert np.array_equal(one.points, other.points)
        assert one.occluded == other.occluded


@given(st.lists(st.integers(-200, 200), min_size=9, max_size=9))
def test_stamps_that_do_not_increase_tell_nothing_false(jitter_ms):
    frames = [
        replace(each, stamp_ns=each.stamp_ns + 1_000_000 * late)
        for each, late in zip(film([MIDDLE])[36:45], jitter_ms, strict=True)
    ]
    told = told_over_gap(frames, 4, BriefGapSettings())
    away = np.hypot(*(told.points - hairpin(MIDDLE)).T)
    assert away.max() < 0.4 * WIDTH


@given(st.lists(st.booleans(), min_size=3, max_size=40))
def test_what_a_frame_tells_itself_is_never_moved(hides):
    frames = [
        PendingFrame(k, 40_000_000 * k, (with_end_hidden if hidden else folded)(k), None)
        for k, hidden in enumerate(hides)
    ]
    told = BriefGaps(BriefGapSettings()).tell(frames, len(frames))
    for frame, one in zip(frames, told, strict=True):
        seen = frame.observation
        own = slice(None, NODES - seen.occluded[1])
        assert np.array_equal(one.points[own], seen.points[own])
        if seen.status is Status.FOLDED:
            assert one.occluded[1] or np.array_equal(one.points, seen.points)


def ready_of(frames, first, newest_s=0.0):
    """How many frames from one on need not wait, when the last of them have come."""
    gaps = BriefGaps(BriefGapSettings())
    newest_ns = frames[-1].stamp_ns + round(1e9 * newest_s)
    return gaps.ready(frames[first:], len(frames) - first, newest_ns)


def test_only_a_frame_of_a_fold_that_has_no_pose_waits():
    assert ready_of(film([]), 0) == FRAMES
    assert ready_of(film(range(70, FRAMES)), 0) == 70
    assert ready_of(film(range(70, FRAMES), followed_only), 0) == 70
    gone = [PendingFrame(k, 40_000_000 * k, Observation(Status.NO_WORM), None) for k in range(9)]
    assert ready_of(gone, 0) == 9


@pytest.mark.parametrize("hidden", [1, 3, 12])
def test_a_frame_waits_until_enough_of_those_after_it_tell_where_its_end_was(hidden):
    """It is told as it is once all are known."""
    all_known = film(gap_of(hidden))
    first = gap_of(hidden)[0]
    told = told_over_gap(all_known, first, BriefGapSettings())
    behind = next(b for b in range(first + 1, FRAMES) if ready_of(all_known[:b], first) > 0)
    assert behind == first + hidden + 5
    assert np.array_equal(
        told.points, told_over_gap(all_known[:behind], first, BriefGapSettings()).points
    )


def test_a_frame_waits_no_longer_than_a_gap_may_be():
    frames = film(range(MIDDLE, FRAMES))
    reach_s = BriefGapSettings().ways.reach_s
    assert ready_of(frames[: MIDDLE + 1], MIDDLE, reach_s - 0.01) == 0
    assert ready_of(frames[: MIDDLE + 1], MIDDLE, reach_s + 0.01) == 1


def told_all(frames):
    return BriefGaps(BriefGapSettings()).tell(frames, len(frames))


@pytest.mark.parametrize("frames_per_s", [25.0, 50.0])
@pytest.mark.parametrize("off_widths", [0.0, 1.5])
def test_an_end_that_one_frame_tells_amid_those_that_hide_it_is_hidden(frames_per_s, off_widths):
    """It may be anywhere: told so, nothing says that it is wrong."""
    hidden = set(range(5, 76)) - {MIDDLE}
    frames = film(hidden, frames_per_s=frames_per_s)
    frames[MIDDLE].observation.points[-HIDDEN:, 1] += off_widths * WIDTH
    one = told_all(frames)[MIDDLE]
    assert one.status is Status.END_HIDDEN
    assert one.occluded[0] == 0 < one.occluded[1]


@pytest.mark.parametrize("count", [3, 4, 9])
def test_an_end_that_frames_in_a_row_tell_is_told(count):
    hidden = set(range(10, 70)) - set(gap_of(count))
    told = told_all(film(hidden))
    assert all(told[k].status is Status.FOLDED for k in gap_of(count))


def test_a_frame_waits_for_those_after_it_where_those_before_it_hide_its_end():
    frames = film(range(MIDDLE))
    ready = [
        ready_of(frames[: MIDDLE + 1 + more], MIDDLE, newest_s=0.04 * more) for more in range(6)
    ]
    assert ready == [0, 0, 0, 0, 5, 6]


def test_what_is_told_alone_tells_no_gap_beside_it():
    """Two frames that tell an end amid many that hide it: what is between is not known by them."""
    hidden = set(range(2, 79)) - {30, 31, 44, 45}
    told = told_all(film(hidden))
    assert all(told[k].status is Status.END_HIDDEN for k in range(30, 46))


@pytest.mark.parametrize("status", [Status.BAD_IMAGE, Status.NO_WORM])
def test_pictures_that_show_no_worm_hide_no_end(status):
    frames = film(set(range(FRAMES)) - {MIDDLE}, lambda k: Observation(status))
    assert told_all(frames)[MIDDLE].status is Status.FOLDED
